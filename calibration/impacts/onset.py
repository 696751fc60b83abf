"""Onsets of impacts, to a part of a sample, and how well they are known from the noise.

A contact force, and what it sets ringing, begins at zero and rises to its first peak. Onset t0 and
rise r are fitted to the samples up to that peak, by least squares,

    x(t) = b + A sin^p(pi/2 (t - t0)/r)  after t0,      x(t) = b  before.

p = 1 is exact for a linear spring (a half sine) and for a tone; force goes with overlap^(3/2) in a
Hertz contact, so that p is about 3/2 there. What else the true shape adds to t0 goes with r; where
r is the same for all impacts, it does not enter the intervals. Where the rise takes fewer samples
than the fit has unknowns, the onset is only known to lie between two samples.

The power p is common to all impacts. A pulse that is not a half sine begins earlier or later than
one fitted to it, by a part of its rise. Contacts that get stiffer with overlap rise slower at lower
speed (Hertz: as v^(-1/5)), and the flights in between would be off by what their two rises differ.
The power is therefore fitted to all edges together, and what remains unknown of it is carried to
the onsets' uncertainty.

Shapes are compared at last. Each impact's first swing is laid over the mean of the others, in parts
of its own rise and of its first peak, and shifted, stretched and scaled until they agree best
(contacts may get softer at lower speed). Where onsets and shapes agree, the shifts are no larger
than the noise explains. Where they are larger, the impacts have different shapes (sound that takes
another way, a ball that lands on another spot), and the scatter of the shifts is added to every
uncertainty.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

_FIRST_PEAK = 0.25  # of the largest sample of the impact: what counts as its first peak
_CLEAR = 5.0  # standard deviations of the noise, over which a sample is not noise
_LEAST_RISE = 3  # samples of a rise that can be fitted: A, t0, r
# A dashpot's force sets in at once (power 0); one that sets in smoothly, through a filter, rises
# with a square; a linear spring has 1, a Hertz contact 3/2.
_POWERS = (0.5, 2.0)
_ROUNDS = 6
_ALIKE = 0.05  # chance of shifts as large as these, below which the shapes are not alike


@dataclass(frozen=True)
class Edge:
    """The rise of an impact, in samples from `begin` of the signal.

    x, base (n,) the samples and the baseline under them; noise the standard deviation of the
    samples before `first`, the first clear one; peak the first peak.
    """

    begin: int
    x: NDArray[np.float64]
    base: NDArray[np.float64]
    noise: float
    first: int
    peak: int

    @property
    def height(self) -> float:
        """The first peak over the baseline, with its sign."""
        return float(self.x[self.peak] - self.base[self.peak])

    def rising(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sample numbers and samples (k,) up to the peak, upwards, with some before they rise."""
        start = max(0, self.first - max(20, 4 * (self.peak - self.first + 1)))
        part = slice(start, self.peak + 1)
        t = np.arange(part.start, part.stop, dtype=float)
        return t, np.sign(self.height) * (self.x - self.base)[part]


@dataclass(frozen=True)
class Onset:
    """Begin of an impact and how long it rises, in samples; sigma of the time from the noise.

    fit: base, height, time and rise of the model in the edge's own samples; None where too few
    samples rise.
    """

    edge: Edge
    time: float
    sigma: float
    rise: float
    fit: NDArray[np.float64] | None


def edge_of(
    x: NDArray[np.float64], white: NDArray[np.float64], rise: tuple[int, int], window: int
) -> Edge:
    """The edge of an impact whose energy rises from one window to another: their first samples.

    x, white (n,): the samples, and the same through the prediction filter of their noise.
    """
    begin, last = max(0, rise[0] - 2 * window), rise[1] + window
    raw = x[begin : last + window]
    first = _change(white[begin:last], window)
    fit = np.polyfit(np.arange(first), raw[:first], 2)
    base = np.asarray(np.polyval(fit, np.arange(len(raw))), dtype=float)
    part = raw - base
    noise = max(float(np.std(part[:first])), 1e-9 * float(np.abs(part).max()), 1e-300)
    clear = np.flatnonzero(np.abs(part[first : last - begin]) > _CLEAR * noise)
    first += int(clear[0]) if len(clear) else 0
    return Edge(begin, raw, base, noise, first, _first_peak(part, first, noise))


def onset(edge: Edge, power: float) -> Onset:
    """The onset of an edge whose force rises with a power of the sine."""
    return _fitted(edge, power) or _between(edge)


