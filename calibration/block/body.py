"""A rigid body that moves in a film: its rotation and shift in each frame since the first.

Corners of the first picture, where it differs from the last, are followed by the pyramid of Lucas
and Kanade (Bouguet 2001). The first of them that move together as one body are its own. From then
on each frame is rotated and shifted back by where the body is expected before they are looked for:
what is compared is always the first picture and one that hardly differs from it, so that errors do
not add up along the way, and a rotation does not matter.
"""

import warnings
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.flow.silo import changes
from calibration.flow.survey import CLEAR, Grey, Survey, to_grey
from calibration.tracking.film.reader import Film, Frame, Progress, Region
from calibration.tracking.film.stamps import clean_stamps
from calibration.tracking.track import Array
from granulab.errors import InputError

Points = NDArray[np.float32]

_CORNERS = 600
_APART = 5  # px between corners: a third of a window
_WINDOW = 15  # px
_LEVELS = 1  # of the pyramid: windows of higher ones see more of what is behind a body than of it
_AROUND = 2 * _WINDOW + 1  # px about what changes in which corners lie
_BACK = 0.5  # px by which a corner followed there and back may miss
_MOVED = 1.5  # px: three times that, what no corner at rest does
_FAR = 5.0  # px by which some corner has moved once the body is looked for: 1 deg over 300 px
_TOGETHER = 1.0  # px by which a corner may be off the body's motion
FEWEST = 5  # corners of a body: a rigid motion has three unknowns


class Scene(NamedTuple):
    """Corners in every frame that was read.

    number   (n,) of the frames
    time     (n,) [s], None where no rate is known
    first    the first picture
    corners  (c, 2) in it [px]
    places   (n, c, 2) in each frame, NaN where not seen
    """

    number: Array
    time: Array | None
    first: Grey
    corners: Array
    places: Array
    remarks: list[str]


@dataclass(frozen=True)
class Body:
    """The corners of one body, and its motion since the first frame.

    scene     of its corners alone
    motion    (n, 3, 3) from the first picture to each, a rotation and a shift
    """

    scene: Scene
    motion: Array

    @property
    def rotation(self) -> Array:
        """(n,) since the first frame, in the picture's sense, from x to y [rad]."""
        angle = np.arctan2(self.motion[:, 1, 0], self.motion[:, 0, 0])
        return np.asarray(np.unwrap(angle))

    @property
    def left(self) -> Array:
        """(n, c, 2) how far each corner has left its place on the body, along the first picture."""
        back = np.linalg.inv(self.motion)
        seen = np.einsum("nij,ncj->nci", back[:, :2, :2], self.scene.places) + back[:, None, :2, 2]
        return np.asarray(seen - self.scene.corners)

    def part(self, own: NDArray[np.bool_]) -> "Body":
        """The body that some of the corners (c,) are, with a motion of its own."""
        scene = self.scene._replace(
            corners=self.scene.corners[own], places=self.scene.places[:, own]
        )
        return Body(scene, _motions(scene))

    def seen_from(self, other: "Body") -> Array:
        """(n, c, 2) how far each corner has left its place on another body."""
        return Body(self.scene, other.motion).left


def follow_body(
    film: Film, seen: Survey, region: Region, *, rotates: bool, fps: float | None = None,
    progress: Progress | None = None,
) -> Body:  # fmt: skip
    """The body that moves first in a region of the picture.

    rotates    what only shifts is none
    Raises InputError where nothing does so.
    """
    cut = np.s_[region.y : region.y + region.height, region.x : region.x + region.width]
    corners = _corners(seen, cut)
    follower: _Follower | None = None
    numbers, stamps = [], []
    for frame in film.frames():
        grey = to_grey(frame.picture)
        if follower is None:
            follower = _Follower(grey, corners, rotates)
        follower.see(grey)
        numbers.append(frame.number)
        stamps.append(frame.stamp)
        _report(progress, frame, seen.count)
    assert follower is not None  # a survey has read five frames
    if follower.own is None:
        what = "tilts" if rotates else "slides"
        raise InputError(
            f"{film.path}: nothing that {what} is seen in {seen.count} frames; say where it is: "
            "--roi x,y,w,h"
        )
    time, remarks = clean_stamps(numbers, stamps, film.rate)
    if fps is not None:
        time = np.array(numbers) / fps
    own = follower.own
    places = np.array(follower.places, dtype=float)[:, own]
    scene = Scene(np.array(numbers, dtype=float), time, follower.first, corners[own].astype(float),
                  places, remarks)  # fmt: skip
    body = Body(scene, _motions(scene))
    # A corner of the first picture has its noise, too; what it is off by in all others, it is not.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a corner that is never seen again
        off = np.nan_to_num(np.nanmedian(body.left, axis=0))
    scene = scene._replace(corners=scene.corners + off)
    return Body(scene, _motions(scene))


def _motions(scene: Scene) -> Array:
    """(n, 3, 3) from the first picture to each."""
    motion, before = [], np.eye(3)
    for there in scene.places:
        before = agreed(scene.corners, there, before)[0]
        motion.append(before)
    return np.array(motion)


def _report(progress: Progress | None, frame: Frame, count: int) -> None:
    if progress is not None:
        progress(0.2 + 0.8 * frame.number / count, f"frame {frame.number} of {count}")


