"""The clock of a swing: frames that repeat the one before, and how long the thing is held."""

import numpy as np
from numpy.typing import NDArray

from calibration.statistics.repeated import repeated
from calibration.tracking.segments import noise
from calibration.tracking.track import Array, Rows

_NEAR = 4  # steps on either side that say how fast the thing goes
_SAME = 0.1  # of the usual step: a picture shown again, within what compression changes
_STILL = 4  # times the noise: what moves less is held


def repeats(t: Array, gap: Array) -> tuple[Rows, NDArray[np.bool_]]:
    """Positions that repeat the one before in a swing; and whether the clock ran on in vain."""
    from scipy.ndimage import median_filter

    step = np.diff(gap)
    usual = median_filter(step, 2 * _NEAR + 1, mode="nearest")
    return repeated(step, np.abs(step) < _SAME * np.abs(usual), noise(t, gap))


def held_until(t: Array, gap: Array) -> int | None:
    """The last of the first positions that are one within the noise; None for fewer than three."""
    off = np.abs(gap - np.median(gap[:3])) > _STILL * noise(t, gap)
    first = int(np.argmax(off)) if off.any() else 0
    return first - 1 if first > 3 else None
