"""Opening and end of a discharge, and whether a film shows one.

The lowest material begins to fall from rest at t0, with a pull a that changes as particles meet,
part and jam: nobody knows how. So it is a random walk (W: Brownian motion, tau = t - t0, T the
fall's length),

    s(t) = int_0^tau (tau - u) a(u) du,   a(u) = a0 (1 + rho W(u/T)),   0 < rho < 1

whose falls have the mean a0 tau^2/2 and, for tau <= tau', with d = tau' - tau, the covariance

    (rho a0)^2/T int_0^tau (tau - u)^2 (tau' - u)^2/4 du
        = (rho a0)^2/T (tau^5/5 + d tau^4/2 + d^2 tau^3/3)/4

How likely seen falls make t0 and rho, whatever a0: Rasmussen and Williams, Gaussian Processes for
Machine Learning (2006), sec. 2.7 (a0 in the covariance is that of the whole fall). t0 is the mean
over all t0 and rho, none preferred before, and its sigma their standard deviation: what is not
known of the pull counts. The last particle passes with its centroid half its length before it has
left the outlet's row.

Every silo that empties, and no ball, pendulum or moving camera, has material above the outlet
before the opening, which only leaves, and by the outlet; what is near it falls before the rest.
"""

from collections import deque
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.statistics.uncertainty import Estimate
from granulab.errors import InputError

Floats = NDArray[np.float64]

_CLEAR = 3.0  # standard deviations of the position of the lowest tracers that make a fall
_POSITION = 0.1  # px: standard deviation of their mean position from frame to frame
_WIDE = 0.25  # particles across, from which on something is no speck
_FEWEST = 4  # moments of a fall: when it began, its pull, how that changes, and one to spare
_MANY = 40  # moments of a fall that are used, of more: their errors are mostly shared
_GRID = 100  # beginnings that are tried, then again about the likely ones
_CHANGES = (np.arange(10) + 0.5) / 10  # rho: from a pull that stays to one that may be all spent
_LAST = 9  # tracers whose speed is the last particle's: there are three across one
_MOST = 2.0  # particles by which it is followed at most
UNIFORM = 1 / np.sqrt(12)  # standard deviation of a uniform distribution of width 1


