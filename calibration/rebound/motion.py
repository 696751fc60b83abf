"""Motion of a particle through its contacts: one fit of position and angle, with its covariance.

Between contacts the centroid moves on a parabola and the angle on a line; at a contact both go on
from where they are, with other velocities. All flights, coordinates and contact times are fitted
together, so that position and angle before a contact also tell of the velocities after it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.statistics import shared_noise
from calibration.tracking.segments import noise
from calibration.tracking.track import Array, Rows
from granulab.errors import InputError

_FEWEST = 4  # positions of a flight: the film then shows more than the fit takes up
_OUTLIER = 4.0  # sigma, which one normal deviate of 16 000 exceeds
_SMOOTH = 0.07  # px: error of a centroid that changes as the particle moves by its radius. Light,
# shade and what is behind a rim shift an edge by 0.2 px (blobs), alike over a part of the outline.
_PASSES = 5  # of fit and noise in turn
_EXACT = 1e-3  # of the noise before: positions without any
_LEVEL = 1e-4  # rad: what an angle in a picture cannot be known better than
_CHANNELS = 3  # x, y, angle


@dataclass(frozen=True)
class Fitted:
    """Motion in flights k = 0 to m - 1 through m - 1 contacts; x to the right, y up.

    parameters   see `Layout`; covariance joint [px, frames, rad]
    residuals    (3, n) of x, y, angle; NaN where not in the fit
    noise        (3,) standard deviation of each
    rows         points of each flight that are in the fit
    jumps        (m - 1, 2) of x [px] and angle [rad] at each contact, were they free, and
    jumps_sigma  their sigma: no single contact where they are not zero
    """

    parameters: Array
    covariance: Array
    layout: "Layout"
    residuals: Array
    noise: Array
    rows: list[Rows]
    jumps: Array
    jumps_sigma: Array


@dataclass(frozen=True)
class Layout:
    """Order of the parameters for m flights.

    times, then of x, y and angle in turn: level at the first contact, acceleration (not of the
    angle), and m velocities: of the first flight at its end, of the others at their beginning.
    """

    m: int

    def times(self, p: Array) -> Array:
        """(m - 1,) of the contacts [frames]."""
        return p[: self.m - 1]

    def channel(self, p: Array, c: int) -> tuple[float, float, Array]:
        """Level, acceleration and velocities of channel c."""
        first = self.m - 1 + c * (self.m + 2)
        if c == 2:
            return float(p[first]), 0.0, p[first + 1 : first + 1 + self.m]
        return float(p[first]), float(p[first + 1]), p[first + 2 : first + 2 + self.m]

    @property
    def size(self) -> int:
        """Number of parameters."""
        return self.m - 1 + 2 * (self.m + 2) + self.m + 1

    def at(self, p: Array, c: int, k: int, t: Array) -> Array:
        """Channel c on flight k at times t."""
        times = self.times(p)
        level, bend, speeds = self.channel(p, c)
        for j in range(1, k):
            gap = times[j] - times[j - 1]
            level += speeds[j] * gap + bend * gap**2 / 2
        s = t - times[max(k - 1, 0)]
        return np.asarray(level + speeds[k] * s + bend * s**2 / 2)

    def velocities(self, p: Array, c: int, j: int) -> tuple[float, float]:
        """Of channel c before and after contact j."""
        times = self.times(p)
        _, bend, speeds = self.channel(p, c)
        gap = times[j] - times[j - 1] if j else 0.0
        return float(speeds[j] + bend * gap), float(speeds[j + 1])


@dataclass(frozen=True)
class _Problem:
    """Points that are fitted: those of each flight (rows), where good (3, n), in sigma (3,)."""

    layout: Layout
    t: Array
    seen: Array
    rows: list[Rows]
    good: NDArray[np.bool_]
    sigma: Array
    level: float

    def residuals(self, p: Array) -> Array:
        """(3, n) of all points of the flights; NaN elsewhere."""
        left = np.full(self.seen.shape, np.nan)
        for c in range(_CHANNELS):
            for k, one in enumerate(self.rows):
                left[c, one] = self.seen[c, one] - self.layout.at(p, c, k, self.t[one])
        return left

    def kept(self, c: int) -> list[Rows]:
        """Points of each flight that count in channel c."""
        return [one[self.good[c, one]] for one in self.rows]

    def off(self, p: Array) -> Array:
        """Residuals in their sigma, channel by channel, flight by flight; last the level's."""
        left = self.residuals(p) / self.sigma[:, None]
        parts = [left[c, one] for c in range(_CHANNELS) for one in self.kept(c)]
        roll = self.layout.channel(p, 0)[1] / self.layout.channel(p, 1)[1]
        return np.concatenate([*parts, [roll / max(self.level, _LEVEL)]])


