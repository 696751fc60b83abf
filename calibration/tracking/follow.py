"""Objects that move in a film, followed from frame to frame: a track for each.

One pass; what is kept of a frame is where objects are in it. What differs from the background is a
blob (see background.py, blobs.py), blobs are linked to paths (linking.py). Paths become tracks in
pixels of the film: the camera's own motion is taken off (camera_motion.py), time comes from stamps
that can be believed (stamps.py).
"""

from contextlib import closing
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from calibration.tracking.camera_motion import lasting_motion, offsets, scaled
from calibration.tracking.clean import clean_background
from calibration.tracking.film.reader import Film, Progress, Region, inside
from calibration.tracking.film.stamps import clean_stamps
from calibration.tracking.linking import Path
from calibration.tracking.search import Notes, Search
from calibration.tracking.segments import misfit, noise
from calibration.tracking.track import Array, Look, Track
from granulab.errors import InputError

_POINTED = 3  # own radii by which a hint may miss an object
_MOVES = 1.0  # px of the picture measured in, from which the camera's motion is taken off
_FEWEST = 8  # positions of a track
_LIKELIER = 2 * np.log(20)  # of misfit: one in twenty by chance


class Hint(NamedTuple):
    """Position of an object in some frame [px]."""

    frame: float
    x: float
    y: float


def follow(
    film: Film,
    *,
    roi: Region | tuple[int, int, int, int] | None = None,
    hint: Hint | tuple[float, float, float] | None = None,
    progress: Progress | None = None,
    overlapping: bool = False,
) -> list[Track]:
    """Tracks of all objects that move as wholes, that which went farthest first.

    roi       x, y, width, height of the part of the picture to look at [px]
    hint      frame, x, y of the object wanted: its track alone
    progress  receives the share done and a few words
    overlapping   objects may move by less than their size: the film is read twice

    x, y are in pixels of the film, y downwards, the centre of the first pixel is 0, 0; where the
    camera moves they are positions in its first frame. Raises InputError where nothing moves.
    """
    region = inside(film, roi)
    if hint is not None:
        _refuse_beyond(film, Hint(*hint))
    notes = Notes()
    clean = clean_background(film, region) if overlapping else None
    search = Search(region.width, region.height, clean)
    with closing(film.frames()) as frames:
        for frame in frames:
            picture = frame.picture[
                region.y : region.y + region.height, region.x : region.x + region.width
            ]
            search.look(frame.number, picture, notes)
            notes.numbers.append(frame.number)
            notes.stamps.append(frame.stamp)
            if progress is not None and film.count:
                progress(frame.number / film.count, f"frame {frame.number} of {film.count}")
    tracks = tracks_of(film, search, notes, region)
    if not tracks and len(notes.junk) + len(notes.views) > len(notes.numbers) / 4:
        raise InputError(
            f"{film.path}: the picture changes as a whole again and again (lamps that flicker in "
            "bands, a camera that moves, cuts, noise): nothing can be followed"
        )
    if not tracks:
        raise InputError(f"{film.path}: nothing moves in {len(notes.numbers)} frames")
    return [_nearest(film, tracks, Hint(*hint))] if hint is not None else tracks


def _refuse_beyond(film: Film, hint: Hint) -> None:
    """InputError for a hint that no frame of the film holds, before it is read."""
    if hint.frame < 0 or 0 < film.count <= hint.frame:
        known = f"0 to {film.count - 1}" if film.count else "0 and more"
        raise InputError(f"{film.path}: no frame {hint.frame:g} for --at; frames are {known}")
    if not (0 <= hint.x < film.width and 0 <= hint.y < film.height):
        raise InputError(
            f"{film.path}: x = {hint.x:g}, y = {hint.y:g} px of --at lies outside the picture, "
            f"{film.width} x {film.height} px"
        )


def _nearest(film: Film, tracks: list[Track], hint: Hint) -> Track:
    """The track that the hint points at."""

    def off(track: Track) -> float:
        """In radii; before it moves an object is where its track begins."""
        k = int(np.argmin(np.abs(track.frame - hint.frame)))
        late = max(hint.frame - float(track.frame[k]), 0.0)
        assert track.radius is not None
        away = np.hypot(track.x[k] - hint.x, track.y[k] - hint.y)
        return float(away / track.radius[k]) + late

    best = min(tracks, key=off)
    if off(best) > _POINTED:
        raise InputError(
            f"{film.path}: nothing that moves is near x = {hint.x:g}, y = {hint.y:g} px in frame "
            f"{hint.frame:g}"
        )
    return best


