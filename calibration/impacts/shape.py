"""Whether impacts have the same shape, so that their onsets can be compared.

Each impact's first swing is laid over the mean of the others, in parts of its own rise and of its
first peak, and shifted, stretched and scaled until they agree best (contacts may get softer at
lower speed). Where onsets and shapes tell the same, the shifts are no larger than the noise
explains. Where they are larger, the impacts have different shapes (sound that takes another way, a
ball that lands on another spot), and the scatter of the shifts is added to every uncertainty.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from calibration.impacts.onset import Onset

_ROUNDS = 6
_LEAST_RISE = 3.0  # samples
_ALIKE = 0.05  # chance of shifts as large as these, below which the shapes are not alike


def with_shape(x: NDArray[np.float64], onsets: Sequence[Onset]) -> NDArray[np.float64]:
    """The sigma (m,) of each onset in samples: noise, and what the shapes differ beyond it."""
    from scipy.stats import chi2

    noise = np.array([one.sigma for one in onsets])
    if len(onsets) < 3:
        return noise
    shifts, errors = _shifts(x, onsets)
    variance = noise**2 + errors**2
    mean = np.average(shifts, weights=1.0 / variance)
    if chi2.sf(((shifts - mean) ** 2 / variance).sum(), len(shifts) - 1) >= _ALIKE:
        return noise
    excess = max(0.0, float(shifts.var(ddof=1) - variance.mean()))
    return np.hypot(noise, np.sqrt(excess))


def _shifts(
    x: NDArray[np.float64], onsets: Sequence[Onset]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How far each impact lies behind the mean of the others (m,), and the noise in that."""
    rise = max(_LEAST_RISE, float(np.median([one.rise for one in onsets])))
    u = np.arange(-1.0, 2.0, max(0.25 / rise, 0.01))  # in rises
    swings = np.array([_swing(x, one, u, 0.0, 1.0) for one in onsets])
    shifts, errors = np.zeros(len(onsets)), np.zeros(len(onsets))
    for k, one in enumerate(onsets):
        others = np.delete(swings, k, axis=0).mean(axis=0)
        shifts[k], errors[k] = _laid_over(x, one, u, others)
    return shifts, errors


def _laid_over(
    x: NDArray[np.float64], one: Onset, u: NDArray[np.float64], others: NDArray[np.float64]
) -> tuple[float, float]:
    """Shift in samples of an impact over the others' mean (k,), with a stretch and a height."""
    slope = np.gradient(others, u)
    columns = np.column_stack([slope, u * slope, others])
    inverse = np.linalg.pinv(columns)
    shift, stretch, height = 0.0, 1.0, 1.0
    for _ in range(_ROUNDS):  # Gauss and Newton
        apart = others - _swing(x, one, u, shift, stretch) / height
        behind, wider, lower = inverse @ apart
        shift = float(np.clip(shift + behind, -1.0, 1.0))
        stretch = float(np.clip(stretch + wider, 0.5, 2.0))
        height = float(np.clip(height - lower, 0.5, 2.0))
    step = (u[1] - u[0]) * one.rise  # samples, fewer than one: noise repeats
    error = abs(one.edge.noise / one.edge.height) * np.sqrt((inverse[0] ** 2).sum() / step)
    return shift * one.rise, float(error) * one.rise


def _swing(
    x: NDArray[np.float64], one: Onset, u: NDArray[np.float64], shift: float, stretch: float
) -> NDArray[np.float64]:
    """An impact at u (k,) rises from its onset, shifted and stretched, over its first peak."""
    t = one.time + one.rise * (shift + stretch * u)
    begin, end = int(np.clip(t[0] - 1, 0, len(x) - 1)), int(np.clip(t[-1] + 2, 1, len(x)))
    samples = np.interp(t, np.arange(begin, end), x[begin:end])
    base = one.edge.base[one.edge.peak]
    return np.asarray((samples - base) / one.edge.height)
