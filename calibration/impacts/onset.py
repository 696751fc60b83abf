"""When an impact begins, to a part of a sample, and how well that is known from the noise.

A contact force, and what it sets ringing, begins at zero and rises to its first peak. Onset t0 and
rise r are fitted to the samples up to that peak, by least squares,

    x(t) = b + A sin^p(pi/2 (t - t0)/r)  after t0,      x(t) = b  before.

p = 1 is exact for a linear spring (a half sine) and for a tone; force goes with overlap^(3/2) in a
Hertz contact, so that p is about 3/2 there. It is common to all impacts (impacts.power).
What else the true shape adds to t0 goes with r; where r is the same for all impacts, it does not
enter the intervals. calibration.impacts.shape looks whether they have the same shape. Where the
rise takes fewer samples than the fit has unknowns, the onset is only known to lie between two
samples.
"""

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

_FIRST_PEAK = 0.25  # of the largest sample of the impact: what counts as its first peak
_CLEAR = 5.0  # standard deviations of the noise, over which a sample is not noise
_LEAST_RISE = 3  # samples of a rise that can be fitted: A, t0, r


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
    """When an impact begins and how long it rises, in samples; sigma of the time from the noise.

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
