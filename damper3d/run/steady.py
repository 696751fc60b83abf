"""Steadiness of the cycles, and confidence intervals of their mean.

A forced host is steady where the amplitude of its first harmonic is.

Near the transition cycles alternate (period two), so nothing here compares one cycle with the
next: an interval takes the alternation out, and blocks hold an even number of cycles.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

BLOCK = 4  # cycles: even, so that a block holds whole alternations, of period four too
LEAST_BLOCKS = 4  # that are judged; three degrees of freedom
ENOUGH_BLOCKS = 8  # that cycles must have to be called steady where nothing went on until they are
TEN = 10  # cycles over which a host's amplitude is compared: the host remembers some
UNCHANGED = 0.005  # of an amplitude, over them
CONFIDENCE = 0.95
RELATIVE = 0.05  # of the mean that the half width of its interval may be
ABSOLUTE = 0.005  # or this: efficiencies go from 0 to 1


def interval(values: ArrayLike, confidence: float = CONFIDENCE) -> tuple[float, float] | None:
    """Confidence interval of the mean of a few successive cycles; None for fewer than three.

    The cycles are taken as m + a (-1)^k + noise, fitted by least squares: an alternation is no
    scatter. The half width is Student's t, with two degrees of freedom taken, times the standard
    error; for an odd number of cycles |a|/n is added, which their mean holds of it. The noise of
    neighbouring cycles is taken as independent. It says nothing about other packings.
    """
    x = np.asarray(values, float)
    n = len(x)
    if n < 3:
        return None
    design = np.column_stack([np.ones(n), (-1.0) ** np.arange(n)])
    fit = np.linalg.lstsq(design, x, rcond=None)[0]
    scatter = float(((x - design @ fit) ** 2).sum()) / (n - 2)
    half = _student(n - 2, confidence) * math.sqrt(scatter / n) + (n % 2) * abs(fit[1]) / n
    return float(x.mean() - half), float(x.mean() + half)


@dataclass(frozen=True)
class Course:
    """Part of successive efficiencies that is no scatter: what alternates, and the drift.

    alternation  amplitude a of (-1)^k [-]
    drift        change from the first to the last cycle [-]

    Each is 0 where its interval holds 0, or where the mean is off by less than `limit` [-] by it.
    """

    alternation: float
    drift: float
    limit: float

    @classmethod
    def of(cls, values: ArrayLike, confidence: float = CONFIDENCE) -> "Course | None":
        """The course of a few cycles (n,), m + a (-1)^k + b k + noise by least squares.

        None for fewer than four, of which no scatter is left to compare with.
        """
        x = np.asarray(values, float)
        n = len(x)
        if n < 4:
            return None
        k = np.arange(n) - 0.5 * (n - 1)
        design = np.column_stack([np.ones(n), (-1.0) ** np.arange(n), k])
        fit = np.linalg.lstsq(design, x, rcond=None)[0]
        scatter = float(((x - design @ fit) ** 2).sum()) / (n - 3)
        errors = np.sqrt(scatter * np.diag(np.linalg.inv(design.T @ design)))
        limit = max(RELATIVE * abs(float(x.mean())), ABSOLUTE)
        certain = np.abs(fit) > _student(n - 3, confidence) * errors
        # An even number of cycles holds whole alternations, an odd one a/n of them.
        alternation = abs(float(fit[1])) if certain[1] and n % 2 * abs(fit[1]) / n > limit else 0.0
        drift = float(fit[2]) * (n - 1)
        return cls(alternation, drift if certain[2] and abs(drift) > limit else 0.0, limit)


def verdict(values: ArrayLike) -> tuple[bool | None, str | None]:
    """Judge whether counted cycles are those of a steady bed, with a line on what they do instead.

    Of a run that did not go on until it is steady. True takes ENOUGH_BLOCKS blocks of cycles that
    agree without a trend; None is of too few cycles to say.
    """
    x = np.asarray(values, float)
    course = Course.of(x)
    if course is not None and course.drift:
        return False, (
            f"the counted cycles drift by {course.drift:+.3f}, of {x.mean():.3f} in the mean: go "
            "on until they are steady (--steady, or more --cycles)"
        )
    if course is not None and course.alternation:
        return None, (
            f"the counted cycles alternate by {course.alternation:.3f} about {x.mean():.3f}, and "
            f"their odd number, {len(x)}, holds {course.alternation / len(x):.3f} of it: count an "
            "even number (one more --discard), or go on until they are steady (--steady)"
        )
    if len(x) < BLOCK * ENOUGH_BLOCKS:
        return None, None
    if _agree(x, BLOCK, CONFIDENCE, RELATIVE, ABSOLUTE):
        return True, None
    return False, "the counted cycles are too unlike for their mean: give more --cycles"


def block_means(values: ArrayLike, block: int = BLOCK) -> np.ndarray:
    """Means over whole blocks of cycles, the last block ending with the last cycle."""
    x = np.asarray(values, float)
    n_blocks = len(x) // block
    return x[len(x) - n_blocks * block :].reshape(n_blocks, block).mean(axis=1)


def block_interval(
    values: ArrayLike, block: int = BLOCK, confidence: float = CONFIDENCE
) -> tuple[float, float]:
    """Confidence interval of the mean of many cycles, from the scatter of their block means."""
    means = block_means(values, block)
    half = _student(len(means) - 1, confidence) * means.std(ddof=1) / math.sqrt(len(means))
    return float(means.mean() - half), float(means.mean() + half)


def judged(n_cycles: int, *, block: int = BLOCK, least_blocks: int = LEAST_BLOCKS) -> int:
    """Number of the last cycles that are judged: half of them in whole blocks, or least_blocks."""
    return block * max(least_blocks, n_cycles // block // 2)


def keeps_amplitude(amplitudes: ArrayLike) -> bool:
    """True where the mean amplitude of the last ten cycles is that of the ten before, to 0.5 %."""
    x = np.asarray(amplitudes, float)
    if len(x) < 2 * TEN:
        return False
    before, last = x[-2 * TEN : -TEN].mean(), x[-TEN:].mean()
    return bool(abs(last - before) < UNCHANGED * max(last, before))


def is_steady(
    values: ArrayLike,
    *,
    block: int = BLOCK,
    least_blocks: int = LEAST_BLOCKS,
    confidence: float = CONFIDENCE,
    relative: float = RELATIVE,
    absolute: float = ABSOLUTE,
) -> bool:
    """True where the efficiencies of cycles (n,), start-up left out, have become steady.

    The last half of the cycles is judged, in blocks of `block` cycles, at least `least_blocks`:

    1. they agree: the half width of the confidence interval of the blocks' mean is below
       `relative` times the mean, or below `absolute`;
    2. there is no trend: the slope of a straight line through the block means is within its
       confidence interval of zero, or the drift over the judged cycles is below the same limit.

    A metastable state that outlives the judged cycles passes for a steady one.
    """
    x = np.asarray(values, float)
    n_judged = judged(len(x), block=block, least_blocks=least_blocks)
    return len(x) >= n_judged and _agree(x[-n_judged:], block, confidence, relative, absolute)


def _agree(x: np.ndarray, block: int, confidence: float, relative: float, absolute: float) -> bool:
    """True where the blocks of these cycles agree, and there is no trend: see is_steady."""
    means = block_means(x, block)
    low, high = block_interval(x, block, confidence)
    limit = max(relative * abs(float(means.mean())), absolute)
    return 0.5 * (high - low) <= limit and not _has_trend(means, confidence, limit)


def _has_trend(means: np.ndarray, confidence: float, limit: float) -> bool:
    n = len(means)
    t = np.arange(n) - 0.5 * (n - 1)
    slope = float(t @ means) / float(t @ t)
    left = means - means.mean() - slope * t
    error = math.sqrt(float(left @ left) / (n - 2) / float(t @ t))
    drift = abs(slope) * (n - 1)
    return abs(slope) > _student(n - 2, confidence) * error and drift > limit


def _student(freedom: int, confidence: float) -> float:
    """Half width of a two-sided interval in standard errors."""
    from scipy.special import stdtrit

    return float(stdtrit(freedom, 0.5 + 0.5 * confidence))
