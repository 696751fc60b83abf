"""The opening and the last grain: when the lowest material begins to fall, and when all has left.

The opening is the vertex of the parabola that the lowest material's fall draws against time, as it
does from rest at a constant acceleration. Its height is left free, as it may spring off the rest,
and the first tenths of a pixel are hardly seen. The last grain passes with its centroid half its
length before it has left the outlet's row.
"""

import numpy as np
from numpy.typing import NDArray

from calibration.uncertainty import Estimate

Floats = NDArray[np.float64]

_CLEAR = 3.0  # standard deviations of the place of the lowest tracers that make a fall
_PLACE = 0.1  # px: standard deviation of their mean place from frame to frame
_WIDE = 0.25  # grains across, from which on something is no speck
_FEWEST = 5  # moments that show how a fall begins
_MOST = 2.0  # grains by which it is followed at most
UNIFORM = 1 / np.sqrt(12)  # standard deviation of a uniform distribution of width 1


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
        if len(t) < _FEWEST:
            return self._between(self._still, t[0])
        (a, b, c), cov = np.polyfit(t - t[0], s, 2, cov="unscaled")
        if a <= 0:
            return self._between(self._still, t[0])
        misfit = np.square(s - np.polyval((a, b, c), t - t[0])).sum() / (len(t) - 3)
        slopes = np.array([b / (2 * a * a), -1 / (2 * a), 0.0])
        sigma = float(np.sqrt(slopes @ cov @ slopes * max(misfit, _PLACE**2)))
        vertex = float(t[0] - b / (2 * a))
        # What is too little to be seen takes this long.
        earliest = self._still - np.sqrt(_CLEAR * _PLACE / a)
        if earliest - sigma <= vertex <= t[0]:
            return Estimate(vertex, sigma, len(t))
        # A door that is drawn, or grains that hang on, begin otherwise than by a constant pull.
        return self._between(earliest, t[0])

    def _between(self, early: float, late: float) -> Estimate:
        return Estimate(float(early + late) / 2, float((late - early) * UNIFORM), 1)


class Crossing:
    """What crosses the outlet's row, frame by frame."""

    def __init__(self, grain: float) -> None:
        self._grain = grain  # px
        self._last: float | None = None
        self._speed = np.nan  # px/frame

    def see(self, frame: float, crossed: NDArray[np.bool_], speed: float) -> None:
        """Where something stands in the outlet's row (w,); speed of tracers that cross it."""
        if crossed.sum() > _WIDE * self._grain:
            self._last = frame
        if np.isfinite(speed):
            self._speed = speed

    def last(self) -> Estimate | None:
        """Frame at which the last grain's centroid passed; None where nothing crossed.

        Half a grain before its end did. Grains are twice as long as wide, and lie as they may.
        """
        if self._last is None:
            return None
        half = self._grain / 2 / self._speed if self._speed > 0 else 0.0
        # It was last seen in one frame and gone in the next: on average half a frame later.
        return Estimate(self._last + 0.5 - half, float(np.hypot(UNIFORM, half / 2)), 1)
