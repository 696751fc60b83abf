"""Distributions of particle sizes: normal, lognormal, or by a table of sieves.

Each is a function of quantiles by number, 0 to 1 (n,), that returns sizes (n,) [m]. Normal and
lognormal ones are cut at CUT standard deviations on both sides.
"""

import math
from collections.abc import Callable

import numpy as np

from granulab.errors import InputError

CUT = 3.0  # standard deviations at which a distribution is cut off on both sides

Sizes = Callable[[np.ndarray], np.ndarray]


def spread(distribution: str, mean: float, deviation: float) -> Sizes:
    """Sizes of a "normal" or "lognormal" distribution; InputError where it is too wide."""
    most = mean / CUT if distribution == "normal" else mean
    if deviation >= most:
        raise InputError(
            f"size_deviation = {1e3 * deviation:g} mm: wider than its mean of {1e3 * mean:g} mm "
            f"takes; give less than {1e3 * most:.3g} mm"
            + (", or 'lognormal'" if distribution == "normal" else "")
        )
    return (_normal if distribution == "normal" else _lognormal)(mean, deviation)


def _between_cuts(quantile: np.ndarray) -> np.ndarray:
    """The standard normal variable of quantiles of its part within the cuts."""
    from scipy.special import ndtr, ndtri

    return ndtri(ndtr(-CUT) + quantile * (ndtr(CUT) - ndtr(-CUT)))


def _normal(mean: float, deviation: float) -> Sizes:
    return lambda quantile: mean + deviation * _between_cuts(quantile)


def _lognormal(mean: float, deviation: float) -> Sizes:
    """The size has this mean and deviation; its logarithm is normal."""
    width = math.sqrt(math.log1p((deviation / mean) ** 2))
    return lambda quantile: mean * np.exp(width * _between_cuts(quantile) - 0.5 * width**2)


def sieved(sieve: np.ndarray, passing: np.ndarray, dimensions: int) -> Sizes:
    """Sizes of a sieve table: between two sieves mass is spread evenly over the size.

    sieve (n,) openings [m]; passing (n,) share of the mass that passes each [-]. The number of
    particles is then spread as d^-D, D the dimensions of what grows with the size: in a class from
    a to b its share goes as the mass times (a^-p - b^-p)/(p (b - a)), p = D - 1, and d^-p is even.
    """
    if len(sieve) < 2 or sieve[0] <= 0.0 or (np.diff(sieve) <= 0.0).any():
        raise InputError("sieve: sizes must be above 0 and ascend, two at least")
    if passing[0] != 0.0 or passing[-1] != 1.0 or (np.diff(passing) < 0.0).any():
        raise InputError(
            "sieve: the share of the mass that passes must rise from 0 at the finest to 1 at the "
            "coarsest"
        )
    power = dimensions - 1.0
    low, high = sieve[:-1] ** -power, sieve[1:] ** -power
    number = np.diff(passing) * (low - high) / np.diff(sieve)
    edge = np.append(0.0, np.cumsum(number / number.sum()))

    def sizes(quantile: np.ndarray) -> np.ndarray:
        k = np.clip(np.searchsorted(edge, quantile, side="right") - 1, 0, len(low) - 1)
        part = (quantile - edge[k]) / (edge[k + 1] - edge[k])
        return (low[k] + part * (high[k] - low[k])) ** (-1.0 / power)

    return sizes
