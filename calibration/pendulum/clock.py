"""The clock of a swing: frames that repeat the one before, and how long the thing is held."""

import numpy as np
from numpy.typing import NDArray

from calibration.segments import noise
from calibration.track import Array, Rows

_NEAR = 4  # steps on either side that say how fast the thing goes
_SAME = 0.1  # of the usual step: a picture shown again, within what compression changes
_STILL = 4  # times the noise: what moves less is held


def repeats(t: Array, gap: Array) -> tuple[Rows, NDArray[np.bool_]]:
    """Positions that repeat the one before where the thing moves on steadily.

    Also whether each took no time: the next position is then one step on, and two where the copy
    took the place of a lost frame.
    """
    sigma, step = noise(t, gap), np.diff(gap)
    found, late = [], []
    for k in range(1, len(step)):
        around = np.r_[max(k - 1 - _NEAR, 0) : k - 1, k : min(k + _NEAR, len(step))]
        usual = float(np.median(step[around]))
        steady = np.median(np.abs(step[around] - usual)) < abs(usual) / 4
        if steady and abs(usual) > 5 * sigma and abs(step[k - 1]) < _SAME * abs(usual):
            found.append(k)
            late.append(step[k] / usual < 1.5)
    return np.array(found, dtype=int), np.array(late, dtype=bool)


def held_until(t: Array, gap: Array) -> int | None:
    """The last of the first positions that are one within the noise; None for fewer than three."""
    off = np.abs(gap - np.median(gap[:3])) > _STILL * noise(t, gap)
    first = int(np.argmax(off)) if off.any() else 0
    return first - 1 if first > 3 else None
