"""The one or two tracks of a clip that are objects on strings: read, chosen, on common frames.

Frames that repeat the one before are left out, and the time for which the object is held.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.files.track_table import read_tracks, refuse_units
from calibration.pendulum.chain import refuse_more_than_two
from calibration.pendulum.colours import by_colour
from calibration.pendulum.contacts import FEWEST, found_swings
from calibration.statistics.repeated import repeated
from calibration.tracking.film.reader import Film, Progress, is_film, open_film, said_rate
from calibration.tracking.segments import noise
from calibration.tracking.track import Array, Rows, Track
from granulab.errors import InputError

_NEAR = 4  # steps on either side that say how fast the object goes
_SAME = 0.1  # of the usual step: a picture shown again, within what compression changes
_STILL = 4  # times the noise: what moves less is held
_MOST = 4  # tracks that are looked at, of those that go farthest
_MOVES = 0.05  # of the widest track's range: what moves less is no object that swings
_SURE = 5  # sigma by which a velocity must change at a contact
_UPRIGHT = 2  # times as far along y as along x: no swing, or a film that is rotated


def repeats(t: Array, gap: Array) -> tuple[Rows, NDArray[np.bool_]]:
    """Positions that repeat the one before in a swing; and whether the clock ran on in vain."""
    from scipy.ndimage import median_filter

    step = np.diff(gap)
    usual = median_filter(step, 2 * _NEAR + 1, mode="nearest")
    return repeated(step, np.abs(step) < _SAME * np.abs(usual), noise(t, gap))


def held_until(t: Array, gap: Array) -> int | None:
    """The last of the first positions that are one within the noise; None for fewer than three."""
    off = np.abs(gap - np.median(gap[:3])) > _STILL * noise(t, gap)
    first = int(np.argmax(off)) if off.any() else 0
    return first - 1 if first > 3 else None


@dataclass(frozen=True)
class Objects:
    """b objects on n common frames, from left to right.

    t          (n,) clock [frames]
    frame      (n,) numbers in the file
    x, y       (b, n) [px, or m where the table has a unit]
    radius     (b, n) apparent size [px]; None where it is not known
    rate       frames/s used, and what the file says; None where not known
    """

    name: str
    source: Path | None
    tracks: tuple[Track, ...]
    t: Array
    frame: Array
    x: Array
    y: Array
    radius: Array | None
    rate: float | None
    rate_header: float | None
    remarks: tuple[str, ...] = ()
    repeated: tuple[float, ...] = ()
    time_remarks: tuple[str, ...] = ()

    @property
    def gap(self) -> Array:
        """(n,) the second's distance from the first along x; the position of one alone."""
        return np.asarray(self.x[-1] - self.x[0] if len(self.x) == 2 else self.x[0])

    @property
    def unit(self) -> str:
        """Of x and y."""
        return "m" if self.tracks[0].scale == 1 else "px"


def objects_in(
    source: str | Path | Track | Sequence[Track],
    *,
    fps: float | None = None,
    names: Sequence[str] = (),
    roi: tuple[int, int, int, int] | None = None,
    progress: Progress | None = None,
    units: Mapping[str, str] | None = None,
) -> Objects:
    """Objects that swing in a film, a table or tracks; see measure_pendulum. Raises InputError."""
    fps = said_rate(fps)
    path = Path(source) if isinstance(source, str | Path) else None
    where = "" if path is None else f"{path}: "
    tracks = _read(source, roi, progress, units)
    if names:
        tracks = _named(tracks, names, where)
    try:
        if path is None or not is_film(path):
            refuse_more_than_two(tracks)
        found = _chosen(tracks)
    except InputError as error:
        raise InputError(f"{where}{error}") from None
    header = found.tracks[0].rate
    name = (path.stem or path.parent.name) if path is not None else found.tracks[0].name
    return replace(
        put_right(found), name=name or "track", source=path, rate=fps or header, rate_header=header
    )


def _read(
    source: str | Path | Track | Sequence[Track],
    roi: tuple[int, int, int, int] | None,
    progress: Progress | None,
    units: Mapping[str, str] | None,
) -> list[Track]:
    if isinstance(source, Track):
        return [source]
    if not isinstance(source, str | Path):
        return list(source)
    if not is_film(source):
        if roi is not None:
            raise InputError(f"{source}: --roi is a part of a film; this is a table")
        return read_tracks(source, units)
    refuse_units(source, units)
    return _of_film(open_film(source), roi, progress)


def _of_film(
    film: Film, roi: tuple[int, int, int, int] | None, progress: Progress | None
) -> list[Track]:
    """By colour; where no colour is that of what moves (grey on grey), by what moves."""
    from calibration.tracking.film.reader import inside
    from calibration.tracking.follow import follow

    region = inside(film, roi)
    try:
        tracks = by_colour(film, roi=region, progress=progress)
        _chosen(tracks)
    except InputError:
        return follow(film, roi=region, progress=progress)
    return tracks


