"""Data of a fit: an observation as numbers with their noise, and the runs compared with it."""

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from calibration.inverse.statistics.prior import Array

Ended = Literal["passed", "blocked", "failed"]


@dataclass(frozen=True)
class Observed:
    """Measured values and how well they are known; d of them.

    values    (d,) SI
    sigma     (d,) standard uncertainty of measuring, above 0
    trials    (d,) how many trials (discharges, fillings) each is the mean of
    passed    trials that ended with such values, blocked: those that did not (clogged silos)
    """

    values: Array
    sigma: Array
    trials: Array
    passed: int = 0
    blocked: int = 0

    def over_trials(self, scatter: Array) -> Array:
        """Covariance (d, d) of the means over the trials, where that of single ones is known.

        Values that are means of as many trials come from the same ones; those of fewer are taken
        for some of those of more.
        """
        return scatter / np.maximum.outer(self.trials, self.trials)


@dataclass(frozen=True)
class Run:
    """One simulated trial at a point of the parameters."""

    point: int  # its number
    ended: Ended
    values: Array | None = None  # (d,) as observed; of those that passed
    reason: str = ""  # why not


@dataclass
class Runs:
    """The points where the simulator was run, and all runs.

    points    (n, p) coordinates, see calibration.inverse.statistics.prior
    """

    points: Array
    runs: list[Run] = field(default_factory=list)

    def add(self, points: Array, runs: list[Run]) -> None:
        """More points, whose runs count them from the first of them."""
        before = len(self.points)
        self.points = np.concatenate([self.points, points])
        self.runs += [Run(before + r.point, r.ended, r.values, r.reason) for r in runs]

    def passed(self) -> tuple[np.ndarray, Array]:
        """Points (r,) and values (r, d) of the runs that passed."""
        kept = [(run.point, run.values) for run in self.runs if run.values is not None]
        return np.array([k for k, _ in kept], dtype=int), np.array([values for _, values in kept])

    def outcomes(self) -> tuple[np.ndarray, np.ndarray]:
        """Points (r,) of all runs that did not fail, and whether each passed (r,)."""
        known = [(run.point, run.ended == "passed") for run in self.runs if run.ended != "failed"]
        return np.array([k for k, _ in known], dtype=int), np.array([p for _, p in known], bool)
