"""The parameters' posterior distribution: likelihood from the emulator, samples from emcee.

    ln L = -(z - m)^T C^-1 (z - m)/2 - ln det C/2 + n ln P + n' ln(1 - P)

with the observed combinations z, the emulator's m(x) and C = measuring + scatter/trials + the
emulator's own variance at x, the chance P(x) that a trial passes, and the n that passed and n'
that were blocked. Samples: emcee (Foreman-Mackey et al., Publ. Astron. Soc. Pac. 125 (2013) 306),
by differences of walkers (ter Braak, Stat. Comput. 16 (2006) 239): a third of the stretch move's
memory, for posteriors that the walkers begin in.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from calibration.inverse.statistics.data import Observed, Runs
from calibration.inverse.statistics.emulator import Chance, Processes, chance_of, processes_of
from calibration.inverse.statistics.prior import Array, Prior, within
from calibration.inverse.statistics.reduction import Reduction, inflation, reduce, scatter

if TYPE_CHECKING:
    import emcee

# Many walkers, which begin as draws from the posterior already, need few steps.
_WALKERS = 200
_STEPS = 30  # in a row; so many more as long as the chain is short against its memory
_MOST = 80  # times
_MEMORIES = 20  # autocorrelation times that a chain lasts at least
_DRAWS = 4096  # of the prior, from which the walkers begin


class NothingPassed(Exception):
    """No run gave what was observed: there is nothing to compare with."""


@dataclass(frozen=True)
class Model:
    """Likelihood of coordinates, as known after some runs.

    chance       that a trial passes
    reduction    to the combinations z; None where only outcomes were observed
    processes    that emulate z
    z, noise     (k,) as observed, and the covariance (k, k) of measuring and of chance in them
    single       (d, d) covariance of single trials at the same parameters
    """

    priors: tuple[Prior, ...]
    observed: Observed
    chance: Chance
    reduction: Reduction | None = None
    processes: Processes | None = None
    z: Array = field(default_factory=lambda: np.zeros(0))
    noise: Array = field(default_factory=lambda: np.zeros((0, 0)))
    single: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def residual(self, x: Array) -> tuple[Array, Array]:
        """Observed less expected combinations (m, k) at (m, p), and their covariance (m, k, k)."""
        assert self.processes is not None
        mean, variance = self.processes.predict(x)
        return self.z - mean, self.noise + variance[:, :, None] * np.eye(len(self.z))

    def chi2(self, x: Array) -> Array:
        """(m,) Of the combinations."""
        off, covariance = self.residual(x)
        return np.einsum("mi,mi->m", off, np.linalg.solve(covariance, off[..., None])[..., 0])

    def log_likelihood(self, x: Array) -> Array:
        """(m,)"""
        total = np.zeros(len(x))
        if self.processes is not None:
            off, covariance = self.residual(x)
            solved = np.linalg.solve(covariance, off[..., None])[..., 0]
            total -= 0.5 * np.einsum("mi,mi->m", off, solved)
            total -= 0.5 * np.linalg.slogdet(covariance)[1]
        if self.chance.classifier is not None:
            chance = self.chance(x)
            total += self.observed.passed * np.log(chance)
            total += self.observed.blocked * np.log1p(-chance)
        return total

    def log_posterior(self, x: Array) -> Array:
        """(m,) Minus infinity outside the priors."""
        prior = np.sum([p.log_density(x[:, k]) for k, p in enumerate(self.priors)], axis=0)
        inside = np.isfinite(prior)
        total = np.full(len(x), -np.inf)
        if inside.any():
            total[inside] = prior[inside] + self.log_likelihood(x[inside])
        return total


@dataclass(frozen=True)
class Posterior:
    """Samples (s, p) of the coordinates, and what they came from."""

    model: Model
    samples: Array
    memory: float  # autocorrelation time in steps
    effective: float  # independent samples that they are worth

    def values(self) -> Array:
        """(s, p) in SI."""
        priors = self.model.priors
        return np.stack([p.value(self.samples[:, k]) for k, p in enumerate(priors)], axis=1)


def infer(priors: Sequence[Prior], observed: Observed, runs: Runs, seed: int) -> Posterior:
    """The posterior after some runs.

    The scatter of a trial is first that of all points, then that of the points where the posterior
    is. Raises NothingPassed where values were observed and no run gave any.
    """
    rough = sample(model_of(priors, observed, runs, seed), seed, most=1)
    low, high = np.quantile(rough.samples, [0.005, 0.995], axis=0)
    near = np.flatnonzero(((runs.points >= low) & (runs.points <= high)).all(axis=1))
    return sample(model_of(priors, observed, runs, seed, near), seed)


def model_of(
    priors: Sequence[Prior], observed: Observed, runs: Runs, seed: int,
    near: np.ndarray | None = None,
) -> Model:  # fmt: skip
    """The likelihood after some runs; the scatter of a trial from the points `near`."""
    chance = chance_of(runs, seed)
    if len(observed.values) == 0:
        return Model(tuple(priors), observed, chance)
    which, values = runs.passed()
    if len(np.unique(which)) == len(which):
        raise NothingPassed
    reduction = reduce(observed, which, values)
    z, weights = reduction.of(values), reduction.weights
    processes = processes_of(runs.points, which, z, scatter(which, z)[0], seed)
    single, freedom = scatter(which, values, near)
    chance_in_means = observed.over_trials(single) * inflation(freedom, z.shape[1])
    noise = np.diag(observed.sigma**2) + chance_in_means
    return Model(
        tuple(priors), observed, chance, reduction, processes, reduction.of(observed.values),
        weights @ noise @ weights.T, single,
    )  # fmt: skip


def sample(model: Model, seed: int, most: int = _MOST) -> Posterior:
    """Samples of a model's posterior; the same for the same seed. Few suffice for its position."""
    import emcee

    random = np.random.RandomState(seed)  # what emcee takes
    start = _start(model, random)
    sampler = emcee.EnsembleSampler(
        *start.shape, model.log_posterior, vectorize=True, moves=emcee.moves.DEMove()
    )
    sampler.random_state = random.get_state()
    state: emcee.State | Array = start
    memory = math.inf
    for _ in range(most):
        state = sampler.run_mcmc(state, _STEPS, skip_initial_state_check=True)
        memory = _memory(sampler)
        if sampler.iteration > _MEMORIES * memory:
            break
    samples = sampler.get_chain(discard=int(min(2 * memory, sampler.iteration / 2)), flat=True)
    return Posterior(model, samples, memory, len(samples) / memory)


def _memory(sampler: "emcee.EnsembleSampler") -> float:
    """Autocorrelation time in steps; infinity while a walker has not moved yet."""
    with np.errstate(invalid="ignore"):  # 0/0 of that walker
        memory = float(np.max(sampler.get_autocorr_time(tol=0, quiet=True)))
    return memory if math.isfinite(memory) else math.inf


def _start(model: Model, random: np.random.RandomState) -> Array:
    """Draws (w, p) of the prior, as often as the posterior has them, a little apart."""
    draws = np.stack([p.quantile(random.uniform(size=_DRAWS)) for p in model.priors], axis=1)
    weight = model.log_likelihood(draws)
    weight = np.exp(weight - weight.max())
    start = draws[random.choice(_DRAWS, _WALKERS, p=weight / weight.sum())]
    start += 1e-3 * random.standard_normal(start.shape)
    return within(model.priors, start)
