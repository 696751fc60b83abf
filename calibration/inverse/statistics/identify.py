"""Identifiability: what the observation determines of the parameters, and what it cannot.

In coordinates whose prior has the width 1, the Fisher information of the observation is

    F = J^T C^-1 J + (n + n') grad P grad P^T / (P (1 - P)),    J = dm/dx at the posterior's mean

(C as in posterior.py). Along an eigenvector of F with the eigenvalue l, a narrow posterior has
the variance 1/(l + 1). A parameter, or a combination, is called identifiable where its posterior
is at most half as wide as its prior: then the observation holds at least three times as much
information as the prior (l >= 3).
"""

from dataclasses import dataclass

import numpy as np

from calibration.inverse.statistics.posterior import Model, Posterior
from calibration.inverse.statistics.prior import Array

NARROWER = 0.5  # width of the posterior over that of the prior, at most, of what is identifiable
_STEP = 1e-3  # of the derivatives, in widths of the prior
_UNLIKELY = 0.01  # probability below which an observation is not that of the simulator
_EDGE = 0.05  # of the prior, at either end
_HELD = 0.25  # of the posterior in there: the prior and not the observation ends it


@dataclass(frozen=True)
class Direction:
    """An eigenvector of the Fisher information.

    along          (p,) of length 1, in widths of the prior; its largest part is positive
    information    the eigenvalue
    width          of the posterior along it over that of the prior
    """

    along: Array
    information: float
    width: float

    @property
    def identifiable(self) -> bool:
        """See the head of the file."""
        return self.width <= NARROWER


@dataclass(frozen=True)
class Goodness:
    """Judgement whether the simulator can make the observation at any parameters of the prior.

    chi2, freedom    least of the posterior's samples; values less parameters that they determine
    p                chance of so much or more
    p_rest           likewise, of what does not depend on the parameters; None where all does
    off              (d,) observed less expected where the posterior is, in standard deviations
    """

    chi2: float
    freedom: float
    p: float
    p_rest: float | None
    off: Array

    @property
    def reproducible(self) -> bool:
        """No, where either chance is below 1 %."""
        return min(self.p, 1.0 if self.p_rest is None else self.p_rest) >= _UNLIKELY


def widths(posterior: Posterior) -> Array:
    """Standard deviation of each parameter after over before the fit (p,)."""
    priors = posterior.model.priors
    return posterior.samples.std(axis=0) / np.array([prior.sd for prior in priors])


def correlations(posterior: Posterior) -> Array:
    """(p, p) of the posterior."""
    return np.atleast_2d(np.corrcoef(posterior.samples, rowvar=False))


def fisher(model: Model, x: Array) -> Array:
    """(p, p) at coordinates (p,)."""
    steps = _STEP * np.eye(len(x))
    found = np.zeros((len(x), len(x)))
    if model.processes is not None:
        high, low = (model.processes.predict(x + side * steps)[0] for side in (1, -1))
        slope = (high - low) / (2 * _STEP)  # (p, k)
        _, covariance = model.residual(x[None])
        found += slope @ np.linalg.solve(covariance[0], slope.T)
    if model.chance.classifier is not None:
        high, low = (model.chance(x + side * steps) for side in (1, -1))
        slope = (high - low) / (2 * _STEP)
        chance = float(model.chance(x[None])[0])
        trials = model.observed.passed + model.observed.blocked
        found += trials * np.outer(slope, slope) / (chance * (1 - chance))
    return found


def directions(posterior: Posterior) -> list[Direction]:
    """The eigenvectors of the Fisher information, the best known first."""
    samples = posterior.samples
    scale = np.array([prior.sd for prior in posterior.model.priors])
    values, vectors = np.linalg.eigh(fisher(posterior.model, samples.mean(axis=0)))
    found = []
    for k in np.argsort(values)[::-1]:
        along = vectors[:, k] * np.sign(vectors[np.abs(vectors[:, k]).argmax(), k])
        width = float((samples @ along).std() / np.linalg.norm(scale * along))
        found.append(Direction(along, max(float(values[k]), 0.0), width))
    return found


def at_the_edge(posterior: Posterior) -> list[tuple[int, str]]:
    """Parameters whose posterior runs against an end of the prior, and which end."""
    found = []
    narrow = widths(posterior) <= NARROWER
    for k, prior in enumerate(posterior.model.priors):
        share = prior.share(posterior.samples[:, k])
        for end, held in (("lower", share < _EDGE), ("upper", share > 1 - _EDGE)):
            if narrow[k] and held.mean() > _HELD:
                found.append((k, end))
    return found


def goodness(posterior: Posterior) -> Goodness | None:
    """Goodness of the best fit; None where only outcomes were observed."""
    from scipy.stats import chi2

    model = posterior.model
    if model.processes is None or model.reduction is None:
        return None
    samples = posterior.samples[:: max(len(posterior.samples) // 4000, 1)]
    least = float(model.chi2(samples).min())
    determined = sum(d.information / (1 + d.information) for d in directions(posterior))
    freedom = max(len(model.z) - determined, 1.0)
    expected = model.reduction.back(model.processes.predict(samples)[0])
    observed = model.observed
    variance = observed.sigma**2 + np.diag(observed.over_trials(model.single))
    off = (observed.values - expected.mean(axis=0)) / np.sqrt(variance + expected.var(axis=0))
    return Goodness(least, freedom, float(chi2.sf(least, freedom)), _rest(model), off)


def _rest(model: Model) -> float | None:
    """Chance of so much in the observation that no parameter changes (Satterthwaite's chi2)."""
    from scipy.stats import chi2

    reduction, observed = model.reduction, model.observed
    assert reduction is not None
    if len(model.z) == len(observed.values):
        return None
    keep = np.eye(len(observed.values)) - reduction.modes @ reduction.weights
    noise = np.diag(observed.sigma**2) + observed.over_trials(model.single)
    covariance = keep @ noise @ keep.T / np.outer(reduction.noise, reduction.noise)
    total, squares = np.trace(covariance), np.trace(covariance @ covariance)
    size = float((reduction.rest(observed.values) ** 2).sum())
    return float(chi2.sf(size * total / squares, total**2 / squares))
