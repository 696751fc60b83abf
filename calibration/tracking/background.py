"""The picture without the objects that move, learned frame by frame, and what differs from it.

A running mean of every pixel where nothing moves, and of how far it strays (its noise). Learning is
selective: what differs is no background. What was in the first frame and left it would be seen as a
"ghost" of itself for ever; a ghost stands still and has its outline in the background but not in
the picture (Cucchiara et al. 2003, doi 10.1109/TPAMI.2003.1233909), and is replaced at once.
The light of a picture as a whole (lamps that flicker, a camera that sets its own exposure) is taken
off first.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.film.reader import Picture

_SAMPLED = 1024  # pixels or so that show the light: to a thousandth, where each does to 3 %
_DARK, _BRIGHT = 16, 250  # grey levels between which a pixel is in proportion to the light
_FEWEST = 64  # such pixels in the sample
_ALIKE = 3.0  # scatter about the middle ratio within which a pixel shows what it showed before
Mask = NDArray[np.uint8]  # 255 where true
_MEMORY = 16  # pictures that the running mean spans
_EVERY = 4  # frames from one learning to the next, once it has begun
_LIMIT_FOR = 4  # learnings for which the limit is kept: noise changes slowly
_LIMIT = 6.0  # noise that differs by more: less than one pixel in a picture of millions
_MEAN_OF_LARGEST = 1.33  # mean of the largest of three normal deviates' sizes
_TREMBLE = 0.5  # px by which an edge may move: what the camera's motion is known to
_ROUNDING = 1.0  # grey levels: both pictures are whole numbers


def gains(picture: Picture, background: Picture) -> NDArray[np.float64]:
    """(3,) brightness of each channel over that of the background, 1 where it cannot be known.

    The ratio of the sums of those pixels whose own ratio is near the median of all: objects that
    move, and edges where the camera does, are not among them.
    """
    step = max(int(np.sqrt(picture[..., 0].size / _SAMPLED)), 1)
    now, was = (
        np.ascontiguousarray(one[::step, ::step].reshape(-1, 3).T) for one in (picture, background)
    )
    return np.array([_gain(now[k], was[k]) for k in range(3)])


def _gain(levels: NDArray[np.uint8], before: NDArray[np.uint8]) -> float:
    inside = (before > _DARK) & (before < _BRIGHT) & (levels > 0) & (levels < _BRIGHT)
    rows = np.flatnonzero(inside)
    if len(rows) < _FEWEST:
        return 1.0
    now, was = (one[rows].astype(np.float32) for one in (levels, before))
    ratio = now / was
    off = np.abs(ratio - _middle(ratio))
    near = np.asarray(off <= _ALIKE * _middle(off), dtype=np.float32)
    return float(now @ near) / float(was @ near)


def _middle(values: NDArray[np.float32]) -> np.float32:
    """The upper median; numpy's own costs several times more."""
    half = len(values) // 2
    return np.float32(np.partition(values, half)[half])


def relit(picture: Picture, factors: NDArray[np.float64]) -> Picture:
    """A picture with its channels divided by these factors."""
    import cv2

    return np.asarray(cv2.transform(picture, np.diag(1 / factors)), dtype=np.uint8)