def _corners(seen: Survey, cut: tuple[slice, slice]) -> Points:
    """(c, 2) corners of the first picture about what differs from the last."""
    import cv2

    _, changed = changes(seen, CLEAR * seen.noise)
    inside = np.zeros(changed.shape, np.uint8)
    inside[cut] = changed[cut]
    mask: Any = cv2.dilate(inside, np.ones((_AROUND, _AROUND), np.uint8))
    found = cv2.goodFeaturesToTrack(to_grey(seen.first), _CORNERS, 0.01, _APART, mask=mask)
    return np.empty((0, 2), np.float32) if found is None else np.asarray(found[:, 0], np.float32)


class _Follower:
    """Looks for the corners in one frame after the other."""

    def __init__(self, first: Grey, corners: Points, rotates: bool) -> None:
        self.first, self.corners, self.rotates = first, corners, rotates
        self.own: NDArray[np.bool_] | None = None
        self.places: list[Array] = []
        self._motion = [np.eye(3), np.eye(3)]  # the last two
        self._off = np.zeros_like(corners)  # of the corners from where the body has them
        self._step = np.zeros_like(corners)  # by which that grew in the last frame

    def see(self, grey: Grey) -> None:
        """Take the next frame."""
        last, now = self._motion
        expected = now @ np.linalg.inv(last) @ now
        wanted = np.ones(len(self.corners), bool) if self.own is None else self.own
        there = np.full(self.corners.shape, np.nan)
        if wanted.any():
            there[wanted] = self._found(grey, expected, wanted)
        self.places.append(there)
        if self.own is None:
            self._look_for_body(there)
            return
        motion, held = agreed(self.corners[wanted], there[wanted], expected)
        self._motion = [now, motion if held.sum() >= FEWEST else expected]

    def _found(self, grey: Grey, expected: Array, wanted: NDArray[np.bool_]) -> Array:
        """(k, 2) of the wanted corners in the picture, NaN where lost."""
        import cv2

        size = grey.shape[1], grey.shape[0]
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        back: Any = cv2.warpAffine(grey, expected[:2], size, flags=flags)
        start: Any = self.corners[wanted]
        flow: Any = {"winSize": (_WINDOW, _WINDOW), "maxLevel": _LEVELS,
                     "flags": cv2.OPTFLOW_USE_INITIAL_FLOW}  # fmt: skip
        there: Any = start + self._off[wanted] + self._step[wanted]
        first: Any = self.first
        there, seen, _ = cv2.calcOpticalFlowPyrLK(first, back, start, there, **flow)
        home, seen_back, _ = cv2.calcOpticalFlowPyrLK(back, first, there, start.copy(), **flow)
        miss = np.linalg.norm(home - start, axis=1)
        good = (seen.ravel() > 0) & (seen_back.ravel() > 0) & (miss < _BACK)
        off = np.where(good[:, None], there - start, self._off[wanted])
        self._step[wanted], self._off[wanted] = off - self._off[wanted], off
        out = there.astype(float) @ expected[:2, :2].T + expected[:2, 2]
        good &= ((out >= 0) & (out < size)).all(axis=1)
        return np.where(good[:, None], out, np.nan)

    def _look_for_body(self, there: Array) -> None:
        way = np.linalg.norm(there - self.corners, axis=1)
        moved = way > _MOVED
        if moved.sum() < FEWEST or np.nanmax(way) < _FAR:
            return
        motion, held = agreed(self.corners[moved], there[moved], np.eye(3))
        if held.sum() < max(FEWEST, moved.sum() / 2):
            return
        # A shift alone leaves every corner within what a corner may be off.
        shift = there[moved][held] - self.corners[moved][held]
        if self.rotates and np.linalg.norm(np.ptp(shift, axis=0)) < 2 * _TOGETHER:
            return
        self.own = np.zeros(len(way), bool)
        self.own[np.flatnonzero(moved)[held]] = True
        self._motion = [motion, motion]
        self._off[:] = self._step[:] = 0.0


def agreed(corners: NDArray, there: Array, before: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Rigid motion (3, 3) on which most corners agree, and which do (c,); else that before."""
    import cv2

    seen = np.flatnonzero(np.isfinite(there).all(axis=1))
    held = np.zeros(len(there), bool)
    if len(seen) < FEWEST:
        return before, held
    cv2.setRNGSeed(1)
    a, b = corners[seen].astype(np.float32), there[seen].astype(np.float32)
    _, inside = cv2.estimateAffinePartial2D(a, b, ransacReprojThreshold=_TOGETHER)
    if inside is None or inside.sum() < FEWEST:
        return before, held
    held[seen[inside.ravel() > 0]] = True
    return rigid(corners[held].astype(float), there[held]), held


def rigid(corners: Array, there: Array) -> Array:
    """(3, 3) rotation and shift by least squares (Kabsch 1976, doi 10.1107/S0567739476001873)."""
    middle, to = corners.mean(axis=0), there.mean(axis=0)
    a, b = corners - middle, there - to
    angle = np.arctan2(np.sum(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]), np.sum(a * b))
    cos, sin = np.cos(angle), np.sin(angle)
    motion = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    motion[:2, 2] = to - motion[:2, :2] @ middle
    return motion
