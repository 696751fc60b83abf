"""measure_drop: a film or a track of a bouncing object to restitution, speeds, scale and rate."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from calibration.drop.bounce import Bounces
from calibration.drop.choice import the_one_that_bounces
from calibration.drop.drag import with_drag
from calibration.drop.fall import speed_of_a_unit, with_free_fall
from calibration.drop.first import may_overlap, with_first
from calibration.drop.result import Drop
from calibration.files.track_table import read_tracks, refuse_units
from calibration.result import checked, draw
from calibration.statistics.quantity import measured_quantity, metres_per_pixel
from calibration.statistics.uncertainty import Estimate
from calibration.tracking.film.reader import (
    Film,
    Progress,
    is_film,
    is_pattern,
    open_film,
    said_rate,
)
from calibration.tracking.track import Track
from granulab.contact.material import Measured
from granulab.errors import InputError


def measure_drop(
    source: str | Path | Track | Sequence[Track],
    *,
    fps: float | None = None,
    scale: str | float | None = None,
    track: str | None = None,
    one_bounce: bool = False,
    terminal_speed: str | None = None,
    roi: tuple[int, int, int, int] | None = None,
    hint: tuple[float, float, float] | None = None,
    progress: Progress | None = None,
    out: str | Path | None = None,
    units: Mapping[str, str] | None = None,
) -> Drop:
    """Restitution of an object that falls on a plate and bounces, from its track.

    source      a film (see film/reader.py), a track table (see track_table), or tracks
    fps         frames per second of the camera; overrides what time stamps say
    scale       "0.81 mm/px", or metres per unit of x and y
    track       name of the track, where several objects bounce
    one_bounce  take a clip with a single bounce: eq. 3.5 without a check of one bounce by another
    terminal_speed
                at which its fall in air would end, "45 m/s +- 10 %"; else as the track allows
    roi         x, y, width, height of the part of a film to look at [px]
    hint        frame, x, y [px] of the object in a film
    progress    receives the share of a film that is read, and a few words
    out         folder for the diagnostic figure and the annotated film
    units       of the columns of a table: {"time": "ms", "x": "mm", "y": "mm"}

    Raises InputError, one line, for what cannot be measured.
    """
    where = f"{source}: " if isinstance(source, str | Path) else ""
    length = _metres(scale)
    terminal = _speed(terminal_speed)
    fps = said_rate(fps)
    film = open_film(source) if isinstance(source, str | Path) and is_film(source) else None
    if film is not None:
        refuse_units(film.path, units)
    elif roi is not None or hint is not None:
        option = "--roi" if hint is None else "--at"
        raise InputError(f"{where}{option} is of a film's pictures; this is a table")

    def read(overlapping: bool) -> list[Track]:
        if film is None:
            return _tracks(source, units)
        return _followed(film, roi, hint, progress, overlapping)

    choose = partial(the_one_that_bounces, name=track, one_bounce=one_bounce, where=where)
    found = _chosen(read, choose, film is not None, source, out)
    if length is not None and found.track.scale is not None:
        raise InputError(f"{where}--scale: the unit of y stands in the table's head already")
    length = found.track.scale if length is None else length
    found, first = with_first(with_drag(found, _slowness(terminal, found, fps, length, where)))
    drop = with_free_fall(found, fps, length, None if film is None else film.rate)
    drop = replace(drop, first=first)
    checked(drop.to_dict(), [source] if isinstance(source, str | Path) else ())
    if out is None:
        return drop
    return with_pictures(drop, source, Path(out), progress)


def _speed(text: str | None) -> Measured | None:
    return None if text is None else measured_quantity(text, "m/s", "--terminal-speed")


def _chosen(
    read: Callable[[bool], list[Track]], choose: Callable[[list[Track]], Bounces], filmed: bool,
    source: str | Path | Track | Sequence[Track], out: str | Path | None,
) -> Bounces:  # fmt: skip
    """The bounces that the test is about; where there are none, what was seen is drawn.

    read    all tracks, of a film also as of an object that overlaps itself
    """
    seen: list[Track] = []

    def found(overlapping: bool) -> Bounces:
        seen[:] = read(overlapping)
        return choose(seen)

    try:
        return _of_film(found) if filmed else found(False)
    except InputError as refusal:
        if out is None or not seen:
            raise
        from calibration.drop.view.tracks import Refused

        name = _name_of(source, seen[0])
        sheet = draw(Refused(name, seen), Path(out) / f"drop-{name}.png")
        raise InputError(f"{refusal}; {sheet} shows what was seen") from None


def _metres(scale: str | float | None) -> float | None:
    """Metres per pixel of "0.81 mm/px" or a number."""
    if scale is None:
        return None
    if isinstance(scale, str):
        return metres_per_pixel(scale)
    if not 0 < scale < math.inf:
        raise InputError(f"--scale = {scale!r}: must be positive, such as '0.81 mm/px'")
    return scale


def _slowness(
    terminal: Measured | None, found: Bounces, fps: float | None, scale: float | None, where: str
) -> Estimate | None:
    """1/w^2 [frames^2/y^2] of a terminal speed w [m/s] that is given; None of none."""
    if terminal is None:
        return None
    unit, fastest = speed_of_a_unit(found, fps, scale), float(np.max(found.speeds[:, 0]))
    if unit is None:
        raise InputError(f"{where}--terminal-speed needs --fps or --scale: give one of them too")
    if not terminal.value > fastest * unit:
        raise InputError(
            f"{where}--terminal-speed = {terminal.value:g} m/s: must be above "
            f"{fastest * unit:.3g} m/s, as fast as it hits the plate"
        )
    slow = (unit / terminal.value) ** 2
    return Estimate(slow, 2 * slow * (terminal.sigma or 0.0) / terminal.value, 1)


def _tracks(
    source: str | Path | Track | Sequence[Track], units: Mapping[str, str] | None
) -> list[Track]:
    """All tracks of a table, or as they are."""
    if isinstance(source, Track):
        return [source]
    return read_tracks(source, units) if isinstance(source, str | Path) else list(source)


def _followed(
    film: Film, roi: tuple[int, int, int, int] | None, hint: tuple[float, float, float] | None,
    progress: Progress | None, overlapping: bool,
) -> list[Track]:  # fmt: skip
    """All tracks of a film; progress goes on from its end where it is read once more."""
    from calibration.tracking.follow import follow

    def once_more(_share: float, words: str) -> None:
        if progress is not None:
            progress(1.0, f"once more, {words}")

    shown = once_more if overlapping else progress
    return follow(film, roi=roi, hint=hint, progress=shown, overlapping=overlapping)


def _of_film(choose: Callable[[bool], Bounces]) -> Bounces:
    """The bounces that the test is about; looked for again where the object may overlap itself.

    An object that falls by a few of its own diameters covers the place that it is let go from for
    much of its fall, and is followed from the middle of it on alone, or not at all.
    """
    try:
        found = choose(False)
    except InputError as refusal:
        try:
            return choose(True)
        except InputError:
            raise refusal from None
    if not may_overlap(found):
        return found
    try:
        return choose(True)
    except InputError:
        return found


def with_pictures(
    drop: Drop,
    source: str | Path | Track | Sequence[Track],
    folder: Path,
    progress: Progress | None = None,
) -> Drop:
    """The drop test with `sheet`, drop-NAME.png, and `film`, drop-NAME.mp4, where it was filmed.

    Raises FolderError where they cannot be written.
    """
    drop = replace(drop, name=_name_of(source, drop.bounces.track))
    if isinstance(source, str | Path) and is_film(source):
        from calibration.drop.view.annotate import annotate

        film, pictures = annotate(
            drop, open_film(source), folder / f"drop-{drop.name}.mp4", progress
        )
        drop = replace(drop, film=film, pictures=tuple(pictures))
    return replace(drop, sheet=draw(drop, folder / f"drop-{drop.name}.png"))


def _name_of(source: str | Path | Track | Sequence[Track], track: Track) -> str:
    """A film's own name; of pictures "im*.png" that of their folder, of tracks that of one."""
    if not isinstance(source, str | Path):
        return track.name or "track"
    path = Path(source)
    named = path.parent if is_pattern(path) else path
    return named.resolve().stem
