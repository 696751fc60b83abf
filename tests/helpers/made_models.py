"""A noisy model with a closed form, in the place of a simulator, for the statistics of a fit."""

from dataclasses import dataclass

import numpy as np

from calibration.inverse.statistics.data import Observed, Run
from calibration.inverse.statistics.design import explore
from calibration.inverse.statistics.posterior import Posterior, infer
from calibration.inverse.statistics.prior import Prior, prior_of

TIMES = np.linspace(0.3, 1.5, 5)


def prior(name: str, kind: str, first: float, second: float, **ends: float) -> Prior:
    """A uniform prior from min to max, or a normal one of mean and sd, with its ends."""
    keys = {"uniform": ("min", "max"), "normal": ("mean", "sd")}[kind]
    written = {"distribution": kind, keys[0]: first, keys[1]: second} | ends
    return prior_of((f"law.{name}",), written, lambda key, value: float(value))


FRICTION = prior("mu", "uniform", 0.1, 0.8)
DAMPING = prior("gamma", "normal", 1.0, 0.2)


def discharge(mu: float, gamma: float) -> np.ndarray:
    """A time and a curve: the rate falls with both parameters, the curve bends with gamma."""
    rate = 1.0 / (0.6 + 1.2 * mu + 0.3 * gamma)
    return np.array([1.0 / rate, *(-np.expm1(-rate * TIMES**gamma))])


@dataclass(frozen=True)
class Model:
    """Trials of the discharge: chance in the trial, the same for all of its values, and noise.

    clogs    trials with more friction than this clog half of the time
    """

    priors: tuple[Prior, ...] = (FRICTION, DAMPING)
    chance: float = 0.03
    noise: float = 0.005
    clogs: float = np.inf

    def trial(self, random: np.random.Generator, values: np.ndarray) -> np.ndarray | None:
        """One trial at parameters in SI; None where it clogs."""
        if values[0] > self.clogs and random.uniform() < 0.5:
            return None
        off = self.chance * random.standard_normal()
        clean = discharge(values[0] + off, values[1] if len(values) > 1 else 1.0)
        return clean + self.noise * random.standard_normal(len(clean))

    def drawn(self, random: np.random.Generator) -> np.ndarray:
        """Parameters from their priors, in SI."""
        return np.array([p.value(p.quantile(random.uniform(size=1)))[0] for p in self.priors])

    def measured(
        self, random: np.random.Generator, truth: np.ndarray, trials: int = 3, sigma: float = 0.01
    ) -> Observed:
        """The mean of some trials, measured with noise, and how many clogged on the way."""
        passed, blocked = [], 0
        while len(passed) < trials:
            one = self.trial(random, truth)
            blocked += one is None
            passed += [one] if one is not None else []
        values = np.mean(passed, axis=0)
        values = values + sigma * random.standard_normal(len(values))
        return Observed(
            values, np.full(len(values), sigma), np.full(len(values), trials), trials, blocked
        )

    def fit(
        self, random: np.random.Generator, observed: Observed, points: int, seeds: int = 3
    ) -> Posterior:
        """The posterior after so many points."""

        def evaluate(x: np.ndarray) -> list[Run]:
            found = []
            for k, row in enumerate(x):
                values = np.array([p.value(c) for p, c in zip(self.priors, row, strict=True)])
                for _ in range(seeds):
                    one = self.trial(random, values)
                    found.append(Run(k, "blocked" if one is None else "passed", one))
            return found

        runs = explore(self.priors, observed, evaluate, points, 1)
        return infer(self.priors, observed, runs, 1)


def level(posterior: Posterior, truth: np.ndarray) -> np.ndarray:
    """How much of each parameter's posterior lies below the truth (p,); never 0 or 1."""
    below = (posterior.values() < truth).sum(axis=0)
    return (below + 0.5) / (len(posterior.samples) + 1)