def _change(white: NDArray[np.float64], least: int) -> int:
    """The sample, `least` or later, from which the variance is another: two Gaussian pieces."""
    n = len(white)
    k = np.arange(max(4, min(least, n - 4)), n - 2)
    squares = np.cumsum(white**2)
    smallest = 1e-18 * max(squares[-1], 1e-300)
    before = np.maximum(squares[k - 1], smallest) / k
    after = np.maximum(squares[-1] - squares[k - 1], smallest) / (n - k)
    return int(k[np.argmin(k * np.log(before) + (n - k) * np.log(after))])


def _first_peak(x: NDArray[np.float64], first: int, noise: float) -> int:
    """The largest sample of the first swing that holds a good part of the largest of all."""
    rest = x[first:]
    largest = float(np.abs(rest).max())
    enough = max(_FIRST_PEAK * largest, min(2.0 * _CLEAR * noise, 0.7 * largest))
    begin = int(np.flatnonzero(np.abs(rest) >= enough)[0])
    swing = np.sign(rest[begin]) * rest[begin:]
    over = np.flatnonzero(swing < 0.5 * enough)  # noise may cross `enough` itself again and again
    return first + begin + int(np.argmax(swing[: over[0]] if len(over) else swing))


def _fitted(edge: Edge, power: float) -> Onset | None:
    """By least squares; None where too few samples rise, or the fit goes astray."""
    from scipy.optimize import OptimizeWarning, curve_fit

    t, y = edge.rising()
    length = edge.peak - edge.first + 1
    guess = [0.0, y[-1], edge.first - 1.0, float(length)]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OptimizeWarning)  # said again by an infinite sigma
            found, covariance = curve_fit(
                lambda t, *shape: rising(t, shape, power), t, y, guess,
                sigma=np.full(len(t), edge.noise), absolute_sigma=True, maxfev=500,
            )  # fmt: skip
    except (RuntimeError, ValueError):
        return None
    time, rise, sigma = float(found[2]), float(found[3]), float(np.sqrt(covariance[2, 2]))
    on_edge = edge.first - 2 * length - 2 < time < edge.peak and 0 < rise < 4 * (edge.peak - time)
    if not on_edge or edge.peak - time < _LEAST_RISE or not 0 < sigma < length + 1:
        return None
    return Onset(edge, edge.begin + time, sigma, rise, found)


def rising(t: NDArray[np.float64], shape: ArrayLike, power: float) -> NDArray[np.float64]:
    """The model of the edge, see the head of this file; shape: base, height, begin, rise."""
    base, height, begin, rise = np.asarray(shape)
    part = np.clip((t - begin) / rise, 0.0, 2.0)  # the peak may lie between two samples
    return base + height * np.maximum(np.sin(0.5 * np.pi * part), 0.0) ** power


def _between(edge: Edge) -> Onset:
    """Evenly likely from the sample before the first clear one, and what hid in the noise."""
    least = min(1.0, _CLEAR * edge.noise / abs(edge.height))
    hidden = np.arcsin(least) * 2.0 / np.pi * (edge.peak - edge.first + 1)
    width = 1.0 + hidden
    time = edge.first - 0.5 * width
    return Onset(edge, edge.begin + time, float(width / np.sqrt(12.0)), edge.peak - time, None)


def onsets_of(edges: Sequence[Edge]) -> list[Onset]:
    """Onsets with the power that fits all edges best, and their uncertainty."""
    from scipy.optimize import minimize_scalar

    found = [onset(edge, 1.0) for edge in edges]
    clear = [k for k, one in enumerate(found) if one.fit is not None]
    if len(clear) < 2:
        return found
    best = minimize_scalar(
        lambda power: sum(_misfit(edges[k], power) for k in clear),
        bounds=_POWERS, method="bounded", options={"xatol": 1e-3},
    )  # fmt: skip
    found = [onset(edge, float(best.x)) for edge in edges]
    return _with_power(found, float(best.x))


def _misfit(edge: Edge, power: float) -> float:
    """Chi-squared of an edge's best fit."""
    one = onset(edge, power)
    t, y = edge.rising()
    model = np.zeros_like(y) if one.fit is None else rising(t, one.fit, power)
    return float((((y - model) / edge.noise) ** 2).sum())


