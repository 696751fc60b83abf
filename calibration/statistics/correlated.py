"""Values that share their errors: covariance through formulas, the pooled value, and its test."""

from collections.abc import Callable

import numpy as np

from calibration.drop.parabolas import scatter_beyond_noise
from calibration.statistics.uncertainty import Estimate, student
from calibration.tracking.track import Array

CHANCE = 0.01  # p below which one number does not describe the values


def propagated(
    parameters: Array, covariance: Array, quantity: Callable[[Array], Array]
) -> tuple[Array, Array]:
    """A vector of quantities of (n,) parameters, and its covariance to first order (GUM 5.1)."""
    value = quantity(parameters)
    sigma = np.sqrt(np.clip(np.diag(covariance), 0, None))
    slopes = np.zeros((len(value), len(sigma)))
    for k in np.flatnonzero(sigma > 0):
        step = np.zeros(len(sigma))
        step[k] = sigma[k] * 1e-2  # small: bends of the formula do not count, rounding neither
        high, low = (quantity(parameters + s * step) for s in (1, -1))
        slopes[:, k] = (high - low) / (2 * step[k])
    return value, slopes @ covariance @ slopes.T


def with_sigma(value: Array, covariance: Array) -> Array:
    """(n, 2) values with their standard deviations."""
    return np.stack([value, np.sqrt(np.clip(np.diag(covariance), 0, None))], axis=1)


def pool(values: Array, covariance: Array) -> tuple[Estimate, float | None]:
    """The mean of correlated values, each weighted by its own sigma; p of them being one.

    Best weights follow correlations, and go beyond the values where these are strong: then sigma
    is as good as they are known, which few positions do not say. Those by each value's own sigma
    need none, and the mean's sigma takes them from the whole covariance.

    Where values are not one, their scatter beyond noise counts with every value: the mean is then
    that of such values, and its sigma, with Student's factor, how well these few give it. p is None
    for one value.
    """
    from scipy.stats import chi2

    mean, variance = _mean(values, covariance)
    if len(values) == 1:
        return Estimate(mean, float(np.sqrt(variance)), 1), None
    p = float(chi2.sf(_chi_square(values, covariance), len(values) - 1))
    if p < CHANCE:
        extra = scatter_beyond_noise(with_sigma(values, covariance)) ** 2
        mean, variance = _mean(values, covariance + extra * np.eye(len(values)))
        variance *= student(len(values) - 1) ** 2
    return Estimate(mean, float(np.sqrt(variance)), len(values)), p


def _mean(values: Array, covariance: Array) -> tuple[float, float]:
    """Mean by the values' own variances, and its variance."""
    weight = 1 / np.diag(covariance)
    weight = weight / weight.sum()
    return float(weight @ values), float(weight @ covariance @ weight)


def _chi_square(values: Array, covariance: Array) -> float:
    """Of the values about the mean that makes it least."""
    inverse = np.linalg.pinv(covariance, hermitian=True)
    off = values - inverse.sum(axis=0) @ values / inverse.sum()
    return float(off @ inverse @ off)