class Opening:
    """Falls of the lowest tracers, frame by frame, until their beginning is known.

    clock    frame of the opening and its standard deviation [frames]; None as long as unknown
    """

    def __init__(self, particle: float) -> None:
        self._particle = particle  # px
        self._falls: list[tuple[float, float]] = []
        self._still = 0.0, 0.0
        self.clock: Estimate | None = None

    @property
    def moving(self) -> bool:
        """True once a fall has been seen."""
        return bool(self._falls)

    @property
    def pull(self) -> float | None:
        """Mean acceleration of the first fall [px/frame2]; None where it is seen in too few."""
        if self.clock is None or len(self._falls) < _FEWEST:
            return None
        frame, fall = self._falls[-1]
        return 2 * fall / (frame - self.clock.value) ** 2

    def see(self, frame: float, fall: float) -> None:
        """The mean fall of the lowest tracers [px] in a frame."""
        if self.clock is not None:
            return
        if fall < _CLEAR * _POSITION and not self._falls:
            self._still = frame, fall
            return
        self._falls.append((frame, fall))
        if fall > _MOST * self._particle or (fall > self._particle and len(self._falls) >= _FEWEST):
            self.clock = self._start()

    def _start(self) -> Estimate:
        """Frame in which the fall from rest begins; between two frames if it is seen in few."""
        last, first = self._still[0], self._falls[0][0]
        if len(self._falls) < _FEWEST:
            return Estimate((last + first) / 2, (first - last) * UNIFORM, 1)
        some = self._falls[:: -(-len(self._falls) // _MANY)]
        t, s = np.array([self._still, *some]).T
        begins = first + np.linspace(last - t[-1], 0.0, _GRID, endpoint=False)
        for _ in range(2):
            share = _likely(t, s, begins)
            value = float(share @ begins)
            sigma = float(np.sqrt(share @ np.square(begins - value)))
            reach = 5 * max(sigma, begins[1] - begins[0])
            begins = np.linspace(value - reach, min(value + reach, first), _GRID, endpoint=False)
        return Estimate(value, sigma, len(self._falls))


def _likely(t: Floats, s: Floats, begins: Floats) -> Floats:
    """Probability (n,) that falls s(t) [px] give each beginning, for any pull and rho; in sum 1."""
    tau = np.maximum(t - begins[:, None], 0.0)
    mean = np.square(tau) / 2
    pull = s[-1] / mean[:, -1]
    low = np.minimum(tau[:, :, None], tau[:, None, :])
    d = np.abs(tau[:, :, None] - tau[:, None, :])
    walk = (low**5 / 5 + d * low**4 / 2 + d**2 * low**3 / 3) / 4
    walk *= (pull**2 / tau[:, -1])[:, None, None]
    logs = []
    for rho in _CHANGES:
        root = np.linalg.cholesky(rho**2 * walk + _POSITION**2 * np.eye(len(t)))
        known = np.stack([mean, np.broadcast_to(s, mean.shape)], axis=-1)
        h, y = np.moveaxis(np.linalg.solve(root, known), -1, 0)
        hh, hy, yy = (h * h).sum(axis=1), (h * y).sum(axis=1), (y * y).sum(axis=1)
        size = np.log(np.diagonal(root, axis1=1, axis2=2)).sum(axis=1)
        logs.append((hy**2 / hh - yy - np.log(hh)) / 2 - size)
    share = np.exp(np.array(logs) - np.max(logs)).sum(axis=0)
    return np.asarray(share / share.sum())


class Crossing:
    """Crossings of the outlet's row, frame by frame."""

    def __init__(self, particle: float) -> None:
        self._particle = particle  # px
        self._last: float | None = None
        self._steps: deque[float] = deque(maxlen=_LAST)

    def see(self, frame: float, crossed: NDArray[np.bool_], steps: Floats) -> None:
        """Take where something stands in the outlet's row (w,); steps of crossing tracers [px]."""
        if crossed.sum() > _WIDE * self._particle:
            self._last = frame
        self._steps.extend(steps.tolist())

    def over(self, frame: float) -> bool:
        """True if something has crossed, and nothing does so in a frame."""
        return self._last is not None and self._last < frame

    def last(self) -> Estimate | None:
        """Frame at which the last particle's centroid passed; None where nothing crossed.

        Half a particle before its end did. Particles are twice as long as wide, and lie as they
        may.
        """
        if self._last is None:
            return None
        speed = float(np.median(self._steps)) if self._steps else 0.0
        half = self._particle / 2 / speed if speed > 0 else 0.0
        # It was last seen in one frame and gone in the next: on average half a frame later.
        return Estimate(self._last + 0.5 - half, float(np.hypot(UNIFORM, half / 2)), 1)


# Of plane particles the area that is seen is their mass, and does not grow; shadows and particles
# that tilt change it by a hundredth or two.
_AGAIN = 0.05
# By how much falls differ, over their mean, when a twentieth has left: 0 for an object that falls
# as one, 1 where they go with the height down to none (in rendered discharges 0.7 to 1.4).
_ALIKE, _LEFT = 0.25, 0.05
_MAJORITY = 0.5  # of what stands above the outlet, and of what leaves, for it to be so on the whole
_ELSE = "is it a silo from before its opening on, and --roi its inside from the outlet up?"


class Plausible:
    """Looks at a film as it goes by; InputError, one line, for what no discharge does."""

    def __init__(self, path: Path, standing: int, wanted: float) -> None:
        """Tracers above the outlet, and how many there would be if all there were particles."""
        self._path = path
        if standing < _MAJORITY * wanted:
            self._refuse("no material stands above the outlet in the first frame")
        self._first: float | None = None
        self._least = np.inf
        self._deforms = False  # as far as has been seen

    def see(self, area: float, share: float, falls: Floats) -> None:
        """Area of the material, NaN where unknown; tracers not yet below the outlet; all falls."""
        if np.isfinite(area):
            self._first = area if self._first is None else self._first
            self._least = min(self._least, area)
            again = (area - self._least) / max(self._first, 1.0)
            if again > _AGAIN:
                self._refuse(f"{again:.0%} of the material comes back after it left")
        if share < 1 - _LEFT and not self._deforms:
            if falls.std() < _ALIKE * abs(falls.mean()):
                self._refuse("all of it falls alike, as an object and no material does")
            self._deforms = True

    def end(self, across: Floats, ends: tuple[float, float]) -> None:
        """Columns (n,) of tracers that have left, and the outlet's ends, a particle wider [px]."""
        by_it = np.mean((across > ends[0]) & (across < ends[1])) if len(across) else 1.0
        if by_it < _MAJORITY:
            self._refuse(f"{1 - by_it:.0%} of what leaves does not go through the outlet")

    def _refuse(self, what: str) -> None:
        raise InputError(f"{self._path}: {what}: no discharge; {_ELSE}")
