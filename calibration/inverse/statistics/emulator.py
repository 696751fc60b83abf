"""Emulator: the simulator's values between the points where it was run, with uncertainty.

Each combination z of the observation is a Gaussian process of the parameters' coordinates
(squared exponential, a length for each parameter) with the seeds' scatter as known noise at each
point (Rasmussen and Williams, Gaussian Processes for Machine Learning, 2006, eqs 2.25 and 2.26).
Whether a trial passes or is blocked is a Gaussian process classification (their sec. 3.4).
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from calibration.inverse.statistics.data import Runs
from calibration.inverse.statistics.prior import Array
from calibration.inverse.statistics.reduction import point_means

# Coordinates are in standard deviations of the prior, of which its whole width is 3.5 to 6: a
# length below a half would make a wave out of noise, one above 50 is a straight line.
_LENGTHS = 0.5, 50.0
_LOWEST_CHANCE = 1e-3  # that no classifier is sure of from tens of runs


@dataclass(frozen=True)
class Processes:
    """k Gaussian processes over the same n points, as arrays, so that many are evaluated at once.

    points (n, p); lengths (k, p) and amplitude (k,) of the kernel; mean (k,) far from all points
    weights (k, n) = (K + noise)^-1 (z - mean); root (k, n, n): inverse of its Cholesky factor
    """

    points: Array
    lengths: Array
    amplitude: Array
    mean: Array
    weights: Array
    root: Array

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Mean (m, k), and variance of that mean (m, k), at coordinates (m, p)."""
        parts = [self._one(k, x) for k in range(len(self.mean))]
        mean, variance = zip(*parts, strict=True)
        return np.stack(mean, axis=1), np.stack(variance, axis=1)

    def _one(self, k: int, x: Array) -> tuple[Array, Array]:
        there, here = self.points / self.lengths[k], x / self.lengths[k]
        # |a - b|^2 multiplied out: no array larger than (m, n) is made
        apart = (here**2).sum(axis=1)[:, None] + (there**2).sum(axis=1) - 2 * here @ there.T
        kernel = self.amplitude[k] * np.exp(-0.5 * np.maximum(apart, 0.0))
        known = ((kernel @ self.root[k].T) ** 2).sum(axis=1)
        mean = self.mean[k] + kernel @ self.weights[k]
        return mean, np.maximum(self.amplitude[k] - known, 0.0)


def processes_of(
    points: Array, which: np.ndarray, z: Array, scatter: Array, seed: int
) -> Processes:
    """A process for each z of runs (r, k) at points (r,) of (n, p).

    scatter    (k, k) covariance of z of single runs
    """
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel

    at, means, counts = point_means(which, z)
    centre = means.mean(axis=0)
    fitted = []
    for k in range(z.shape[1]):
        variance = float(means[:, k].var()) or 1.0
        kernel = ConstantKernel(variance, (1e-3 * variance, 1e3 * variance)) * RBF(
            np.full(points.shape[1], 2.0), _LENGTHS
        )
        noise = np.maximum(scatter[k, k] / counts, 1e-8 * variance)
        process = GaussianProcessRegressor(
            kernel, alpha=noise, n_restarts_optimizer=1, random_state=seed
        )
        fitted.append(_quietly(partial(process.fit, points[at], means[:, k] - centre[k])))
    theta = np.exp([process.kernel_.theta for process in fitted])
    roots = [np.linalg.inv(process.L_) for process in fitted]
    weights = [process.alpha_ for process in fitted]
    return Processes(
        points[at], theta[:, 1:], theta[:, 0], centre, np.array(weights), np.array(roots)
    )


@dataclass(frozen=True)
class Chance:
    """Probability that a trial passes; `classifier` is None where no run says that it may not."""

    classifier: Any

    def __call__(self, x: Array) -> Array:
        """(m,) at coordinates (m, p)."""
        if self.classifier is None:
            return np.ones(len(x))
        passed = list(self.classifier.classes_).index(True)
        chance = self.classifier.predict_proba(x)[:, passed]
        return np.clip(chance, _LOWEST_CHANCE, 1 - _LOWEST_CHANCE)


def chance_of(runs: Runs, seed: int) -> Chance:
    """Probability that a trial passes, from all runs; not known where all of them end alike."""
    which, passed = runs.outcomes()
    if len(set(passed.tolist())) < 2:
        return Chance(None)
    from sklearn.gaussian_process import GaussianProcessClassifier
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel

    kernel = ConstantKernel(1.0, (1e-2, 1e3)) * RBF(np.full(runs.points.shape[1], 2.0), _LENGTHS)
    classifier = GaussianProcessClassifier(kernel, random_state=seed)
    return Chance(_quietly(partial(classifier.fit, runs.points[which], passed)))


def _quietly(fit: Callable[[], Any]) -> Any:
    """Fit without the warning that a length ended at its bound, where the likelihood is flat."""
    from sklearn.exceptions import ConvergenceWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        return fit()
