"""The opening and the last grain: when the lowest material begins to fall, and when all has left.

The lowest material begins to fall from rest with a pull a and nears a steady flow, with a rate k.
Its fall after the opening at t0 is

    s(t) = a (exp(-k tau) - 1 + k tau)/k^2,   tau = t - t0,   and a tau^2/2 for k = 0

A parabola of free height fits such a fall too, with a vertex that is early by as much as a frame.
How far t0 moves when half of the fall is taken is part of its uncertainty: nothing says that the
flow settles just so. The last grain passes with its centroid half its length before it has left the
outlet's row.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from calibration.uncertainty import Estimate

Floats = NDArray[np.float64]

_CLEAR = 3.0  # standard deviations of the place of the lowest tracers that make a fall
_PLACE = 0.1  # px: standard deviation of their mean place from frame to frame
_WIDE = 0.25  # grains across, from which on something is no speck
_FEWEST = 5  # moments that show how a fall begins
_LAST = 9  # tracers whose speed is the last grain's: there are three across one
_MOST = 2.0  # grains by which it is followed at most
_SLOW = 1e-4  # per frame: a rate that is none, over the tens of frames of a fall
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
        """Where the fall from rest begins; between two frames if it is seen in few."""
        t, s = np.array(self._falls).T
        if len(t) < _FEWEST:
            return self._between(self._still, t[0])
        start, pull, sigma = _fall_from_rest(t, s)
        if pull <= 0:
            return self._between(self._still, t[0])
        half = s < s[-1] / 2
        if half.sum() >= _FEWEST:
            sigma = float(np.hypot(sigma, _fall_from_rest(t[half], s[half])[0] - start))
        # What is too little to be seen takes this long.
        earliest = self._still - np.sqrt(2 * _CLEAR * _PLACE / pull)
        if earliest - sigma <= start < t[0]:
            return Estimate(start, sigma, len(t))
        # A door that is drawn, or grains that hang on, begin otherwise.
        return self._between(earliest, t[0])

    def _between(self, early: float, late: float) -> Estimate:
        return Estimate(float(early + late) / 2, float((late - early) * UNIFORM), 1)


def _fall_from_rest(t: Floats, s: Floats) -> tuple[float, float, float]:
    """t0 of a fall s(t) [px], the pull there [px/frame^2], and the standard deviation of t0."""
    from scipy.optimize import least_squares

    def misfit(known: Floats) -> Floats:
        start, pull, rate = known
        tau = np.maximum(t - start, 0.0)
        k = rate if abs(rate) > _SLOW else _SLOW
        return np.asarray((pull * (np.expm1(-k * tau) + k * tau) / k**2 - s) / _PLACE)

    long = t[-1] - t[0] + 1
    first = t[0] - 0.5, 2 * s[-1] / long**2, 1 / long
    low, high = (t[0] - 2 * long, 0.0, 0.0), (t[0], np.inf, np.inf)
    fit = least_squares(misfit, first, bounds=(low, high), x_scale=(1.0, *first[1:]))
    cov = np.linalg.pinv(fit.jac.T @ fit.jac)
    scatter = max(2 * fit.cost / (len(t) - 3), 1.0)
    return float(fit.x[0]), float(fit.x[1]), float(np.sqrt(cov[0, 0] * scatter))


class Crossing:
    """What crosses the outlet's row, frame by frame."""

    def __init__(self, grain: float) -> None:
        self._grain = grain  # px
        self._last: float | None = None
        self._steps: deque[float] = deque(maxlen=_LAST)

    def see(self, frame: float, crossed: NDArray[np.bool_], steps: Floats) -> None:
        """Where something stands in the outlet's row (w,); steps of tracers that cross it [px]."""
        if crossed.sum() > _WIDE * self._grain:
            self._last = frame
        self._steps.extend(steps.tolist())

    def last(self) -> Estimate | None:
        """Frame at which the last grain's centroid passed; None where nothing crossed.

        Half a grain before its end did. Grains are twice as long as wide, and lie as they may.
        """
        if self._last is None:
            return None
        speed = float(np.median(self._steps)) if self._steps else 0.0
        half = self._grain / 2 / speed if speed > 0 else 0.0
        # It was last seen in one frame and gone in the next: on average half a frame later.
        return Estimate(self._last + 0.5 - half, float(np.hypot(UNIFORM, half / 2)), 1)