def _named(tracks: list[Track], names: Sequence[str], where: str) -> list[Track]:
    known = [track.name for track in tracks]
    missing = next((name for name in names if name not in known), None)
    if missing is not None:
        raise InputError(f"{where}no track {missing!r}; there are {', '.join(map(repr, known))}")
    if len(names) > 2:
        raise InputError(f"--track: one ball or two blocks, not {len(names)}")
    return [track for track in tracks if track.name in names]


def _chosen(tracks: list[Track]) -> Objects:
    """Two that push each other at their contact; else the one that goes farthest and has one.

    Raises InputError that says why the widest track has none.
    """
    tracks = sorted((track.seen() for track in tracks), key=_range, reverse=True)
    tracks = [one for one in tracks if len(one.frame) >= 3 * FEWEST][:_MOST]
    if not tracks:
        raise InputError(f"no track of {3 * FEWEST} positions: two swings and a contact need them")
    if np.ptp(tracks[0].y) > _UPRIGHT * np.ptp(tracks[0].x):
        raise InputError(
            "it moves along y more than along x: no swing seen from the side (a film that is "
            "rotated must be put upright)"
        )
    moving = [one for one in tracks if _range(one) > _MOVES * _range(tracks[0])]
    if not moving:
        raise InputError("nothing moves along x: a swing is seen from the side")
    pairs = [found for pair in combinations(moving, 2) if (found := _pair(pair)) is not None]
    if pairs:
        return max(pairs, key=lambda pair: float(np.ptp(pair.gap)))
    failures = []
    for one in moving:
        found = _together((one,))
        try:
            found_swings(found.t, found.gap)
        except InputError as error:
            failures.append(error)
            continue
        return found
    raise failures[0]


def _range(track: Track) -> float:
    """Range of a track along x, without the farthest hundredth: a bad position is no swing."""
    return float(np.subtract(*np.percentile(track.x, [99.5, 0.5]))) if len(track.x) else 0.0


def _pair(pair: tuple[Track, Track]) -> Objects | None:
    """Both on common frames where their velocities change at their contact, in opposite ways.

    An object and its shadow change in the same way.
    """
    found = _together(pair)
    if len(found.t) < 3 * FEWEST:
        return None
    try:
        time = found_swings(found.t, found.gap)[0][0]
    except InputError:
        return None
    jumps = [_jump(found.t, x, time) for x in found.x]
    if all(abs(jump) > _SURE * sigma for jump, sigma in jumps) and jumps[0][0] * jumps[1][0] < 0:
        return found
    return None


def _jump(t: Array, x: Array, time: float) -> tuple[float, float]:
    """Change of the velocity at a contact, from the points next to it, and its sigma."""
    half = float(np.median(np.diff(t))) / 2
    slopes = []
    for side in (t < time - half, t > time + half):
        rows = np.flatnonzero(side)
        rows = rows[-FEWEST - 1 :] if t[rows[0]] < time else rows[: FEWEST + 1]
        slopes.append((np.polyfit(t[rows], x[rows], 1)[0], np.sum((t[rows] - t[rows].mean()) ** 2)))
    (before, a), (after, b) = slopes
    return float(after - before), noise(t, x) * float(np.sqrt(1 / a + 1 / b))


def _together(tracks: Sequence[Track]) -> Objects:
    """Tracks on the frames that all have, from left to right."""
    frames = tracks[0].frame
    for one in tracks[1:]:
        frames = np.intersect1d(frames, one.frame)
    rows = [np.flatnonzero(np.isin(one.frame, frames)) for one in tracks]
    each = [one.chosen(kept) for one, kept in zip(tracks, rows, strict=True)]
    each.sort(key=lambda one: float(np.median(one.x)) if len(one.x) else 0.0)
    known = [one.radius for one in each if one.radius is not None]
    return Objects(
        "", None, tuple(each), each[0].clock if len(frames) else frames, frames,
        np.array([one.x for one in each]), np.array([one.y for one in each]),
        np.array(known) if len(known) == len(each) else None, None, None,
        tuple(dict.fromkeys(remark for one in each for remark in one.remarks)),
    )  # fmt: skip


def put_right(objects: Objects) -> Objects:
    """Without positions that repeat the one before in a swing, and without the time they take."""
    rows, late, remarks = *repeats(objects.t, objects.gap), []
    copied = {float(frame) for one in objects.tracks for frame in one.repeated}
    numbers = sorted(copied | {float(objects.frame[k]) for k in rows})
    held = held_until(objects.t, objects.gap)
    if held is not None:
        remarks.append(
            f"held until frame {objects.frame[held]:g}: what the clock does until then is not used"
        )
    clock = objects.t.copy()
    for k in rows[late]:
        clock[k:] -= 1
    if len(rows):
        remarks.append(
            f"{len(rows)} positions repeat the one before in a swing: left out, "
            f"{int(late.sum())} of them took no time"
        )
    kept = np.setdiff1d(np.arange(len(clock)), rows)
    radius = None if objects.radius is None else objects.radius[:, kept]
    return replace(
        objects, t=clock[kept], frame=objects.frame[kept], x=objects.x[:, kept],
        y=objects.y[:, kept], radius=radius, repeated=tuple(numbers), time_remarks=tuple(remarks),
    )  # fmt: skip
