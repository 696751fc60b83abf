"""Positions of an object in motion that repeat the one before: pictures that were shown again."""

import numpy as np
from numpy.typing import NDArray

from calibration.tracking.track import Array, Rows

_NEAR = 4  # steps on either side that say how fast the object goes


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