def tracks_of(film: Film, search: Search, notes: Notes, region: Region) -> list[Track]:
    """Of all objects that move, that which went farthest first."""
    time, remarks = clean_stamps(notes.numbers, notes.stamps, film.rate)
    whole = scaled(np.array(notes.motion), *search.scale)
    motion, remark = lasting_motion(whole, region.width, region.height, _MOVES * search.scale[0])
    remarks += [*_remarks(film, notes), *([remark] if remark else [])]
    moving = sorted(
        (one for one in search.linker.paths() if one.is_smooth()), key=lambda one: -one.length
    )
    row = {number: k for k, number in enumerate(notes.numbers)}
    tracks: list[Track] = []
    for path in moving:
        track = _track(path, search.scale, region)
        if len(track.frame) < _FEWEST:
            continue
        at = np.array([row[int(n)] for n in track.frame], dtype=int)
        if motion is not None:
            offset = offsets(motion[at], track.x, track.y)
            x, y = track.x - offset[:, 0], track.y - offset[:, 1]
            track = replace(track, x=x, y=y, camera=offset)
        when = None if time is None else time[at]
        name = str(len(tracks) + 1)
        tracks.append(replace(track, time=when, name=name, remarks=(*remarks, *track.remarks)))
    return tracks


def _track(path: Path, scale: tuple[float, float], region: Region) -> Track:
    """In pixels of the film, without positions in which the object was not whole."""
    area = np.array([one.area for one in path.blobs])
    kept = np.flatnonzero(_usual(area) & [one.whole for one in path.blobs])
    blobs = [path.blobs[k] for k in kept]
    fx, fy = scale
    remarks: tuple[str, ...] = ()
    x = np.array([region.x + (one.x + 0.5) * fx - 0.5 for one in blobs])
    y = np.array([region.y + (one.y + 0.5) * fy - 0.5 for one in blobs])
    shadow = np.array([one.shadow for one in blobs]).reshape(-1, 2) * (fx, fy)
    new = np.array([one.changed for one in blobs], dtype=bool)  # copies are on no parabola
    if _flies_out_of(shadow[new], np.array(path.frames, dtype=float)[kept][new], y[new]):
        x, y = x + shadow[:, 0], y + shadow[:, 1]
        remarks = ("the object's own shadow lies behind its blurred edge: taken off",)
    covariance = np.array(
        [[[one.xx * fx**2, one.xy * fx * fy], [one.xy * fx * fy, one.yy * fy**2]] for one in blobs]
    ).reshape(-1, 2, 2)
    radius = np.sqrt(area[kept] * fx * fy / np.pi)
    frame = np.array([path.frames[k] for k in kept], dtype=float)
    repeated = tuple(float(path.frames[k]) for k in kept if not path.blobs[k].changed)
    colour = np.array([one.colour for one in blobs]).reshape(-1, 3)
    behind = np.array([one.behind for one in blobs]).reshape(-1, 3)
    grain = float(np.median([one.grain for one in blobs])) if blobs else 0.0
    look = Look(np.median(colour, axis=0), np.median(behind, axis=0), grain) if blobs else None
    profile = np.array([one.profile for one in blobs], dtype=float) * np.sqrt(fx * fy)
    return Track(
        frame,
        x,
        y,
        None,
        covariance,
        radius=radius,
        profile=profile,
        look=look,
        repeated=repeated,
        remarks=remarks,
    )


def _flies_out_of(shadow: Array, frame: Array, y: Array) -> bool:
    """True if the path is made of parabolas the likelier without what a shadow adds to it."""
    if len(y) < _FEWEST or not shadow[:, 1].any():
        return False
    sigma = min(noise(frame, one) for one in (y, y + shadow[:, 1]))
    as_seen, without = (misfit(frame, one, sigma) for one in (y, y + shadow[:, 1]))
    return without < as_seen - _LIKELIER


def _usual(area: Array) -> np.ndarray:
    """True if each area is near those around it: else two objects are one blob, or one is cut."""
    from scipy.ndimage import median_filter

    off = np.abs(np.log(area / median_filter(area, size=min(31, len(area)), mode="nearest")))
    return np.asarray(off < max(np.log(1.25), 5 * float(np.median(off))))


def _remarks(film: Film, notes: Notes) -> list[str]:
    """Remarks on what was wrong with the file."""
    remarks = []
    read = len(notes.numbers)
    if film.corrupt:
        remarks.append(f"{len(film.corrupt)} frames cannot be decoded: left out")
    if notes.junk:
        remarks.append(f"{len(notes.junk)} frames show something else: left out")
    if notes.views:
        remarks.append(f"the view changes at frame {', '.join(map(str, notes.views))}")
    if film.count > read + len(film.corrupt):
        remarks.append(
            f"the header says {film.count} frames, {read} can be read: damaged or cut off"
        )
    return remarks
