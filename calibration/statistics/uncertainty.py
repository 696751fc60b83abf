"""A measured value and how well it is known: from trials, from groups of trials, through a formula.

sigma is such that value +- sigma covers the truth in 68.3 % of all measurements: one standard
deviation where that is known, Student's t times the standard error where a few trials must give it
(GUM, JCGM 100:2008, sec. G.3). scatter is the standard deviation of a single trial. Formulas carry
sigma to first order (sec. 5.1).
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache

from granulab.campaign.output.statistics import mean_sd
from granulab.errors import InputError

_ROUNDING = 1e-12  # share of a mean: like readings that were computed with scatter by no more


@dataclass(frozen=True)
class Estimate:
    """A value in SI (or a pure number), how well it is known, and from how many trials."""

    value: float
    sigma: float | None  # of the value; None where it is not known
    trials: int
    scatter: float | None = None  # standard deviation of a single trial


def as_pair(known: Estimate | None) -> dict[str, float | None] | None:
    """Value and sigma for JSON; None for none."""
    return None if known is None else {"value": known.value, "sigma": known.sigma}


@dataclass(frozen=True)
class Pooled:
    """All trials of several groups as one value, and whether the groups differ by more than chance.

    p is that of a one-way analysis of variance: None for one group, where no group has two, or
    where no trial differs from another; 0 for groups that differ while their trials do not.
    Where the groups differ, each group counts once and sigma is that of the groups' mean: more
    trials with the same few samples do not make the value better known.
    """

    all: Estimate
    groups: dict[str, Estimate]
    p: float | None

    @property
    def alike(self) -> bool | None:
        """True if one value describes all groups (p at least 0.05)."""
        return None if self.p is None else self.p >= 0.05


def of_trials(values: Sequence[float]) -> Estimate:
    """The mean of trials, half its 68.3 % interval (Student's t), and their scatter.

    Trials that do not differ at all give no sigma: their readings were too coarse. Raises
    InputError where there is no trial, or one is not a finite number.
    """
    if not values:
        raise InputError("no trial: at least one measurement is needed")
    if not all(math.isfinite(value) for value in values):
        raise InputError("a trial is not a finite number")
    found = mean_sd(values)
    assert found.mean is not None
    if found.sd is None:
        return Estimate(found.mean, None, 1)
    scatter = _beyond_rounding(found.sd, found.mean)
    return Estimate(found.mean, _of_mean(scatter, found.n), found.n, scatter)


def _beyond_rounding(scatter: float, mean: float) -> float:
    """The scatter; 0 where it is one of rounding."""
    return scatter if scatter > _ROUNDING * abs(mean) else 0.0


def _of_mean(scatter: float, n: int) -> float | None:
    """Half the 68.3 % interval of the mean of n trials; None where they do not differ."""
    return student(n - 1) * scatter / math.sqrt(n) or None


@cache
def student(freedom: int) -> float:
    """Half the 68.3 % interval of a mean, in standard errors; 1.84 for one degree of freedom."""
    from scipy.stats import norm, t

    return float(t.ppf(norm.cdf(1), freedom))


def pooled(groups: Mapping[str, Sequence[float]]) -> Pooled:
    """The mean over the trials of all groups; see Pooled for what counts once."""
    return pooled_summaries({name: of_trials(values) for name, values in groups.items()})


def pooled_summaries(groups: Mapping[str, Estimate]) -> Pooled:
    """The same from each group's mean, scatter and trials, which are all that it depends on.

    One-way analysis of variance: the sum of squares about the mean of all is that within the
    groups and that between them. A group without a scatter has one trial.
    """
    from scipy.stats import f

    ones = list(groups.values())
    n, k = sum(one.trials for one in ones), len(ones)
    mean = math.fsum(one.trials * one.value for one in ones) / n
    within = math.fsum((one.trials - 1) * (one.scatter or 0.0) ** 2 for one in ones)
    between = math.fsum(one.trials * (one.value - mean) ** 2 for one in ones)
    if n == 1:
        return Pooled(ones[0], dict(groups), None)
    scatter = _beyond_rounding(math.sqrt((within + between) / (n - 1)), mean)
    whole = Estimate(mean, _of_mean(scatter, n), n, scatter)
    if k == 1 or n == k or scatter == 0:
        return Pooled(whole, dict(groups), None)
    ratio = between / (k - 1) / (within / (n - k)) if within else math.inf
    p = float(f.sf(ratio, k - 1, n - k))
    found = Pooled(whole, dict(groups), p)
    if found.alike:
        return found
    each_once = of_trials([one.value for one in ones])
    counted = replace(whole, value=each_once.value, sigma=each_once.sigma)
    return Pooled(counted, dict(groups), p)


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
