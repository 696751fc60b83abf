"""The opening and the last grain: when the lowest material begins to fall, and when all has left.

The opening is the vertex of the parabola that the lowest material's fall draws against time, as it
does from rest at a constant acceleration. Its height is left free, as it may spring off the rest,
and the first tenths of a pixel are hardly seen. The last grain's time is that of the middle of its patch in the streak
picture of the outlet's row: columns across, frames down. A rigid thing that crosses at a constant
speed draws itself there, so that the middle is where its centroid passes.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from calibration.uncertainty import Estimate

Floats = NDArray[np.float64]

_CLEAR = 3.0  # standard deviations of the place of the lowest tracers that make a fall
_PLACE = 0.1  # px: standard deviation of their mean place from frame to frame
_KEPT = 600  # rows of the streak picture: one thing that crosses takes less
_FEWEST = 5  # moments that show how a fall begins
_MOST = 2.0  # grains by which it is followed at most
_UNIFORM = 1 / np.sqrt(12)  # standard deviation of a uniform distribution of width 1


class Opening:
    """Falls of the lowest tracers, frame by frame, until they tell when they began.

    clock    frame of the opening and its standard deviation [frames]; None as long as unknown
    """

    def __init__(self, grain: float) -> None:
        self._grain = grain  # px
        self._falls: list[tuple[float, float]] = []
        self._still = 0.0
        self.clock: Estimate | None = None

    @property
    def moving(self) -> bool:
        """Whether a fall has been seen."""
        return bool(self._falls)

    def see(self, frame: float, fall: float) -> None:
        """The mean fall of the lowest tracers [px] in a frame."""
        if self.clock is not None:
            return
        if fall < _CLEAR * _PLACE and not self._falls:
            self._still = frame
            return
        self._falls.append((frame, fall))
        if fall > _MOST * self._grain or (fall > self._grain and len(self._falls) >= _FEWEST):
            self.clock = self._start()

    def _start(self) -> Estimate:
        """Where the parabola of the falls has its vertex; between two frames if there are few."""
        t, s = np.array(self._falls).T
        seen = Estimate((self._still + t[0]) / 2, float((t[0] - self._still) * _UNIFORM), 1)
        if len(t) < _FEWEST:
            return seen
        (a, b, c), cov = np.polyfit(t - t[0], s, 2, cov="unscaled")
        if a <= 0:
            return seen
        misfit = np.square(s - np.polyval((a, b, c), t - t[0])).sum() / (len(t) - 3)
        slopes = np.array([b / (2 * a * a), -1 / (2 * a), 0.0])
        sigma = float(np.sqrt(slopes @ cov @ slopes * max(misfit, _PLACE**2)))
        vertex = float(t[0] - b / (2 * a))
        # A door that is drawn, or grains that hang on, begin otherwise than by a constant pull.
        late, early = t[0], self._still - 1
        return Estimate(vertex, sigma, len(t)) if early <= vertex <= late else seen


class Streak:
    """What crosses the outlet's row, for as long as it takes the last grain."""

    def __init__(self, grain: float) -> None:
        self._grain = grain  # px
        self._rows: deque[tuple[int, NDArray[np.bool_]]] = deque(maxlen=_KEPT)
        self.columns: NDArray[np.int64] | None = None  # in how many frames each was crossed

    def see(self, frame: int, crossed: NDArray[np.bool_]) -> None:
        """Where something stands in the outlet's row (w,) in a frame."""
        if self.columns is None:
            self.columns = np.zeros(len(crossed), dtype=np.int64)
        self.columns += crossed
        if crossed.any():
            self._rows.append((frame, crossed))

    def last(self) -> Estimate | None:
        """Frame at which the last grain's centroid passed; None where nothing crossed."""
        if not self._rows:
            return None
        end = self._rows[-1][0]
        first = self._rows[0][0]
        picture = np.zeros((end - first + 1, len(self._rows[0][1])), dtype=bool)
        for frame, crossed in self._rows:
            picture[frame - first] = crossed
        patch = _last_patch(picture, self._grain)
        if patch is None:
            return None
        rows = np.flatnonzero(patch.any(axis=1))
        middle = float(np.nonzero(patch)[0].mean()) + first
        # The frames cut the patch at both ends; its middle moves by a part of either cut.
        cut = _UNIFORM / np.sqrt(2)
        return Estimate(middle, float(cut), len(rows))


def _last_patch(picture: NDArray[np.bool_], grain: float) -> NDArray[np.bool_] | None:
    """The last thing of a tenth of a grain's width that crossed, cut off from what touches it."""
    import cv2

    _, label, stats, _ = cv2.connectedComponentsWithStats(picture.astype(np.uint8))
    wide = np.flatnonzero(stats[1:, cv2.CC_STAT_WIDTH] >= max(0.1 * grain, 2)) + 1
    if len(wide) == 0:
        return None
    ends = stats[wide, cv2.CC_STAT_TOP] + stats[wide, cv2.CC_STAT_HEIGHT]
    patch = label == wide[int(ends.argmax())]
    low = np.flatnonzero(patch.any(axis=1))[-1]
    middle = np.flatnonzero(patch[low]).mean()
    near = np.abs(np.arange(picture.shape[1]) - middle) <= grain
    patch &= near
    # One grain: the run of frames up to the last in which that place was free.
    free = np.flatnonzero(~patch[: low + 1].any(axis=1))
    patch[: free[-1] if len(free) else 0] = False
    return patch
