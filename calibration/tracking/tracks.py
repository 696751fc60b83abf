"""Paths of things in a film's pictures made to tracks: pixels of the film, times, the camera."""

from dataclasses import replace

import numpy as np

from calibration.tracking.camera_motion import lasting_motion, offsets, scaled
from calibration.tracking.film.reader import Film
from calibration.tracking.film.region import Region
from calibration.tracking.film.stamps import clean_stamps
from calibration.tracking.linking import Path
from calibration.tracking.search import Notes, Search
from calibration.tracking.track import Array, Look, Track

_MOVES = 1.0  # px of the picture measured in, from which the camera's motion is taken off
_FEWEST = 8  # positions of a track


def tracks_of(film: Film, search: Search, notes: Notes, region: Region) -> list[Track]:
    """Of all things that move, that which went farthest first."""
    time, remarks = clean_stamps(notes.numbers, notes.stamps, film.rate)
    whole = scaled(np.array(notes.motion), *search.scale)
    motion, remark = lasting_motion(whole, region.width, region.height, _MOVES * search.scale[0])
    remarks += [*_remarks(film, notes), *([remark] if remark else [])]
    moving = sorted(
        (one for one in search.linker.paths() if one.is_smooth()),
        key=lambda one: -one.length,
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
        tracks.append(replace(track, time=when, name=name, remarks=tuple(remarks)))
    return tracks


def _track(path: Path, scale: tuple[float, float], region: Region) -> Track:
    """In pixels of the film, without positions in which the thing was not whole."""
    area = np.array([one.area for one in path.blobs])
    kept = np.flatnonzero(_usual(area) & [one.whole for one in path.blobs])
    blobs = [path.blobs[k] for k in kept]
    fx, fy = scale
    x = np.array([region.x + (one.x + 0.5) * fx - 0.5 for one in blobs])
    y = np.array([region.y + (one.y + 0.5) * fy - 0.5 for one in blobs])
    covariance = np.array(
        [[[one.xx * fx**2, one.xy * fx * fy], [one.xy * fx * fy, one.yy * fy**2]] for one in blobs]
    ).reshape(-1, 2, 2)
    radius = np.sqrt(area[kept] * fx * fy / np.pi)
    frame = np.array([path.frames[k] for k in kept], dtype=float)
    repeated = tuple(float(path.frames[k]) for k in kept if not path.blobs[k].changed)
    colour = np.array([one.colour for one in blobs]).reshape(-1, 3)
    behind = np.array([one.behind for one in blobs]).reshape(-1, 3)
    look = Look(*(np.median(one, axis=0) for one in (colour, behind))) if blobs else None
    return Track(frame, x, y, None, covariance, radius=radius, look=look, repeated=repeated)


def _usual(area: Array) -> np.ndarray:
    """Whether each area is near those around it: else two things are one blob, or one is cut."""
    from scipy.ndimage import median_filter

    off = np.abs(np.log(area / median_filter(area, size=min(31, len(area)), mode="nearest")))
    return np.asarray(off < max(np.log(1.25), 5 * float(np.median(off))))


def _remarks(film: Film, notes: Notes) -> list[str]:
    """What was wrong with the file."""
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