def _with_power(found: Sequence[Onset], power: float) -> list[Onset]:
    """The same with the power's uncertainty, as far as it moves onsets against one another."""
    slopes = {k: _slopes(one, power) for k, one in enumerate(found) if one.fit is not None}
    if not slopes:
        return list(found)
    information = sum(known for _, known in slopes.values())
    even = (_POWERS[1] - _POWERS[0]) / np.sqrt(12.0)  # of a power that nothing shows
    sigma = min(even, information**-0.5) if information > 0 else even
    mean = float(np.mean([moved for moved, _ in slopes.values()]))
    return [
        replace(one, sigma=float(np.hypot(one.sigma, sigma * (slopes[k][0] - mean))))
        if k in slopes
        else one
        for k, one in enumerate(found)
    ]


def _slopes(one: Onset, power: float) -> tuple[float, float]:
    """Samples by which an onset moves with the power, and what its edge shows of the power."""
    from scipy.optimize import approx_fprime

    t, _ = one.edge.rising()
    at = np.append(np.asarray(one.fit), power)
    jacobian: NDArray[np.float64] = approx_fprime(at, lambda p: rising(t, p[:4], p[4]))
    moved, *_ = np.linalg.lstsq(jacobian[:, :4], jacobian[:, 4], rcond=None)
    left = jacobian[:, 4] - jacobian[:, :4] @ moved
    return -float(moved[2]), float((left / one.edge.noise) @ (left / one.edge.noise))


def with_shape(x: NDArray[np.float64], onsets: Sequence[Onset]) -> NDArray[np.float64]:
    """The sigma (m,) of each onset in samples: noise, and what the shapes differ beyond it."""
    from scipy.stats import chi2

    noise = np.array([one.sigma for one in onsets])
    if len(onsets) < 3:
        return noise
    shifts, errors = _shifts(x, onsets)
    variance = noise**2 + errors**2
    mean = np.average(shifts, weights=1.0 / variance)
    if chi2.sf(((shifts - mean) ** 2 / variance).sum(), len(shifts) - 1) >= _ALIKE:
        return noise
    excess = max(0.0, float(shifts.var(ddof=1) - variance.mean()))
    return np.hypot(noise, np.sqrt(excess))


def _shifts(
    x: NDArray[np.float64], onsets: Sequence[Onset]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Distance by which each impact lies behind the mean of the others (m,), and its noise."""
    rise = max(_LEAST_RISE, float(np.median([one.rise for one in onsets])))
    u = np.arange(-1.0, 2.0, max(0.25 / rise, 0.01))  # in rises
    swings = np.array([_swing(x, one, u, 0.0, 1.0) for one in onsets])
    shifts, errors = np.zeros(len(onsets)), np.zeros(len(onsets))
    for k, one in enumerate(onsets):
        others = np.delete(swings, k, axis=0).mean(axis=0)
        shifts[k], errors[k] = _laid_over(x, one, u, others)
    return shifts, errors


def _laid_over(
    x: NDArray[np.float64], one: Onset, u: NDArray[np.float64], others: NDArray[np.float64]
) -> tuple[float, float]:
    """Shift in samples of an impact over the others' mean (k,), with a stretch and a height."""
    slope = np.gradient(others, u)
    columns = np.column_stack([slope, u * slope, others])
    inverse = np.linalg.pinv(columns)
    shift, stretch, height = 0.0, 1.0, 1.0
    for _ in range(_ROUNDS):  # Gauss and Newton
        apart = others - _swing(x, one, u, shift, stretch) / height
        behind, wider, lower = inverse @ apart
        shift = float(np.clip(shift + behind, -1.0, 1.0))
        stretch = float(np.clip(stretch + wider, 0.5, 2.0))
        height = float(np.clip(height - lower, 0.5, 2.0))
    step = (u[1] - u[0]) * one.rise  # samples, fewer than one: noise repeats
    error = abs(one.edge.noise / one.edge.height) * np.sqrt((inverse[0] ** 2).sum() / step)
    return shift * one.rise, float(error) * one.rise


def _swing(
    x: NDArray[np.float64], one: Onset, u: NDArray[np.float64], shift: float, stretch: float
) -> NDArray[np.float64]:
    """An impact at u (k,) rises from its onset, shifted and stretched, over its first peak."""
    t = one.time + one.rise * (shift + stretch * u)
    begin, end = int(np.clip(t[0] - 1, 0, len(x) - 1)), int(np.clip(t[-1] + 2, 1, len(x)))
    samples = np.interp(t, np.arange(begin, end), x[begin:end])
    base = one.edge.base[one.edge.peak]
    return np.asarray((samples - base) / one.edge.height)
