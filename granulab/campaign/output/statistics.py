"""Means, spreads and shares of a few runs, and when two of them differ by more than noise.

All intervals are of 95 % confidence unless another is given. Times are taken as normally
distributed about their mean, trials that clog as independent draws.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

CONFIDENCE = 0.95
_COMPUTED = 1e-12  # of a number: what sums leave of values that are alike


@dataclass(frozen=True)
class Sample:
    """Number of values, their mean, and their sample standard deviation."""

    n: int
    mean: float | None  # None where there is no value
    sd: float | None  # of n - 1; None where there are fewer than two


def mean_sd(values: Sequence[float]) -> Sample:
    """Mean and sample standard deviation of values."""
    n = len(values)
    if n == 0:
        return Sample(0, None, None)
    mean = math.fsum(values) / n
    if n == 1:
        return Sample(1, mean, None)
    return Sample(n, mean, math.sqrt(math.fsum((v - mean) ** 2 for v in values) / (n - 1)))


@lru_cache(maxsize=4096)  # scipy tests a hypothesis for it, and a table has the same few shares
def wilson(k: int, n: int, confidence: float = CONFIDENCE) -> tuple[float, float]:
    """Wilson's score interval of a share of which k of n trials were seen; (0, 1) for no trial."""
    from scipy.stats import binomtest

    if n == 0:
        return 0.0, 1.0
    low, high = binomtest(k, n).proportion_ci(confidence, method="wilson")
    return float(low), float(high)


def difference_of_shares(k: int, n: int, other_k: int, other_n: int) -> tuple[float, float]:
    """Interval of k/n - other_k/other_n, from Wilson's of each; of n > 0 trials.

    Newcombe, Statist. Med. 17 (1998) 873, method 10.
    """
    p, q = k / n, other_k / other_n
    (low, high), (other_low, other_high) = wilson(k, n), wilson(other_k, other_n)
    return (
        p - q - math.hypot(p - low, other_high - q),
        p - q + math.hypot(high - p, q - other_low),
    )


@dataclass(frozen=True)
class Counts:
    """k of n trials, compared with other_k of other_n; numbers of trials > 0."""

    k: int
    n: int
    other_k: int
    other_n: int


def chance_of_shares(strata: Sequence[Counts]) -> float:
    """Two-sided chance, of equal shares in each stratum, of a total of k as unlikely as this.

    Exact, given the sums of each stratum: of one stratum Fisher's test, of several its stratified
    form (Gart, Biometrika 57 (1970) 471).
    """
    import numpy as np
    from scipy.stats import hypergeom

    total = np.ones(1)
    for one in strata:
        law = hypergeom(one.n + one.other_n, one.k + one.other_k, one.n)
        total = np.convolve(total, law.pmf(np.arange(one.n + 1)))
    seen = total[sum(one.k for one in strata)]
    return float(total[total <= seen * (1.0 + 1e-7)].sum())  # equally likely ones are in, rounded


def chance_of_few(strata: Sequence[Counts]) -> float:
    """Chance that trials repeated until n - k of each stratum fail give at most the total k.

    The shares are those of the other trials, with Jeffreys' prior: k is beta negative binomial. A
    stratum that has none to fail ends before its first trial: none of its trials holds.
    """
    import numpy as np
    from scipy.stats import betanbinom

    most, total = sum(one.k for one in strata), np.ones(1)
    for one in [one for one in strata if one.k < one.n]:
        prior = one.other_n - one.other_k + 0.5, one.other_k + 0.5
        law = betanbinom(one.n - one.k, *prior).pmf(np.arange(most + 1))
        total = np.convolve(total, law)[: most + 1]
    return float(total.sum())


@lru_cache(maxsize=1024)
def quantile(freedom: float, confidence: float = CONFIDENCE) -> float:
    """Student's t that |t| stays below with the confidence, for degrees of freedom > 0."""
    from scipy.stats import t

    return float(t.ppf(0.5 + confidence / 2, freedom))


def among(comparisons: int) -> float:
    """The confidence of each of several intervals that hold all together with CONFIDENCE.

    Bonferroni's: Dunn, J. Am. Stat. Assoc. 56 (1961) 52.
    """
    return 1 - (1 - CONFIDENCE) / comparisons