class Background:
    """Learned from pictures (h, w, 3) that all show the same view."""

    def __init__(self, picture: Picture) -> None:
        self._mean = picture.astype(np.float32)
        self._spread = np.zeros(picture.shape[:2], np.float32)
        self._seen = 1
        self._frames = 0
        self._level = float(picture.mean())
        self.picture = picture.copy()  # rounded mean
        self._limit: Picture | None = None
        self._away = np.empty_like(picture)
        self._planes: list[Any] = [np.empty(picture.shape[:2], np.uint8) for _ in range(3)]
        self.noise = _ROUNDING  # sigma of one channel of a pixel, over the picture [grey levels]

    def lit_alike(self, picture: Picture) -> Picture:
        """The picture as it were in the background's light, where that is another beyond noise."""
        factors = gains(picture, self.picture)
        if np.abs(factors - 1).max() * self._level <= self.noise / 2:
            return picture
        return relit(picture, factors)

    def difference(self, picture: Picture) -> Picture:
        """(h, w) how far each pixel differs, in the channel where it differs most.

        It is overwritten by the next call: new memory for each picture costs more than the sum.
        """
        import cv2

        cv2.absdiff(picture, self.picture, self._away)
        away = _largest(self._away, self._planes)
        if self._seen == 1 and self._frames == 0:  # before that nothing is known of the noise
            self._spread[:] = _mean_of_quiet(away)
            self._limit = None
        return away

    def limit(self) -> Picture:
        """(h, w) difference that noise and a trembling of edges do not reach."""
        import cv2

        if self._limit is None:
            edges = cv2.morphologyEx(self.picture, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
            limit = self._spread * np.float32(_LIMIT / _MEAN_OF_LARGEST)
            np.maximum(limit, np.float32(_LIMIT * self.noise), out=limit)
            limit += np.float32(_ROUNDING)
            steep = _largest(np.asarray(edges, dtype=np.uint8))
            limit += np.multiply(steep, np.float32(_TREMBLE / 2), dtype=np.float32)
            self._limit = np.asarray(np.minimum(limit, 254), dtype=np.uint8)
        return self._limit

    def due(self) -> bool:
        """True if it is this frame's turn to be learned; called once a frame."""
        self._frames += 1
        return self._seen < _MEMORY / 2 or self._frames % _EVERY == 0

    def learn(self, picture: Picture, difference: Picture, objects: Mask) -> None:
        """Take in a picture but for the objects in it."""
        import cv2

        self._seen += 1
        if self._seen < _MEMORY or self._seen % _LIMIT_FOR == 0:
            self._limit = None
        share = 1 / min(self._seen, _MEMORY)
        still = cv2.bitwise_not(objects)
        cv2.accumulateWeighted(picture, self._mean, share, still)
        cv2.accumulateWeighted(difference, self._spread, share, still)
        cv2.convertScaleAbs(self._mean, dst=self.picture)
        self.noise = max(_mean_of_quiet(difference) / _MEAN_OF_LARGEST, _ROUNDING / 2)

    def replace(self, picture: Picture, where: Mask) -> None:
        """Take the picture as it is at some position: a ghost, or a new view."""
        import cv2

        x, y, w, h = cv2.boundingRect(where)
        cut = np.s_[y : y + h, x : x + w]
        self._limit = None
        chosen = where[cut] > 0
        for stored in (self._mean, self.picture):
            stored[cut][chosen] = picture[cut][chosen]


def _largest(channels: Picture, planes: Any = None) -> Picture:
    """(h, w) the largest of three channels; in the first of three planes where they are given."""
    import cv2

    blue, green, red = cv2.split(channels, planes)
    cv2.max(blue, green, blue)
    return np.asarray(cv2.max(blue, red, blue), dtype=np.uint8)


def _mean_of_quiet(difference: Picture) -> float:
    """Mean of the differences that are not far beyond the median: noise alone."""
    count = np.bincount(difference[::3, ::3].ravel(), minlength=256)
    median = int(np.searchsorted(np.cumsum(count), count.sum() / 2))
    quiet = count[: 3 * median + 3]
    return float(quiet @ np.arange(len(quiet)) / quiet.sum())


def is_ghost(picture: Picture, background: Picture, object: Mask) -> bool:
    """True if the outline of an object stands in the background rather than in the picture."""
    import cv2

    kernel = np.ones((3, 3), np.uint8)
    outside, inside = (change(object, kernel, iterations=2) for change in (cv2.dilate, cv2.erode))
    ring = cv2.subtract(outside, inside)
    if not cv2.countNonZero(ring):
        return False
    seen, stored = (
        cv2.mean(cv2.morphologyEx(one, cv2.MORPH_GRADIENT, kernel), ring)[:3]
        for one in (picture, background)
    )
    return sum(stored) > 1.5 * sum(seen)
