"""The few combinations of what was observed that depend on the parameters.

Curves and profiles have many values that move together. With s the values of a run in units of
their noise, and M those of the points' means over the seeds, the singular value decomposition
M - <M> = U S V^T gives the combinations z = V^T (s - <M>) (principal components; Higdon et al.,
J. Am. Stat. Assoc. 103 (2008) 570). Any linear combination is a valid statistic, with the
covariance that follows from that of s: what the choice costs is information, never truth.

Kept are those that differ from point to point by more than chance (one-way analysis of variance,
p < 0.01) and by a third of the noise at least: one that varies less over all of the prior makes it
no narrower than by 5 %. What is left says next to nothing of the parameters, and serves to ask
whether the simulator can make such an observation at all.
"""

from dataclasses import dataclass

import numpy as np

from calibration.inverse.statistics.data import Observed
from calibration.inverse.statistics.prior import Array

_CHANCE = 0.01
_TELLS = 1 / 3  # of the noise
_LEAST_FREEDOM = 20  # from which the scatter near the posterior is believed: known to 16 %
_FREEDOM_EACH = 3  # degrees of freedom of the scatter for each combination, at least


@dataclass(frozen=True)
class Reduction:
    """z = weights (s - centre), and back, s = centre + modes z, as far as the z determine it.

    noise      (d,) what values were divided by
    weights    (k, d); modes (d, k); centre (d,)
    """

    noise: Array
    centre: Array
    weights: Array
    modes: Array

    def of(self, values: Array) -> Array:
        """(..., k) of values (..., d)."""
        return (values - self.centre) @ self.weights.T

    def back(self, z: Array) -> Array:
        """(..., d) in SI of z (..., k)."""
        return self.centre + z @ self.modes.T

    def rest(self, values: Array) -> Array:
        """Remainder that the z do not hold, in units of the noise (..., d)."""
        return (values - self.back(self.of(values))) / self.noise


def scatter(which: np.ndarray, values: Array, near: np.ndarray | None = None) -> tuple[Array, int]:
    """Covariance (d, d) of runs (r, d) at the same point, and its degrees of freedom.

    which    (r,) points of the runs; near: points from which it is taken, where they suffice
    """
    parts = []
    for point in np.unique(which):
        group = values[which == point]
        parts.append((point, group - group.mean(axis=0), len(group) - 1))
    if near is not None:
        close = [part for part in parts if part[0] in near]
        if sum(part[2] for part in close) >= _LEAST_FREEDOM:
            parts = close
    freedom = sum(part[2] for part in parts)
    about = np.concatenate([part[1] for part in parts])
    return about.T @ about / max(freedom, 1), freedom


def inflation(freedom: int, combinations: int) -> float:
    """Factor by which a scatter from few runs counts.

    The inverse of an estimated covariance is too large, by f/(f - k - 1) on average (Hartlap et
    al., Astron. Astrophys. 464 (2007) 399); without it, intervals would be too short.
    """
    return freedom / max(freedom - combinations - 1, 1)


def point_means(which: np.ndarray, values: Array) -> tuple[np.ndarray, Array, np.ndarray]:
    """Points that have runs (m,), the means of their runs (m, d) and how many they are (m,)."""
    points, counts = np.unique(which, return_counts=True)
    return points, np.array([values[which == k].mean(axis=0) for k in points]), counts


def reduce(observed: Observed, which: np.ndarray, values: Array) -> Reduction:
    """The combinations that runs (r, d) at points (r,) differ by."""
    single, freedom = scatter(which, values)
    noise = np.sqrt(observed.sigma**2 + np.diag(single) / observed.trials)
    _, means, _ = point_means(which, values)
    centre = means.mean(axis=0)
    _, size, rotated = np.linalg.svd((means - centre) / noise, full_matrices=False)
    spread = size / np.sqrt(len(means))
    scores = ((values - centre) / noise) @ rotated.T
    most = max(freedom // _FREEDOM_EACH, 1)
    kept = [
        k
        for k in range(min(len(size), most))
        if k == 0 or (spread[k] > _TELLS and _differs(which, scores[:, k]))
    ]
    directions = rotated[kept]
    return Reduction(noise, centre, directions / noise, (directions * noise).T)


def _differs(which: np.ndarray, score: Array) -> bool:
    """True where points differ by more than their runs do; no, where runs do not differ at all."""
    from scipy.stats import f

    _, means, counts = point_means(which, score[:, None])
    between = float((counts * (means[:, 0] - score.mean()) ** 2).sum())
    within = float(((score - score.mean()) ** 2).sum()) - between
    low, high = len(counts) - 1, len(score) - len(counts)
    if low < 1 or high < 1 or within <= 0:
        return between > 0
    return bool(f.sf(between / low / (within / high), low, high) < _CHANCE)
