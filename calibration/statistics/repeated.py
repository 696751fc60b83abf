"""Positions of an object in motion that repeat the one before: pictures that were shown again."""

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.track import Array, Rows

_NEAR = 4  # steps on either side that say how fast the object goes
_STILL = 0.2  # of the larger steps around: less is a copy, an apex, or a contact
_FAST = 0.1  # of the fastest steps, from which on a step says whether its picture is a copy
_LONGEST = 6  # frames of a regular pattern: 25 made to 30 frames/s repeats every sixth
_SURE, _ELSEWHERE = 0.9, 0.2  # share of steps that are still at the copies' place, at others
_FEWEST = 5  # copies in fast motion that show a pattern: chance gives 0.2^5


def still(step: Array) -> NDArray[np.bool_]:
    """(n - 1,) marks of the steps far smaller than the larger ones around; step (n - 1,) >= 0."""
    return step < _STILL * _larger(step)


def _larger(step: Array) -> Array:
    """Upper quartile of the steps around: fast ones, where every second is a copy, too.

    Positions may be missing (NaN); where no step around is known it is 0, as of an object at rest.
    """
    from numpy.lib.stride_tricks import sliding_window_view

    padded = np.pad(step, _NEAR, constant_values=np.nan)
    around = sliding_window_view(padded, 2 * _NEAR + 1)
    larger = np.zeros(len(step))
    known = np.isfinite(around).any(axis=1)
    larger[known] = np.nanquantile(around[known], 0.75, axis=1)
    return larger


def pattern(frame: Array, step: Array) -> tuple[int, int] | None:
    """Period and place of copies that stand at every so many frames, as converters put them.

    frame  (n,) whole numbers;  step (n - 1,) from each position to the next [px], >= 0
    """
    if len(step) < 2 * _FEWEST or np.any(frame != np.round(frame)):
        return None
    larger = _larger(step)
    judged = (np.diff(frame) == 1) & (larger > _FAST * np.quantile(larger, 0.95))
    place, same = frame[1:][judged], still(step)[judged]
    for period in range(2, _LONGEST + 1):
        for at in range(period):
            here = place % period == at
            if np.sum(same & here) < _FEWEST or same[here].mean() < _SURE:
                continue
            if same[~here].mean() < _ELSEWHERE:
                return period, at
    return None


def repeated(step: Array, same: NDArray[np.bool_], sigma: float) -> tuple[Rows, NDArray[np.bool_]]:
    """Rows of such positions, and whether the clock ran on in vain at each.

    step     (n - 1,) from each of n positions to the next [px]
    same     (n - 1,) whether a position may be that before it
    sigma    noise of a position [px]

    A position is one where the object moves on steadily about it, onward before and after: about an
    apex, or where it comes to rest, a position is like that before it without being its copy. The
    clock ran on in vain where the next position is one step on, and did not (the copy took the
    place of a lost frame) where it is two.
    """
    found, late = [], []
    for k in (int(i) + 1 for i in np.flatnonzero(same)):
        near = range(max(k - _NEAR, 0), min(k + _NEAR, len(step)))
        around = [i for i in near if not same[i] and i != k]
        usual = np.median(step[around]) if around else 0.0
        steady = around and np.median(np.abs(step[around] - usual)) < abs(usual) / 2
        before, after = ([step[i] for i in around if (i < k) == first] for first in (True, False))
        onward = before and after and np.median(before) * np.median(after) > 0
        if not (steady and onward) or abs(usual) < 5 * sigma or k >= len(step):
            continue
        found.append(k)
        late.append(step[k] / usual < 1.5)
    return np.array(found, dtype=int), np.array(late, dtype=bool)
