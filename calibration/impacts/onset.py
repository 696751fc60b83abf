"""When an impact begins, to a part of a sample, and how well that is known from the noise.

A contact force, and what it sets ringing, begins at zero and rises to its first peak. Onset t0 and
rise r are fitted to the samples up to that peak, by least squares,

    x(t) = b + A sin(pi/2 (t - t0)/r)  after t0,      x(t) = b  before,

exact for a linear spring (a half sine) and for a tone. Whatever the true shape adds to t0 is the
same for all impacts of the same shape, and does not enter the intervals; calibration.impacts.shape
looks whether they have it. Where the rise takes fewer samples than the fit has unknowns, the onset
is only known to lie between two samples.
"""

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

_FIRST_PEAK = 0.25  # of the largest sample of the impact: what counts as its first peak
_CLEAR = 5.0  # standard deviations of the noise, over which a sample is not noise
_LEAST_RISE = 3  # samples of a rise that can be fitted: A, t0, r


@dataclass(frozen=True)
class Onset:
    """Of one impact, in samples: when, its uncertainty from the noise, and where it first peaks.

    height is the first peak over the baseline `base`, with its sign; noise the standard deviation
    of the samples before.
    """

    time: float
    sigma: float
    peak: int
    height: float
    base: float
    noise: float


def onset(
    x: NDArray[np.float64], white: NDArray[np.float64], rise: tuple[int, int], window: int
) -> Onset:
    """The onset of an impact whose energy rises from one window to another: their first samples.

    x, white (n,): the samples, and the same through the prediction filter of their noise.
    """
    begin, last = max(0, rise[0] - 2 * window), rise[1] + window
    raw = x[begin : last + window]
    first = _change(white[begin:last], window)
    base = np.polyval(np.polyfit(np.arange(first), raw[:first], 2), np.arange(len(raw)))
    part = raw - base
    noise = max(float(np.std(part[:first])), 1e-9 * float(np.abs(part).max()), 1e-300)
    clear = np.flatnonzero(np.abs(part[first : last - begin]) > _CLEAR * noise)
    first += int(clear[0]) if len(clear) else 0
    peak = _first_peak(part, first, noise)
    time, sigma = _fitted(part, noise, first, peak) or _between(part, noise, first, peak)
    return Onset(begin + time, sigma, begin + peak, float(part[peak]), float(base[peak]), noise)


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


def _fitted(
    x: NDArray[np.float64], noise: float, first: int, peak: int
) -> tuple[float, float] | None:
    """Onset and sigma by least squares; None where too few samples rise, or the fit goes astray."""
    from scipy.optimize import OptimizeWarning, curve_fit

    length = peak - first + 1
    start = max(0, first - max(20, 4 * length))
    t = np.arange(start, peak + 1, dtype=float)
    y = np.sign(x[peak]) * x[start : peak + 1]
    guess = [0.0, y[-1], first - 1.0, float(length)]
    errors = np.full(len(t), noise)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", OptimizeWarning)  # said again by an infinite sigma
            found, covariance = curve_fit(
                _rising, t, y, guess, sigma=errors, absolute_sigma=True, maxfev=500
            )
    except (RuntimeError, ValueError):
        return None
    time, sigma = float(found[2]), float(np.sqrt(covariance[2, 2]))
    on_edge = first - 2 * length - 2 < time < peak and 0 < found[3] < 4 * (peak - time)
    if not on_edge or peak - time < _LEAST_RISE or not 0 < sigma < length + 1:
        return None
    return time, sigma


def _rising(
    t: NDArray[np.float64], base: float, height: float, begin: float, rise: float
) -> NDArray[np.float64]:
    """The model of the edge: see the head of this file."""
    part = np.clip((t - begin) / rise, 0.0, 2.0)  # the peak may lie between two samples
    return base + height * np.sin(0.5 * np.pi * part)


def _between(x: NDArray[np.float64], noise: float, first: int, peak: int) -> tuple[float, float]:
    """Evenly likely from the sample before the first clear one, and what hid in the noise."""
    hidden = np.arcsin(min(1.0, _CLEAR * noise / abs(x[peak]))) * 2.0 / np.pi * (peak - first + 1)
    width = 1.0 + hidden
    return float(first - 0.5 * width), float(width / np.sqrt(12.0))
