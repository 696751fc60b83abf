"""Objects that swing, found by their colours: those seen more often in motion than at rest.

A string, a shadow or a hand has the colours of what stands still around it, or is there for a
moment only; an object that swings carries its own. Objects on strings cannot pass each other: where
two are seen they are kept apart by their order, and where they touch none is.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.camera_motion import (
    CameraMotion,
    lasting_motion,
    offsets,
    scaled,
    shows_motion,
)
from calibration.tracking.film.reader import Film, Picture, Progress, Region
from calibration.tracking.film.stamps import clean_stamps
from calibration.tracking.track import Array, Track
from granulab.errors import InputError

_BINS = 32  # of each of three channels
_SAMPLES = 60  # frames that the colours are learned from
_BYTES = 2**28  # of memory for them
_SEARCHED = 640  # px of a picture that objects are searched in
_STEP = 16  # grey levels by which a pixel differs from its median when something else is there
_PART = 0.25  # of the area of the larger object: what is smaller is no second one
_OFTEN = 0.6  # share of frames in which all objects must be found
_ALIKE = 3.0  # times the usual area, or a third: more is another object, or two that touch
_MOVES = 1.0  # px of what is searched, from which the camera's motion is taken off
_LEAST = 12  # px of an object's area


class _Spot(NamedTuple):
    area: float
    x: float
    y: float


@dataclass(frozen=True)
class _Look:
    """Look of a film.

    share    (bins, bins, bins) how likely a colour is that of an object in motion
    still    (height, width, 3) the picture without the objects
    skip     every how many pixels objects are searched for
    """

    share: NDArray[np.float32]
    still: NDArray[np.float32]
    skip: int

    def likely(self, picture: Picture) -> NDArray[np.float32]:
        """Of the pixels that are searched, smoothed over neighbours."""
        import cv2

        few = self.share[_binned(picture[:: self.skip, :: self.skip])]
        return np.asarray(cv2.GaussianBlur(few, (0, 0), 1.0))

    def objects(self, picture: Picture) -> Picture:
        """Return where they are in the pixels that are searched, and what is next to them (255)."""
        import cv2

        there = (self.likely(picture) > 0.5).astype(np.uint8)
        return np.asarray(255 * cv2.dilate(there, np.ones((9, 9), dtype=np.uint8)))


def by_colour(
    film: Film, *, roi: Region | None = None, progress: Progress | None = None
) -> list[Track]:
    """One or two tracks of the objects that swing; radius is that of a circle of their area.

    Raises InputError where no colour is that of something that moves.
    """
    x, y, width, height = roi or (0, 0, film.width, film.height)
    view = slice(y, y + height), slice(x, x + width)
    look = _learned(film, view)
    spots: list[list[_Spot]] = []
    numbers: list[int] = []
    stamps: list[float | None] = []
    camera = CameraMotion()
    motion: list[Array] = []
    shown: list[bool] = []
    for frame in film.frames():
        picture = frame.picture[view]
        spots.append(_spots(look, picture))
        few = np.ascontiguousarray(picture[:: look.skip, :: look.skip])
        if not motion:
            first = few
            camera.look_at(first, look.objects(picture))
        motion.append(camera.follow(few))
        shown.append(shows_motion(few, first, motion[-1]))
        numbers.append(frame.number)
        stamps.append(frame.stamp)
        if progress is not None and film.count:
            progress((frame.number + 1) / film.count, f"frame {frame.number + 1} of {film.count}")
    found = _objects(film, spots)
    time, remarks = clean_stamps(numbers, stamps, film.rate)
    moved, remark = lasting_motion(
        scaled(np.array(motion), look.skip, look.skip),
        width,
        height,
        _MOVES * look.skip,
        np.array(shown),
    )
    remarks += [remark] if remark else []
    whole = Track(np.array(numbers, dtype=float), np.zeros(0), np.zeros(0), time)
    return [
        replace(_track(whole, one, (x, y), moved), name=str(k + 1), remarks=tuple(remarks))
        for k, one in enumerate(found)
    ]


def _learned(film: Film, view: tuple[slice, slice]) -> _Look:
    """From frames all over the film: what differs from their median is in motion."""
    from scipy.ndimage import gaussian_filter

    every = _samples(film, view)
    median = np.median(every, axis=0).astype(np.uint8)
    counts = np.zeros((2, _BINS, _BINS, _BINS))
    skip = max(math.ceil(max(median.shape) / _SEARCHED), 1)
    for picture in every[:, ::skip, ::skip]:
        off = np.abs(picture.astype(np.int16) - median[::skip, ::skip]).max(axis=2)
        for k, where in enumerate((off <= _STEP, off > _STEP)):
            np.add.at(counts[k], tuple(channel[where] for channel in _binned(picture)), 1)
    still, moving = (gaussian_filter(one, 1.0) for one in counts)
    share = (moving / np.maximum(moving + still, 1.0)).astype(np.float32)
    return _Look(share, _without_things(median, share), skip)


def _samples(film: Film, view: tuple[slice, slice]) -> Picture:
    """(n, height, width, 3) frames all over the film, as many as memory is given to."""
    size = 3 * film.width * film.height
    most = int(np.clip(_BYTES // size, 8, _SAMPLES))
    step, pictures = max(film.count // most, 1), []
    for frame in film.frames():
        if frame.number % step == 0:
            pictures.append(frame.picture[view].copy())
        if len(pictures) > 2 * most:  # a film that does not say how long it is
            pictures, step = pictures[::2], 2 * step
    return np.stack(pictures)


def _without_things(median: Picture, share: NDArray[np.float32]) -> NDArray[np.float32]:
    """The median, painted over where an object hangs at rest in it."""
    import cv2

    there = (cv2.GaussianBlur(share[_binned(median)], (0, 0), 1.0) > 0.5).astype(np.uint8)
    wider = cv2.dilate(there, np.ones((5, 5), dtype=np.uint8))
    return np.asarray(cv2.inpaint(median, wider, 3, cv2.INPAINT_TELEA), dtype=np.float32)


def _binned(picture: Picture) -> tuple[NDArray[np.intp], ...]:
    index = (picture // (256 // _BINS)).astype(np.intp)
    return index[..., 0], index[..., 1], index[..., 2]


def _spots(look: _Look, picture: Picture) -> list[_Spot]:
    """Connected parts of colours that are rather in motion than not, the largest first."""
    import cv2

    likely, skip = look.likely(picture), look.skip
    count, label, stats, _ = cv2.connectedComponentsWithStats((likely > 0.5).astype(np.uint8))
    margin = math.ceil(3 / skip)
    spots = []
    for k in range(1, count):
        left, top, width, height, area = map(int, stats[k])
        rows = slice(top - margin, top + height + margin)
        columns = slice(left - margin, left + width + margin)
        whole = rows.start >= 0 and columns.start >= 0
        whole &= rows.stop <= label.shape[0] and columns.stop <= label.shape[1]
        if area * skip**2 < _LEAST or not whole:
            continue
        mask = np.repeat(np.repeat(label[rows, columns] == k, skip, axis=0), skip, axis=1)
        here = (
            slice(rows.start * skip, rows.stop * skip),
            slice(columns.start * skip, columns.stop * skip),
        )
        spots.append(_placed(picture[here], look.still[here], mask, here))
    return sorted(spots, reverse=True)


def _placed(
    picture: Picture, still: NDArray[np.float32], mask: NDArray[np.bool_],
    here: tuple[slice, slice],
) -> _Spot:  # fmt: skip
    """The centroid of how far an object covers each pixel: its colour mixed with what is behind."""
    import cv2

    rows, columns = (min(n) for n in zip(mask.shape, picture.shape[:2], strict=True))
    seen = mask[:rows, :columns].astype(np.uint8)
    colour = np.median(picture[seen > 0], axis=0)
    apart = colour - still
    size = np.maximum((apart**2).sum(axis=2), _STEP**2)
    cover = np.clip(((picture - still) * apart).sum(axis=2) / size, 0, 1)
    cover *= cv2.dilate(seen, np.ones((5, 5), dtype=np.uint8))
    across, down = cover.sum(axis=0), cover.sum(axis=1)
    return _Spot(
        float(cover.sum()),
        float(here[1].start + across @ np.arange(columns) / across.sum()),
        float(here[0].start + down @ np.arange(rows) / down.sum()),
    )


def _objects(film: Film, spots: list[list[_Spot]]) -> list[list[_Spot | None]]:
    """One or two spots of each frame, from left to right; None in all where one is missing."""
    largest = [one[0].area for one in spots if one]
    if len(largest) < _OFTEN * len(spots):
        raise InputError(f"{film.path}: no colour is that of something that moves through the film")
    usual = float(np.median(largest))
    several = [sum(one.area > _PART * usual for one in each) for each in spots]
    many = 2 if sum(n >= 2 for n in several) > _OFTEN * len(spots) else 1
    areas = np.median([[s.area for s in one[:many]] for one in spots if len(one) >= many], axis=0)
    found = [_like(each, areas) for each in spots]
    return [[None if one is None else one[k] for one in found] for k in range(many)]


def _like(spots: list[_Spot], areas: Array) -> list[_Spot] | None:
    """The spots whose areas are most like the usual ones, from left to right."""
    chosen: list[_Spot] = []
    for area in areas:
        left = [one for one in spots if one not in chosen]
        best = min(left, key=lambda one: abs(np.log(one.area / area)), default=None)
        if best is None or abs(np.log(best.area / area)) > np.log(_ALIKE):
            return None
        chosen.append(best)
    return sorted(chosen, key=lambda one: one.x)


def _track(
    whole: Track, spots: list[_Spot | None], corner: tuple[int, int], motion: Array | None
) -> Track:
    """The frames, and times if any, of `whole` in which there is a spot; positions in the first."""
    rows = np.array([k for k, one in enumerate(spots) if one is not None])
    known = np.array([[one.area, one.x, one.y] for one in spots if one is not None])
    offset = None if motion is None else offsets(motion[rows], known[:, 1], known[:, 2])
    position = known[:, 1:] if offset is None else known[:, 1:] - offset
    return Track(
        whole.frame[rows],
        position[:, 0] + corner[0],
        position[:, 1] + corner[1],
        None if whole.time is None else whole.time[rows],
        radius=np.sqrt(known[:, 0] / np.pi),
        camera=offset,
    )
