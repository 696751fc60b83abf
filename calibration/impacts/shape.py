"""Whether impacts have the same shape, so that their onsets can be compared.

Each impact's first swing is laid over the mean of all, scaled by its first peak, and shifted until
they agree best. Where onsets and shapes tell the same, the shifts are no larger than the noise
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
    rise = max(_LEAST_RISE, float(np.median([one.peak - one.time for one in onsets])))
    t = np.arange(-rise, 2.0 * rise, max(0.25, 0.01 * rise))
    step = t[1] - t[0]
    swings = np.array([_swing(x, one, t, 0.0) for one in onsets])
    shifts, errors = np.zeros(len(onsets)), np.zeros(len(onsets))
    for k, one in enumerate(onsets):
        others = np.delete(swings, k, axis=0).mean(axis=0)
        slope = np.gradient(others, step)
        for _ in range(_ROUNDS):  # Gauss and Newton
            behind = ((others - _swing(x, one, t, shifts[k])) * slope).sum() / (slope**2).sum()
            shifts[k] = np.clip(shifts[k] + behind, -rise, rise)
        errors[k] = abs(one.noise / one.height) / np.sqrt(step * (slope**2).sum())
    return shifts, errors


def _swing(
    x: NDArray[np.float64], one: Onset, t: NDArray[np.float64], shift: float
) -> NDArray[np.float64]:
    """An impact at times t (k,) in samples from its onset and a shift, over its first peak."""
    begin, end = (int(np.clip(one.time + side * t[-1], 0, len(x))) for side in (-2.0, 2.0))
    samples = np.interp(one.time + shift + t, np.arange(begin, end), x[begin:end])
    return (samples - one.base) / one.height
