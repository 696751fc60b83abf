"""Mean and scatter of trials that are nested: trials of a height, heights of a particle, particles.

    e = mean + particle + height of that particle + trial

each a normal deviate of its own variance. That of trials is the one within the cells (a particle's
height); the others are those of largest restricted likelihood of the cells' means (Patterson and
Thompson 1971, doi 10.1093/biomet/58.3.545). The mean is that of generalised least squares, its
degrees of freedom are Satterthwaite's (1946, doi 10.2307/3002019): three particles of thirty trials
each say of the next particle what three values say.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from calibration.statistics.uncertainty import Estimate, student

Array = NDArray[np.float64]
Covariance = Callable[[Array], Array]  # of the means, from variances of heights and particles

_STEP = 1e-2  # share of a variance, for slopes
_EXACT = 1e-9  # share of the means' variance that keeps matrices regular
_NOTHING = 1e-3  # share of all variance that a part may have and still be none


@dataclass(frozen=True)
class Mixed:
    """The mean with its sigma and effective degrees of freedom, and scatter by its origin.

    trial, height, particle   standard deviations; None where nothing is repeated that shows it
    """

    mean: Estimate
    freedom: float
    trial: float | None
    height: float | None
    particle: float | None


def mixed(cells: Mapping[str, Estimate], particle_of: Mapping[str, str]) -> Mixed:
    """The mean over cells, of which each has its mean, number of trials and their scatter.

    particle_of   the particle of each cell; two particles and more, one with two cells and more
    """
    ones = list(cells.values())
    names = np.array([particle_of[name] for name in cells])
    n = np.array([one.trials for one in ones], dtype=float)
    y = np.array([one.value for one in ones])
    within = sum((one.trials - 1) * (one.scatter or 0.0) ** 2 for one in ones)
    trial = within / (n.sum() - len(n)) if n.sum() > len(n) else 0.0
    alike = np.equal.outer(names, names).astype(float)
    least = _EXACT * (float(np.var(y)) or 1.0)  # trials that do not differ at all

    def covariance(variances: Array) -> Array:
        height, particle = variances
        return np.asarray(np.diag(trial / n + height + least) + particle * alike)

    found = _likeliest(y, covariance)
    mean, variance = _mean(y, covariance(found))
    freedom = _freedom(y, found, covariance)
    height, particle = map(math.sqrt, found)
    scatter = math.sqrt(float(found.sum()) + trial)
    sigma = student(round(freedom, 6)) * math.sqrt(variance)
    whole = Estimate(mean, sigma or None, int(n.sum()), scatter)
    return Mixed(whole, freedom, math.sqrt(trial) if trial else None, height, particle)


def _mean(y: Array, covariance: Array) -> tuple[float, float]:
    """Generalised least squares' mean and its variance."""
    weight = np.linalg.solve(covariance, np.ones(len(y)))
    variance = 1 / float(weight.sum())
    return variance * float(weight @ y), variance


def _misfit(y: Array, covariance: Array) -> float:
    """Minus the logarithm of the restricted likelihood."""
    mean, variance = _mean(y, covariance)
    off = y - mean
    square = float(off @ np.linalg.solve(covariance, off))
    return float(np.linalg.slogdet(covariance)[1] - math.log(variance) + square) / 2


def _likeliest(y: Array, covariance: Covariance) -> Array:
    """(2,) variances of heights and particles, of which none is negative."""
    from scipy.optimize import minimize

    unit = float(np.var(y) + np.mean(np.diag(covariance(np.zeros(2)))))

    def criterion(roots: Array) -> float:
        return _misfit(y, covariance(unit * np.square(roots)))

    starts = [(a, b) for a in (0.1, 0.5, 1.0) for b in (0.0, 0.5, 1.0)]
    start = min(starts, key=lambda one: criterion(np.array(one)))
    best = minimize(criterion, start, method="Nelder-Mead", options={"maxfev": 400})
    found = unit * np.square(np.asarray(best.x, dtype=float))
    return np.where(found > _NOTHING * unit, found, 0.0)


def _freedom(y: Array, found: Array, covariance: Covariance) -> float:
    """Satterthwaite's degrees of freedom: 2 variance^2 over the variance of the mean's variance."""
    most = float(len(y) - 1)
    free = np.flatnonzero(found)
    steps = [np.where(np.arange(2) == k, _STEP * found, 0.0) for k in free]
    if not steps:
        return most

    def slope(quantity: Callable[[Array], float], one: Array) -> float:
        return float(quantity(found + one) - quantity(found - one)) / (2 * one.sum())

    def misfit(at: Array) -> float:
        return _misfit(y, covariance(at))

    def variance(at: Array) -> float:
        return _mean(y, covariance(at))[1]

    gradient = np.array([slope(variance, one) for one in steps])

    def bent(a: Array, b: Array) -> float:
        return slope(lambda at: (misfit(at + a) - misfit(at - a)) / (2 * a.sum()), b)

    bend = np.array([[bent(a, b) for b in steps] for a in steps])
    scatter = float(gradient @ np.linalg.pinv(bend, hermitian=True) @ gradient)
    return float(np.clip(2 * variance(found) ** 2 / scatter, 1.0, most)) if scatter > 0 else most
