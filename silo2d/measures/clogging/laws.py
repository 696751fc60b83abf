"""Mean avalanche against outlet: the two laws of the literature, by maximum likelihood.

    power law      <s> = A (1 - R/R_c)^-g         Zuriguel et al., Phys. Rev. E 71 (2005) 051303
    exponential    <s> = A exp(C R^n), n = 2      Janda et al., EPL 84 (2008) 44002, in the plane;
                                                  Thomas and Durian, PRL 114 (2015) 178001

R = D/d is the outlet over the particles' diameter; the first law has a critical outlet above which
nothing clogs, the second has none. As R_c grows and g/R_c = b stays, the first becomes A exp(b R),
which has none either: where outlets do not refute that, R_c and g are open above. The likelihood is
that of all avalanches, cut ones as censored: k clogs among S particles at an outlet of mean m give
-k ln m - S/m. Intervals are of 95 %: to where the profile of the likelihood has fallen by 1.92.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.statistics import CONFIDENCE
from silo2d.measures.clogging.sizes import REFUTED

Floats = NDArray[np.float64]
IN_THE_PLANE = 2.0  # n
_RATES, _SLOPES = (-0.5, 5.0), (1e-3, 20.0)  # of C and b = g/R_c that are looked at
_CRITICAL = math.log(1e-2), math.log(1e4)  # logarithm of R_c over the largest outlet that clogged
_BEYOND = math.log(1e-4), math.log(1e4)  # the same over any outlet of which it is above
_LEAST_POWER = math.log(1e-2)  # logarithm of g
_HALVINGS = 45  # of the range of rates
_NEVER = 1e6  # for the infinite logarithm of a mean beyond a critical outlet


@dataclass(frozen=True)
class Outlets:
    """Counts at o outlets: D/d, particles that left, and clogs (o,)."""

    across: Floats
    exposure: Floats
    clogs: Floats

    def profile(self, log_shape: Floats) -> tuple[float, float]:
        """Largest log likelihood of ln <s> = ln A + log_shape (o,), and ln A; infinite: no clog."""
        from scipy.special import logsumexp

        total, known = self.clogs.sum(), np.isfinite(log_shape)
        log_a = float(logsumexp(np.log(self.exposure[known]) - log_shape[known]) - math.log(total))
        clogged = self.clogs > 0
        return float(-total * (log_a + 1) - self.clogs[clogged] @ log_shape[clogged]), log_a

    @property
    def saturated(self) -> float:
        """Log likelihood of a mean of its own at each outlet."""
        k, s = self.clogs[self.clogs > 0], self.exposure[self.clogs > 0]
        return float(-k @ np.log(s / k) - k.sum())


@dataclass(frozen=True)
class Estimate:
    """A parameter with its interval; None where that is open."""

    value: float
    low: float | None
    high: float | None


@dataclass(frozen=True)
class Law:
    """A law fitted to outlets.

    name          "power" or "exponential"
    parameters    A, and C, or critical (R_c) and g
    aic           Akaike's criterion; the law of less is the better one, by 2 hardly, by 10 surely
    p_value       that the outlets scatter more about it, were it true; None without a spare outlet
    """

    name: str
    parameters: dict[str, Estimate]
    aic: float
    p_value: float | None

    @property
    def refuted(self) -> bool:
        """Return whether the outlets refute it."""
        return self.p_value is not None and self.p_value < REFUTED

    def mean(self, across: Floats) -> Floats:
        """Mean avalanche at D/d; infinite from a critical outlet on."""
        value = {name: one.value for name, one in self.parameters.items()}
        if self.name == "exponential":
            return value["A"] * np.exp(value["C"] * across**IN_THE_PLANE)
        return value["A"] * np.exp(value["g"] * _log_gap(across, value["critical"]))

    def outlet(self, mean: float) -> float | None:
        """D/d at which a mean avalanche is as large; None where no outlet's is."""
        value = {name: one.value for name, one in self.parameters.items()}
        more = math.log(mean / value["A"])
        if more <= 0 or value.get("C", 1.0) <= 0:
            return None
        if self.name == "exponential":
            return math.pow(more / value["C"], 1 / IN_THE_PLANE)
        return -value["critical"] * math.expm1(-more / value["g"])


def exponential(seen: Outlets) -> Law | None:
    """The law without a critical outlet; None of fewer than two outlets that clogged."""
    if (seen.clogs > 0).sum() < 2:
        return None
    square = seen.across**IN_THE_PLANE

    def best(rate: float) -> float:
        return seen.profile(rate * square)[0]

    rate = _highest(best, *_RATES)
    c = _interval(best, rate, *_RATES)

    def best_of_a(log_a: float) -> float:
        return best_of_mean("exponential", seen, 0.0, log_a)

    log_a = seen.profile(rate * square)[1]
    a = _interval(best_of_a, log_a, log_a - 20, log_a + 20)
    return _law("exponential", {"A": _exp(a), "C": c}, best(rate), seen)


def outlet_of(mean: float, law: Law, seen: Outlets) -> Estimate | None:
    """D/d at which a law fitted to outlets has a mean avalanche, with its interval."""
    at = law.outlet(mean)
    if at is None:
        return None
    most = 4 * max(at, float(seen.across.max()))
    return _interval(lambda r: best_of_mean(law.name, seen, r, math.log(mean)), at, 1e-3, most)


