"""Mean avalanche against outlet: the two laws of the literature, by maximum likelihood.

    power law      <s> = A (R_c - R)^-g           Zuriguel et al., Phys. Rev. E 71 (2005) 051303
    exponential    <s> = A exp(C R^n), n = 2      Janda et al., EPL 84 (2008) 44002, in the plane;
                                                  Thomas and Durian, PRL 114 (2015) 178001

R = D/d is the outlet over the particles' diameter; the first law has a critical outlet above which
nothing clogs, the second has none. The likelihood is that of all avalanches, cut ones as censored:
k clogs among S particles at an outlet of mean m give -k ln m - S/m. Intervals are of 95 %: to where
the profile of the likelihood has fallen by 1.92.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.statistics import CONFIDENCE

Floats = NDArray[np.float64]
IN_THE_PLANE = 2.0  # n
_RATES, _POWERS = (-0.5, 5.0), (1e-2, 80.0)  # of C and g that are looked at
_CRITICAL = math.log(1e-2), math.log(1e2)  # logarithm of R_c over the largest outlet that clogged


@dataclass(frozen=True)
class Outlets:
    """Counts at o outlets: D/d, particles that left, and clogs (o,)."""

    across: Floats
    exposure: Floats
    clogs: Floats

    def profile(self, shape: Floats) -> tuple[float, float]:
        """Largest log likelihood of <s> = A shape (o,), and ln A; an infinite shape: no clog."""
        total = self.clogs.sum()
        known = np.isfinite(shape)
        log_a = math.log((self.exposure[known] / shape[known]).sum() / total)
        clogged = self.clogs > 0
        return float(-total * (log_a + 1) - self.clogs[clogged] @ np.log(shape[clogged])), log_a

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

    def mean(self, across: Floats) -> Floats:
        """Mean avalanche at D/d; infinite from a critical outlet on."""
        value = {name: one.value for name, one in self.parameters.items()}
        if self.name == "exponential":
            return value["A"] * np.exp(value["C"] * across**IN_THE_PLANE)
        return value["A"] * _shape(across, value["critical"], value["g"])


def exponential(seen: Outlets) -> Law | None:
    """The law without a critical outlet; None of fewer than two outlets that clogged."""
    if (seen.clogs > 0).sum() < 2:
        return None
    square = seen.across**IN_THE_PLANE

    def best(rate: float) -> float:
        return seen.profile(np.exp(rate * square))[0]

    rate = _highest(best, *_RATES)
    c = _interval(best, rate, *_RATES)

    def best_of_a(log_a: float) -> float:
        return best_of_mean(seen, 0.0, log_a)

    log_a = seen.profile(np.exp(rate * square))[1]
    a = _interval(best_of_a, log_a, log_a - 20, log_a + 20)
    return _law("exponential", {"A": _exp(a), "C": c}, best(rate), seen)


def outlet_of(mean: float, seen: Outlets) -> Estimate | None:
    """D/d at which the exponential law has a mean avalanche, with its interval."""
    law = exponential(seen)
    if law is None or law.parameters["C"].value <= 0:
        return None
    log_a, rate = math.log(law.parameters["A"].value), law.parameters["C"].value
    square = (math.log(mean) - log_a) / rate
    if square <= 0:
        return None
    at, most = math.sqrt(square), 4 * max(math.sqrt(square), float(seen.across.max()))
    return _interval(lambda r: best_of_mean(seen, r, math.log(mean)), at, 1e-3, most)


def best_of_mean(seen: Outlets, across: float, log_mean: float) -> float:
    """Largest log likelihood of the exponential laws with a mean avalanche at an outlet D/d."""
    square = seen.across**IN_THE_PLANE - across**IN_THE_PLANE

    def of(rate: float) -> float:
        log_m = log_mean + rate * square
        return float(-seen.clogs @ log_m - seen.exposure @ np.exp(-np.clip(log_m, -500, None)))

    return of(_highest(of, *_RATES))


def power(seen: Outlets) -> Law | None:
    """The law with a critical outlet; None of fewer than three outlets that clogged."""
    if (seen.clogs > 0).sum() < 3:
        return None
    largest = float(seen.across[seen.clogs > 0].max())

    def of(u: float, g: float) -> float:
        return seen.profile(_shape(seen.across, largest + math.exp(u), g))[0]

    def best_power(u: float) -> float:
        return _highest(lambda g: of(u, g), *_POWERS)

    def best_of_u(u: float) -> float:
        return of(u, best_power(u))

    def best_of_g(g: float) -> float:
        return of(_highest(lambda u: of(u, g), *_CRITICAL), g)

    u = _highest(best_of_u, *_CRITICAL)
    g, end = best_power(u), _interval(best_of_u, u, *_CRITICAL)
    log_a = seen.profile(_shape(seen.across, largest + math.exp(u), g))[1]
    ends = [None if one is None else largest + math.exp(one) for one in (end.low, end.high)]
    parameters = {
        "A": Estimate(math.exp(log_a), None, None),
        "critical": Estimate(largest + math.exp(u), *ends),
        "g": _interval(best_of_g, g, *_POWERS),
    }
    return _law("power", parameters, of(u, g), seen)


def _shape(across: Floats, critical: float, g: float) -> Floats:
    """(R_c - R)^-g, infinite from the critical outlet on."""
    gap = np.where(across < critical, critical - across, 1.0)
    return np.where(across < critical, gap**-g, np.inf)


def _law(name: str, parameters: dict[str, Estimate], most: float, seen: Outlets) -> Law:
    from scipy.stats import chi2

    spare = int((seen.clogs > 0).sum()) - len(parameters)
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
