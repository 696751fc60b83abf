"""Sizes of avalanches: mean with censoring, test of the exponential tail, independence.

A size is the number s >= 1 of particles that leave between two clogs. Where each particle clogs the
outlet with the same probability p, whatever left before, P(s) = p (1 - p)^(s-1): geometric, an
exponential for large sizes (Zuriguel et al., Phys. Rev. E 71 (2005) 051303). An avalanche that was
cut off is larger than its size (censored). All intervals are of 95 %.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.statistics import CONFIDENCE, Correlation, rank_correlation

Sizes = NDArray[np.float64]
_FEWEST = 20  # clogs, for a test of the form
_FORMS = math.log(0.2), math.log(5.0)  # of beta, that are looked at
REFUTED = 0.05  # p below which a law, or one mean avalanche of all runs, is refuted


class Run(NamedTuple):
    """Avalanches of a run, the first from the opening; cut: 1 for those that no clog ended."""

    first: int
    first_clogged: bool
    sizes: list[int]
    cut: list[int]


def joined(first: int, first_clogged: bool, sizes: Sequence[int], cut: Sequence[int]) -> Run:
    """Avalanches of the pieces of a run: one that is cut off goes on in the next piece.

    The first that goes on is that from the opening; the last of a run may end without a clog.
    """
    found, clogged = [first], [first_clogged]
    for size, is_cut in zip(sizes, cut, strict=True):
        if clogged[-1]:
            found.append(size)
            clogged.append(not is_cut)
        else:
            found[-1] += size
            clogged[-1] = not is_cut
    return Run(found[0], clogged[0], found[1:], [int(not one) for one in clogged[1:]])


@dataclass(frozen=True)
class Mean:
    """Mean avalanche <s> = 1/p: particles that left over clogs; None where nothing clogged."""

    value: float | None
    low: float
    high: float | None
    clogs: float  # what they count, where runs scatter
    exposure: float  # particles that left, likewise


def mean_avalanche(exposure: int, clogs: int, scatter: float = 1.0) -> Mean:
    """The mean avalanche of clogs among particles that left, those of cut avalanches among them.

    The likelihood p^k (1 - p)^(S - k) has its maximum at p = k/S. The interval is that of a number
    k of rare events in S trials (Garwood 1936), with at least its confidence.

    scatter: variance over that of one p (see scatter); the counts weigh less by so much
    """
    from scipy.stats import chi2

    k, left = clogs / scatter, exposure / scatter
    outside = (1 - CONFIDENCE) / 2
    most = chi2.ppf(1 - outside, 2 * k + 2) / 2  # clogs that may be expected, at most
    least = chi2.ppf(outside, 2 * k) / 2 if clogs else 0.0
    return Mean(
        exposure / clogs if clogs else None,
        float(left / most), float(left / least) if clogs else None, k, left,
    )  # fmt: skip


def scatter(runs: Sequence[Run]) -> tuple[float, float | None]:
    """Variance of the runs' clogs over that of one p, at least 1, and p that they share one.

    By the likelihood ratio of a p for each run against one for all (Wilks 1938), over its degrees
    of freedom (McCullagh and Nelder, Generalized Linear Models, 1989, 4.5); 1 where a common p is
    not refuted. None of fewer than two runs in which something left, or where nothing clogged.
    """
    from scipy.special import xlogy
    from scipy.stats import chi2

    left = np.array([sum(run.sizes) for run in runs], float)
    clogs = np.array([len(run.cut) - sum(run.cut) for run in runs], float)
    left, clogs = left[left > 0], clogs[left > 0]
    if len(left) < 2 or not clogs.any():
        return 1.0, None

    def log_likelihood(p: NDArray[np.float64]) -> float:
        return float((xlogy(clogs, p) + xlogy(left - clogs, 1 - p)).sum())

    common = np.full(len(left), clogs.sum() / left.sum())
    ratio = 2 * max(log_likelihood(clogs / left) - log_likelihood(common), 0.0)
    p_value = float(chi2.sf(ratio, len(left) - 1))
    return (max(ratio / (len(left) - 1), 1.0) if p_value < REFUTED else 1.0), p_value


@dataclass(frozen=True)
class Form:
    """Form of sizes beyond a start: P(more than start + e) = exp(-lambda e^beta).

    Exponential with beta 1, stretched below, compressed above.

    beta       with low and high
    p_value    of the likelihood ratio of beta = 1; small: not exponential
    start      size beyond which it is judged; n: clogs beyond it
    """

    beta: float
    low: float
    high: float
    p_value: float
    start: int
    n: int


def form(sizes: Sequence[int], cut: Sequence[int], start: int = 0) -> Form | None:
    """Exponential against stretched or compressed: the discrete Weibull law; None of too few.

    Nakagawa and Osaki, IEEE Trans. Reliab. 24 (1975) 300; of beta = 1 it is the geometric law, by
    the likelihood ratio with one degree of freedom (Wilks 1938). Cut sizes are censored.
    """
    from scipy.optimize import brentq, minimize_scalar
    from scipy.stats import chi2

    size, censored = np.asarray(sizes, float) - start, np.asarray(cut, bool)
    beyond = size >= 1
    size, censored = size[beyond], censored[beyond]
    n = int((~censored).sum())
    if n < _FEWEST:
        return None
    scale = size.sum() / n

    def best(log_beta: float) -> float:
        """The largest log likelihood of a form, over lambda."""
        beta = math.exp(log_beta)
        ends, before = (size / scale) ** beta, (np.maximum(size - 1, 0) / scale) ** beta
        survived = ends[censored].sum() + before[~censored].sum()
        step = (ends - before)[~censored]

        def negative(log_rate: float) -> float:
            rate = math.exp(log_rate)
            return float(rate * survived - np.log(-np.expm1(-rate * step)).sum())

        return -float(minimize_scalar(negative, bounds=(-6.0, 6.0), method="bounded").fun)

    found = minimize_scalar(lambda b: -best(b), bounds=_FORMS, method="bounded")
    most, at = -float(found.fun), float(found.x)
    drop = float(chi2.ppf(CONFIDENCE, 1)) / 2

    def end(outermost: float) -> float:
        if best(outermost) > most - drop:
            return math.exp(outermost)
        return math.exp(brentq(lambda b: best(b) - most + drop, at, outermost, xtol=1e-4))

    ratio = 2 * max(most - best(0.0), 0.0)
    return Form(math.exp(at), end(_FORMS[0]), end(_FORMS[1]), float(chi2.sf(ratio, 1)), start, n)


def mode(sizes: Sequence[int], cut: Sequence[int]) -> int:
    """Size beyond which the tail is judged: the end of the fullest bin of the sizes that clogged.

    Bins of the width of Freedman and Diaconis (1981), from 0. Zuriguel 2005: below the mode fewer
    avalanches end, since the bed still moves from the breaking of the arch.
    """
    own = np.asarray(sizes)[~np.asarray(cut, bool)]
    if len(own) < 2:
        return 0
    spread = float(np.subtract(*np.percentile(own, [75, 25])))
    width = max(math.ceil(2 * spread / len(own) ** (1 / 3)), 1)
    number = np.bincount((own - 1) // width)
    return int(number.argmax() + 1) * width


def independence(runs: Sequence[tuple[Sequence[float], Sequence[int]]]) -> Correlation | None:
    """Rank correlation of each size with the next one of its run, with its interval.

    runs: sizes and cut of each. Pairs with a cut avalanche are left out.
    """
    pairs = [
        (first, second)
        for sizes, cut in runs
        for first, second, *ends in zip(sizes[:-1], sizes[1:], cut[:-1], cut[1:], strict=True)
        if not any(ends)
    ]
    return rank_correlation(*zip(*pairs, strict=True)) if len(pairs) > 3 else None


def survival(sizes: Sequence[int], cut: Sequence[int]) -> tuple[Sizes, Sizes]:
    """Sizes at which avalanches clogged and the share that is larger (Kaplan and Meier 1958)."""
    size, ended = np.asarray(sizes, float), ~np.asarray(cut, bool)
    at = np.unique(size[ended])
    clogs = np.array([(ended & (size == s)).sum() for s in at])
    risk = np.array([(size >= s).sum() for s in at])
    return at, np.cumprod(1 - clogs / risk)


def empties(mean: Mean, n: int) -> tuple[float, float, float]:
    """Probability that n particles leave without a clog, (1 - 1/<s>)^n, and its interval."""

    def chance(value: float | None) -> float:
        return 1.0 if value is None else max(1.0 - 1.0 / max(value, 1.0), 0.0) ** n

    return chance(mean.value), chance(mean.low), chance(mean.high)
