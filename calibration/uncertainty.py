"""A measured value and how well it is known: from trials, from groups of trials, through a formula.

sigma is a standard uncertainty of the value (one standard deviation, 68 %); scatter is that of a
single trial. Formulas carry sigma to first order (GUM, JCGM 100:2008, sec. 5.1).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from campaign.statistics import mean_sd
from contact.quantity import InputError


@dataclass(frozen=True)
class Estimate:
    """A value in SI (or a pure number), how well it is known, and from how many trials."""

    value: float
    sigma: float | None  # of the value; None where it is not known
    trials: int
    scatter: float | None = None  # standard deviation of a single trial


@dataclass(frozen=True)
class Pooled:
    """All trials of several groups as one value, and whether the groups differ by more than chance.

    p is that of a one-way analysis of variance: None for one group, or where no group has two.
    """

    all: Estimate
    groups: dict[str, Estimate]
    p: float | None

    @property
    def alike(self) -> bool | None:
        """Whether one value describes all groups (p at least 0.05)."""
        return None if self.p is None else self.p >= 0.05


def of_trials(values: Sequence[float]) -> Estimate:
    """The mean of trials, its standard error, and their scatter.

    Raises InputError where there is no trial, or one is not a finite number.
    """
    if not values:
        raise InputError("no trial: at least one measurement is needed")
    if not all(math.isfinite(value) for value in values):
        raise InputError("a trial is not a finite number")
    found = mean_sd(values)
    assert found.mean is not None
    error = None if found.sd is None else found.sd / math.sqrt(found.n)
    return Estimate(found.mean, error, found.n, found.sd)


def pooled(groups: dict[str, Sequence[float]]) -> Pooled:
    """The mean over all trials of all groups, each trial counting once; see Pooled."""
    from scipy.stats import f_oneway

    each = {name: of_trials(values) for name, values in groups.items()}
    whole = of_trials([value for values in groups.values() for value in values])
    several = len(groups) > 1 and any(len(values) > 1 for values in groups.values())
    if not several or not whole.scatter:
        return Pooled(whole, each, None)
    p = float(f_oneway(*groups.values()).pvalue)
    return Pooled(whole, each, p if math.isfinite(p) else None)


def through(formula: Callable[..., float], *known: Estimate) -> Estimate:
    """A formula of independent estimates, with its sigma to first order.

    Slopes are central differences over one sigma each, so that a formula that bends within the
    uncertainty counts as it is there. sigma is None where that of any argument is not known. The
    trials are the fewest of any argument.
    """
    values = [one.value for one in known]
    trials = min(one.trials for one in known)
    variance = 0.0
    for k, one in enumerate(known):
        if one.sigma is None:
            return Estimate(formula(*values), None, trials)
        high, low = (
            formula(*values[:k], one.value + side * one.sigma, *values[k + 1 :]) for side in (1, -1)
        )
        variance += ((high - low) / 2) ** 2
    return Estimate(formula(*values), math.sqrt(variance), trials)
