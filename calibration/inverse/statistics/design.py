"""Points at which the simulator is run: first all over the prior, then where the posterior is."""

from collections.abc import Callable, Sequence

import numpy as np

from calibration.inverse.statistics.data import Observed, Run, Runs
from calibration.inverse.statistics.posterior import NothingPassed, Posterior, model_of, sample
from calibration.inverse.statistics.prior import Array, Prior, within

ROUNDS = 3  # the first takes half of the points, the others share what is left
_DIGITS = 3  # decimals of a coordinate: fewer than differ from one machine to another
_CANDIDATES = 1000

Evaluate = Callable[[Array], list[Run]]  # coordinates (n, p) -> runs, their points from 0


def first_points(priors: Sequence[Prior], count: int, seed: int) -> Array:
    """A Latin hypercube (count, p) over the priors, of the least discrepancy."""
    from scipy.stats import qmc

    cube = qmc.LatinHypercube(len(priors), rng=seed, optimization="random-cd")
    shares = cube.random(count)
    points = np.stack([p.quantile(shares[:, k]) for k, p in enumerate(priors)], axis=1)
    return _tidy(priors, points)


def added_points(posterior: Posterior, there: Array, count: int) -> Array:
    """Samples of the posterior (count, p) far from each other and from the points there are.

    Each is the sample that is furthest from the nearest point, distances in units of the
    posterior's own width (maximin; Johnson et al., J. Stat. Plan. Infer. 26 (1990) 131).
    """
    samples = posterior.samples
    candidates = samples[:: max(len(samples) // _CANDIDATES, 1)]
    width = np.maximum(samples.std(axis=0), 1e-3)
    near = np.linalg.norm((candidates[:, None] - there[None]) / width, axis=2).min(axis=1)
    chosen = []
    for _ in range(count):
        best = int(near.argmax())
        chosen.append(candidates[best])
        away = np.linalg.norm((candidates - candidates[best]) / width, axis=1)
        near = np.minimum(near, away)
    return _tidy(posterior.model.priors, np.array(chosen))


def _tidy(priors: Sequence[Prior], points: Array) -> Array:
    return within(priors, np.round(points, _DIGITS))


def explore(
    priors: Sequence[Prior], observed: Observed, evaluate: Evaluate, count: int, seed: int
) -> Runs:
    """The runs of `count` points, in rounds; the same for the same seed.

    While no run passes, points go on all over the prior.
    """
    first = count - (ROUNDS - 1) * (count // (2 * (ROUNDS - 1)))
    points = first_points(priors, first, seed)
    runs = Runs(points, evaluate(points))
    for k in range(1, ROUNDS):
        more = count // (2 * (ROUNDS - 1))
        if more == 0:
            break
        try:
            found = sample(model_of(priors, observed, runs, seed), seed, most=1)
            points = added_points(found, runs.points, more)
        except NothingPassed:
            points = first_points(priors, more, seed + k)
        runs.add(points, evaluate(points))
    return runs
