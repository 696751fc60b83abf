"""Points of the material that are followed from picture to picture.

Each is followed by the flow of its surroundings (pyramidal Lucas and Kanade, as OpenCV has it),
forwards and back again. One that does not come back to where it was, or that moves otherwise than
its neighbours (median test: Westerweel and Scarano, Exp. Fluids 39 (2005) 1096), is carried on by
the median of its neighbours. So all points are kept, and with them where they began.
"""

import numpy as np
from numpy.typing import NDArray

from calibration.flow.survey import Grey

Points = NDArray[np.float32]

_RETURN = 1.0  # px by which a point may miss its beginning after there and back
_WINDOW = 2 / 3  # of a grain: what a window sees should mostly be of one grain
_SMALLEST = 7  # px
_NEIGHBOURS = 8
_MEDIAN_LIMIT = 3.0  # residuals over the neighbours' median residual
_FLOOR = 0.1  # px of noise that is allowed beside it (as in the reference)
_LEVELS = 3  # halvings of the picture: steps of eight times half a window are found
_STOP = (3, 20, 0.03)  # iterations or px


class Tracers:
    """Points (n, 2) [px, pixel k from k to k + 1], and the variance of each [px^2]."""

    def __init__(self, start: Points, grain: float) -> None:
        self.start = start.astype(np.float32)
        self.place = self.start.copy()
        self.variance = np.zeros(len(start))
        self.alive = np.ones(len(start), dtype=bool)
        self._window = max(round(_WINDOW * grain) | 1, _SMALLEST)

    def follow(self, before: Grey, after: Grey) -> None:
        """Move all points that are alive as the picture does."""
        import cv2

        live = np.flatnonzero(self.alive)
        if len(live) <= _NEIGHBOURS:
            self.alive[:] = False
            return
        at = (self.place[live] - np.float32(0.5))[:, None]  # OpenCV counts from pixels' middles
        size = self._window, self._window
        there, found, _ = cv2.calcOpticalFlowPyrLK(
            before, after, at, at.copy(), winSize=size, maxLevel=_LEVELS, criteria=_STOP
        )
        back, again, _ = cv2.calcOpticalFlowPyrLK(
            after, before, there, at.copy(), winSize=size, maxLevel=_LEVELS, criteria=_STOP
        )
        miss = np.hypot(*(back - at)[:, 0].T)
        good = (found[:, 0] > 0) & (again[:, 0] > 0) & (miss < _RETURN)
        step, variance = _carried((there - at)[:, 0], self.place[live], miss, good)
        self.place[live] += step
        self.variance[live] = np.square(np.sqrt(self.variance[live]) + np.sqrt(variance))

    def drop(self, gone: NDArray[np.bool_]) -> None:
        """Follow these points (n,) no longer."""
        self.alive &= ~gone


def _carried(
    step: Points, place: Points, miss: NDArray[np.float32], good: NDArray[np.bool_]
) -> tuple[Points, NDArray[np.float64]]:
    """Steps with those that are bad replaced by their neighbours' median, and their variance.

    A good step's error is half of what there and back is off, in each direction a root of two less.
    """
    from scipy.spatial import cKDTree

    known = np.flatnonzero(good)
    if len(known) <= _NEIGHBOURS:
        return np.zeros_like(step), np.full(len(step), _RETURN**2)
    _, near = cKDTree(place[known]).query(place, k=_NEIGHBOURS + 1)
    around = step[known][near]
    median = np.median(around, axis=1)
    residual = np.median(np.linalg.norm(around - median[:, None], axis=2), axis=1)
    off = np.linalg.norm(step - median, axis=1)
    bad = ~good | (off > _MEDIAN_LIMIT * (residual + _FLOOR))
    variance = np.where(bad, np.square(residual + _FLOOR), np.square(miss) / 4)
    return np.where(bad[:, None], median, step).astype(np.float32), variance