def fit(
    t: Array, seen: Array, ranges: Sequence[tuple[int, int]], level: float, radius: float
) -> Fitted:
    """The motion through all contacts between flights whose points are `ranges` (i, j not in it).

    t       (n,) time [frames]
    seen    (3, n) x to the right, y up [px], angle [rad]; NaN where the angle was not seen
    level   how well the picture's vertical is that of gravity [rad]
    radius  of the particle [px]

    Points nearer to a contact than half a frame are left out: an exposure may see both flights.
    Raises InputError where a flight has too few points.
    """
    from scipy.optimize import least_squares

    layout = Layout(len(ranges))
    p = _start(layout, t, seen, ranges)
    flights = [np.arange(i, j) for i, j in ranges]
    good = np.isfinite(seen)
    sigma = np.array([noise(t[known], one[known]) for one, known in zip(seen, good, strict=True)])
    for _ in range(_PASSES):
        rows = _clear(t, flights, layout.times(p))
        _refuse_few(rows, seen[2])
        problem = _Problem(layout, t, seen, rows, good, sigma, level)
        found = least_squares(problem.off, p, x_scale="jac")
        p, fitted = np.asarray(found.x), problem
        sigma = _noise(problem, p)
        left = problem.residuals(p)
        good = np.isfinite(seen) & ~(np.abs(left) > _OUTLIER * sigma[:, None])
    covariance = _covariance(fitted, p, np.asarray(found.jac), radius)
    residuals = np.where(fitted.good, fitted.residuals(p), np.nan)
    jumps = _jumps(fitted, p, np.asarray(found.jac))
    return Fitted(p, covariance, layout, residuals, fitted.sigma, fitted.rows, *jumps)


def _covariance(problem: _Problem, p: Array, jacobian: Array, radius: float) -> Array:
    """Of the parameters, with noise that neighbouring positions share (shared_noise)."""
    off = problem.residuals(p) / problem.sigma[:, None]
    height = problem.seen[1] / radius
    smooth = _SMOOTH / problem.sigma / np.array([1.0, 1.0, radius])
    blocks = []
    for c in range(_CHANNELS):
        kept = problem.kept(c)
        for one, block in zip(
            kept, shared_noise.covariances(off[c], height, problem.t, kept), strict=True
        ):
            apart = np.abs(height[one][:, None] - height[one][None])
            blocks.append(block + smooth[c] ** 2 * np.exp(-apart))
    return shared_noise.of_parameters(jacobian[:-1], blocks, jacobian[-1:])


def _jumps(problem: _Problem, p: Array, jacobian: Array) -> tuple[Array, Array]:
    """Jumps of x and angle at each contact, to first order, and their sigma from white noise."""
    channel, flight = (
        np.concatenate([
            np.full(len(one), (c, k)[which])
            for c in range(_CHANNELS)
            for k, one in enumerate(problem.kept(c))
        ])
        for which in (0, 1)
    )  # fmt: skip
    later = [
        np.append(np.where((channel == c) & (flight > j), -1 / problem.sigma[c], 0.0), 0.0)
        for j in range(problem.layout.m - 1)
        for c in (0, 2)
    ]
    whole = np.column_stack([jacobian, *later])
    inverse = np.linalg.pinv(whole.T @ whole, hermitian=True)
    count = len(later)
    found = -(inverse @ whole.T @ problem.off(p))[-count:]
    spread = np.sqrt(np.clip(np.diag(inverse)[-count:], 0, None))
    return found.reshape(-1, 2), spread.reshape(-1, 2)


def _start(layout: Layout, t: Array, seen: Array, ranges: Sequence[tuple[int, int]]) -> Array:
    """Parameters to begin with: each flight's own polynomials, contacts where those of y meet."""
    from calibration.drop.parabolas import contact_times
    from calibration.drop.parabolas import fit as parabolas

    known = parabolas(t, seen[1], list(ranges))
    times = contact_times(known.centre, known.coefficients)
    if layout.m > len(known.centre) or not np.all(np.isfinite(times)):
        raise InputError(
            "the flights do not meet in a contact: the particle was touched, or hidden"
        )
    p = [times]
    for c, degree in enumerate((1, 2, 1)):
        speeds = []
        for k, (i, j) in enumerate(ranges):
            one = np.arange(i, j)[np.isfinite(seen[c, i:j])]
            if len(one) < _FEWEST:
                raise InputError(_few(k, len(one)))
            s = t[one] - times[max(k - 1, 0)]
            value = seen[c, one]
            if degree == 2:
                value = value - known.acceleration[0] * s**2 / 2
            slope, level = np.polyfit(s, value, 1)
            speeds.append(slope)
            if k == 0:
                start = level
        bend = {0: [0.0], 1: [known.acceleration[0]], 2: []}[c]
        p.append(np.array([start, *bend, *speeds]))
    return np.concatenate(p)


def _few(k: int, n: int) -> str:
    return (
        f"flight {k + 1} has {n} positions with a silhouette; {_FEWEST} are needed: film at a "
        "higher rate, or more of the flight"
    )


def _refuse_few(rows: list[Rows], angle: Array) -> None:
    for k, one in enumerate(rows):
        n = int(np.isfinite(angle[one]).sum())
        if n < _FEWEST - 1:
            raise InputError(_few(k, n))


def _clear(t: Array, flights: list[Rows], times: Array) -> list[Rows]:
    """The points of each flight, half a frame and more from its contacts."""
    lowest = np.concatenate([[-np.inf], times + 0.5])
    highest = np.concatenate([times - 0.5, [np.inf]])
    return [
        one[(t[one] >= a) & (t[one] <= b)]
        for one, a, b in zip(flights, lowest, highest, strict=True)
    ]


def _noise(problem: _Problem, p: Array) -> Array:
    """(3,) standard deviation of each channel from its residuals, less what the fit took up."""
    found = problem.sigma.copy()
    residuals = problem.residuals(p)
    for c in range(_CHANNELS):
        left = residuals[c, np.concatenate(problem.kept(c))]
        freedom = len(left) - (problem.layout.m + 1 + (c != 2))
        if freedom > 0:
            found[c] = max(float(np.sqrt(np.sum(left**2) / freedom)), _EXACT * found[c])
    return found
