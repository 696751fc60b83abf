"""Things that move in a film, followed from frame to frame: a track for each.

One pass; what is kept of a frame is where things are in it. What differs from the background is a
blob (see background.py, blobs.py), blobs are linked to things (linking.py), the camera's own motion
is taken off (camera_motion.py), time comes from stamps that can be believed (stamps.py).
"""

from typing import NamedTuple

import numpy as np

from calibration.tracking.film.reader import Film, Told
from calibration.tracking.film.region import Region, inside
from calibration.tracking.search import Notes, Search
from calibration.tracking.track import Track
from calibration.tracking.tracks import tracks_of
from granulab.errors import InputError

_POINTED = 3  # own radii by which a hint may miss a thing


class Hint(NamedTuple):
    """Where a thing is in some frame [px]."""

    frame: float
    x: float
    y: float


def follow(
    film: Film,
    *,
    roi: Region | tuple[int, int, int, int] | None = None,
    hint: Hint | tuple[float, float, float] | None = None,
    progress: Told | None = None,
) -> list[Track]:
    """Tracks of all things that move as wholes, that which went farthest first.

    roi       x, y, width, height of the part of the picture to look at [px]
    hint      frame, x, y of the thing wanted: its track alone
    progress  told the share done and a few words

    x, y are in pixels of the film, y downwards, the centre of the first pixel is 0, 0; where the
    camera moves they are places in its first frame. Raises InputError where nothing moves.
    """
    region = inside(film, roi)
    if hint is not None:
        _refuse_beyond(film, Hint(*hint))
    notes = Notes()
    search = Search(region.width, region.height)
    for frame in film.frames():
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
        """In radii; before it moves a thing is where its track begins."""
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