def best_of_mean(name: str, seen: Outlets, across: float, log_mean: float) -> float:
    """Largest log likelihood of the laws of a name with a mean avalanche at an outlet D/d."""
    forms, (low, high) = _forms(name, seen, across)
    less, more = np.full((len(forms), 1), low), np.full((len(forms), 1), high)

    def left(rate: Floats) -> Floats:
        return seen.exposure * np.exp(-np.clip(log_mean + rate * forms, -500, None))

    for _ in range(_HALVINGS):  # the likelihood is concave in the rate
        rate = (less + more) / 2
        rises = ((left(rate) - seen.clogs) * forms).sum(axis=1, keepdims=True) > 0
        less, more = np.where(rises, rate, less), np.where(rises, more, rate)
    found = -(log_mean + less * forms) @ seen.clogs - left(less).sum(axis=1)
    return float(found.max())


def _forms(name: str, seen: Outlets, across: float) -> tuple[Floats, tuple[float, float]]:
    """Logarithms of means over that at an outlet (m, o), for a rate of 1, and ends of the rate.

    Of the power law for m critical outlets.
    """
    if name == "exponential":
        return (seen.across**IN_THE_PLANE - across**IN_THE_PLANE)[None], _RATES
    largest = max(float(seen.across[seen.clogs > 0].max()), across)
    critical = largest + np.exp(np.linspace(*_BEYOND, 161))[:, None]
    form = critical * (_log_gap(seen.across, critical) - _log_gap(np.array([across]), critical))
    return np.minimum(form, _NEVER), _SLOPES


def power(seen: Outlets) -> Law | None:
    """The law with a critical outlet; None of fewer than three outlets that clogged."""
    if (seen.clogs > 0).sum() < 3:
        return None
    largest = float(seen.across[seen.clogs > 0].max())

    def critical(u: float) -> float:
        return largest + math.exp(u)

    def of(u: float, slope: float) -> float:
        return seen.profile(slope * critical(u) * _log_gap(seen.across, critical(u)))[0]

    def best_slope(u: float) -> float:
        return _highest(lambda slope: of(u, slope), *_SLOPES)

    def best_of_u(u: float) -> float:
        return of(u, best_slope(u))

    def best_of_g(log_g: float) -> float:
        def of_both(u: float) -> float:
            return of(u, math.exp(log_g) / critical(u))

        return of_both(_highest(of_both, *_CRITICAL))

    u = _highest(best_of_u, *_CRITICAL)
    slope, end = best_slope(u), _interval(best_of_u, u, *_CRITICAL)
    log_g = math.log(slope * critical(u))
    log_a = seen.profile(math.exp(log_g) * _log_gap(seen.across, critical(u)))[1]
    ends = [None if one is None else critical(one) for one in (end.low, end.high)]
    parameters = {
        "A": Estimate(math.exp(log_a), None, None),
        "critical": Estimate(critical(u), *ends),
        "g": _exp(_interval(best_of_g, log_g, _LEAST_POWER,
                            math.log(best_slope(_CRITICAL[1]) * critical(_CRITICAL[1])))),
    }  # fmt: skip
    return _law("power", parameters, of(u, slope), seen)


def _log_gap(across: Floats, critical: float | Floats) -> Floats:
    """-ln(1 - R/R_c), infinite from the critical outlet on."""
    below = np.where(across < critical, across, 0.0)
    return np.where(across < critical, -np.log1p(-below / critical), np.inf)


def _law(name: str, parameters: dict[str, Estimate], most: float, seen: Outlets) -> Law:
    from scipy.stats import chi2

    spare = len(seen.clogs) - len(parameters)
    ratio = 2 * max(seen.saturated - most, 0.0)
    return Law(name, parameters, 2 * len(parameters) - 2 * most,
               float(chi2.sf(ratio, spare)) if spare > 0 else None)  # fmt: skip


def _highest(of: Callable[[float], float], low: float, high: float) -> float:
    """Place between two ends where a function is highest: on a grid, then by Brent's method."""
    from scipy.optimize import minimize_scalar

    grid = np.linspace(low, high, 41)
    k = int(np.argmax([of(x) for x in grid]))
    ends = grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)]
    return float(minimize_scalar(lambda x: -of(x), bounds=ends, method="bounded").x)


def _interval(of: Callable[[float], float], at: float, low: float, high: float) -> Estimate:
    """Ends where a log likelihood has fallen by half of chi2's quantile, about a point."""
    from scipy.optimize import brentq
    from scipy.stats import chi2

    fallen = of(at) - float(chi2.ppf(CONFIDENCE, 1)) / 2

    def end(outermost: float) -> float | None:
        if of(outermost) > fallen:
            return None
        return float(brentq(lambda x: of(x) - fallen, at, outermost, xtol=1e-6))

    return Estimate(at, end(low), end(high))


def _exp(one: Estimate) -> Estimate:
    ends = [None if end is None else math.exp(end) for end in (one.low, one.high)]
    return Estimate(math.exp(one.value), *ends)