def half_width_of_mean(sample: Sample) -> float | None:
    """Half width of Student's interval of a mean, t sd/sqrt(n); None for fewer than two values."""
    if sample.sd is None:
        return None
    return quantile(sample.n - 1) * sample.sd / math.sqrt(sample.n)


def noise_of_difference(first: Sample, second: Sample) -> float | None:
    """Half width of the confidence interval of the difference of two means; Welch (1947).

    t sqrt(s1^2/n1 + s2^2/n2), with the degrees of freedom of Welch and Satterthwaite. None where
    either has no standard deviation.
    """
    if first.sd is None or second.sd is None:
        return None
    errors = [first.sd**2 / first.n, second.sd**2 / second.n]
    return welch_half_width(errors, [first.n - 1, second.n - 1])


def welch_half_width(
    variances: Sequence[float], freedoms: Sequence[float], confidence: float = CONFIDENCE
) -> float:
    """t times the root of a sum of squared standard errors, each with its degrees of freedom."""
    total = sum(variances)
    if total == 0:
        return 0.0
    spread = sum(v**2 / f for v, f in zip(variances, freedoms, strict=True))
    return quantile(total**2 / spread, confidence) * math.sqrt(total)


def pooled_sd(samples: Sequence[Sample]) -> tuple[float, int] | None:
    """The standard deviation that samples of unlike means share, and its degrees of freedom."""
    known = [(s.sd, s.n - 1) for s in samples if s.sd is not None]
    freedom = sum(f for _, f in known)
    if not freedom:
        return None
    return math.sqrt(sum(f * sd**2 for sd, f in known) / freedom), freedom


def noise_of_one_more(n: int, sd: float, freedom: float) -> float:
    """Return how far one more value may lie from the mean of n: t sd sqrt(1 + 1/n)."""
    return quantile(freedom) * sd * math.sqrt(1 + 1 / n)


@dataclass(frozen=True)
class Slope:
    """A straight line's slope from n points, and its standard error."""

    value: float
    error: float
    freedom: int  # n - 2

    @property
    def half_width(self) -> float:
        """Of its confidence interval."""
        return self.half_width_among(1)

    def half_width_among(self, slopes: int) -> float:
        """Of its interval where all of so many slopes are to lie in theirs (Bonferroni)."""
        return quantile(self.freedom, among(slopes)) * self.error


def slope(x: Sequence[float], y: Sequence[float], rounding: float = 0.0) -> Slope | None:
    """The least-squares slope of y(x); None for fewer than three points or one x.

    `rounding` is the unit to which y is printed: its standard deviation, rounding/sqrt(12), is
    the least scatter about the line that is believed, and none is below that of rounded sums.
    """
    from scipy.stats import linregress

    n = len(x)
    if n < 3 or len(set(x)) < 2:
        return None
    fit = linregress(x, y)
    mean = math.fsum(x) / n
    width = math.sqrt(math.fsum((a - mean) ** 2 for a in x))
    least = max(rounding, _COMPUTED * max(map(abs, y))) / math.sqrt(12) / width
    error = float(fit.stderr) if len(set(y)) > 1 else 0.0  # NaN of scipy where no y differs
    return Slope(float(fit.slope), max(error, least), n - 2)


@dataclass(frozen=True)
class Correlation:
    """Spearman's rank correlation and its interval."""

    value: float
    low: float
    high: float


def rank_correlation(x: Sequence[float], y: Sequence[float]) -> Correlation | None:
    """Spearman's rank correlation; None of fewer than four pairs, or where either has one value.

    Its interval is Fisher's z with the variance (1 + r^2/2)/(n - 3): Bonett and Wright,
    Psychometrika 65 (2000) 23. Of pairs all in order, where z is infinite, it is that of r pulled
    in by 1/n, up to r: four pairs are in order once in twelve by chance.
    """
    from scipy.stats import norm, spearmanr

    if len(x) < 4 or len(set(x)) < 2 or len(set(y)) < 2:
        return None
    value = float(spearmanr(x, y).statistic)
    inner = value
    if abs(value) >= 1.0 - 1e-12:
        value = float(round(value))
        inner = value * (1 - 1 / len(x))
    half = float(norm.ppf(0.5 + CONFIDENCE / 2)) * math.sqrt((1 + inner**2 / 2) / (len(x) - 3))
    low, high = (math.tanh(math.atanh(inner) + sign * half) for sign in (-1, 1))
    return Correlation(value, min(low, value), max(high, value))
