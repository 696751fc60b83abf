"""Times between successive particles that leave, by logarithmic bins, and the tail of them.

The pauses of the flow ("brief interruptions") are its long end. Bins are kept in place of times: a
tail that is a power law, p(t) ~ t^-alpha, has numbers in them that fall geometrically, by
q = r^(1-alpha) from bin to bin, r the ratio of their edges (Virkar and Clauset, Ann. Appl. Stat. 8
(2014) 89), so that alpha and its error follow from the bins as from the times.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granulab.campaign.output.statistics import CONFIDENCE

_A_DECADE, _SHORTEST, _DECADES = 20, 1e-4, 5  # bins of a factor of ten; [s]
BINS = _A_DECADE * _DECADES
EDGES = _SHORTEST * 10.0 ** (np.arange(BINS + 1) / _A_DECADE)  # (BINS + 1,) [s]
_RATIO = math.log(10) / _A_DECADE  # logarithm of it
_FEWEST, _FEWEST_BINS = 50, 5  # waits and bins in a tail
_DRAWS, _SEED = 199, 7  # samples of a fitted tail that its distance is compared with


def bin_of(times: ArrayLike) -> NDArray[np.int64]:
    """Bin of each time [s]; shorter ones are in the first, longer ones in the last."""
    return np.clip(np.searchsorted(EDGES, np.asarray(times), side="right") - 1, 0, BINS - 1)


@dataclass(frozen=True)
class Tail:
    """Power-law tail of times, between a shortest and a longest one.

    alpha      exponent of the density, with low and high: interval of 95 %
    start      shortest time of it [s], end: the longest [s]
    n          times in it
    distance   of Kolmogorov and Smirnov, at the edges of bins
    """

    alpha: float
    low: float
    high: float
    start: float
    end: float
    n: int
    distance: float


def tail(counts: Sequence[int], longest: float, start: float = 0.0) -> Tail | None:
    """The power-law tail of times by bins (BINS,), by maximum likelihood; None where too few.

    longest   time [s] above which a pause counts as a clog, so that longer ones lack; the tail ends
              at the edge below
    start     time [s] before which it does not start

    It starts at the first bin from the fullest on from which a power law is not refuted: Kolmogorov
    and Smirnov's distance is below the one that a sample of twenty exceeds, of samples drawn from
    the fitted tail and fitted again. The least distance itself (Clauset, Shalizi, Newman, SIAM Rev.
    51 (2009) 661) favours short tails of a few bins. None too where no start with 50 times in 5
    bins does. The interval is that of the start: fewer times refute less, and start earlier.
    """
    end = int(np.searchsorted(EDGES, longest * (1 + 1e-9), side="right")) - 1
    number = np.asarray(counts[: max(end, 1)])
    earliest = max(int(number.argmax()), int(np.searchsorted(EDGES, start * (1 - 1e-9))))
    for first in range(earliest, end - _FEWEST_BINS + 1):
        fitted = _fit(number[first:], first, end)
        if fitted is not None and not _refuted(*fitted):
            return fitted[0]
    return None


def _refuted(found: Tail, expected: NDArray[np.float64]) -> bool:
    """True if a tail is farther from its fit than one sample of twenty is.

    expected: (b,) shares of its bins
    """
    bins = np.arange(len(expected))
    drawn = np.random.default_rng(_SEED).multinomial(found.n, expected, _DRAWS) / found.n
    # Fits of the samples: by the mean bin, within ten standard deviations of what it is.
    spread = 10 / math.sqrt(found.n * float(expected @ bins**2 - (expected @ bins) ** 2))
    shift = np.linspace(-spread, spread, 201)
    weight = expected * np.exp(np.outer(shift, bins - bins.mean()))
    weight /= weight.sum(axis=1, keepdims=True)
    own = np.interp(drawn @ bins, weight @ bins, shift)
    again = expected * np.exp(np.outer(own, bins - bins.mean()))
    again /= again.sum(axis=1, keepdims=True)
    distances = np.abs(np.cumsum(again - drawn, axis=1)).max(axis=1)
    return found.distance > float(np.quantile(distances, CONFIDENCE))


def _fit(
    number: NDArray[np.int64], first: int, end: int
) -> tuple[Tail, NDArray[np.float64]] | None:
    """Tail of the bins from one on, and its shares; None where they hold too few, or no tail."""
    from scipy.optimize import brentq
    from scipy.stats import norm

    n, bins = int(number.sum()), np.arange(len(number))
    if n < _FEWEST:
        return None
    mean = float(number @ bins) / n

    def parts(log_q: float) -> NDArray[np.float64]:
        weight = np.exp(log_q * bins - max(log_q * bins[-1], 0.0))
        return weight / weight.sum()

    def excess(log_q: float) -> float:
        return float(parts(log_q) @ bins) - mean

    if excess(-20.0) >= 0 or excess(20.0) <= 0:
        return None
    log_q = float(brentq(excess, -20.0, 20.0))
    expected = parts(log_q)
    variance = float(expected @ bins**2 - (expected @ bins) ** 2)
    error = float(norm.ppf(0.5 + CONFIDENCE / 2)) / (math.sqrt(n * variance) * _RATIO)
    alpha = 1.0 - log_q / _RATIO
    distance = float(np.abs(np.cumsum(expected) - np.cumsum(number) / n).max())
    found = Tail(alpha, alpha - error, alpha + error, float(EDGES[first]), float(EDGES[end]), n,
                 distance)  # fmt: skip
    return found, expected
