"""Effective angle of internal friction of a flow, from its mean stress.

    sin delta = sum (s1 - s2) / sum (s1 + s2)

over the points of the grid where the solid is sheared: principal stresses of the mean over moments,
so that each point counts by its pressure. A point counts where it is filled, two widths of the
Gaussian from the walls (nearer, the stress is smeared over them), and the mean velocity shears it
faster than the plug's speed over the silo's width: a plug that sinks between vertical walls is not
at its limit, and would make the angle too small. s1 - s2 is a root of squares, which the noise of a
mean over few moments makes too large: a jackknife over five equal parts of the time takes that off
(Quenouille 1956) and gives the interval (Tukey 1958), which of one run holds what differs from part
to part, not from packing to packing.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from granulab.campaign.output.statistics import quantile
from silo2d.measures.basics.coarse_graining import Floats

_PARTS = 5


def shear_rate(velocity: Floats, step: float) -> Floats:
    """Half the difference of the principal rates of strain (j, i) [1/s].

    velocity (2, j, i) [m/s], NaN where there is none, and so is the rate beside it; step of the
    grid [m].
    """
    (xy, xx), (yy, yx) = (np.gradient(part, step) for part in velocity)
    return np.hypot((xx - yy) / 2, (xy + yx) / 2)


class Angle(NamedTuple):
    """An angle [rad] with its interval of 95 %."""

    value: float
    low: float
    high: float


def ratio(stress: Floats, sheared: NDArray[np.bool_]) -> float:
    """sin delta of a mean stress (2, 2, j, i) where a mask (j, i) is true."""
    (xx, xy), (yx, yy) = stress
    radius = np.hypot((xx - yy) / 2, (xy + yx) / 2)
    return float(radius[sheared].sum() / ((xx + yy)[sheared].sum() / 2))


def effective_friction(stresses: Sequence[Floats], sheared: NDArray[np.bool_]) -> Angle | None:
    """The angle from the stresses of moments in a row, (2, 2, j, i) each.

    None of no point, and of less than a moment for each part.

    sheared: mask (j, i) of the points that count.
    """
    if not sheared.any():
        return None
    every = np.array(stresses)
    if len(every) < _PARTS:
        return None
    parts = np.array_split(np.arange(len(every)), _PARTS)
    without = [np.delete(every, part, axis=0).mean(axis=0) for part in parts]
    left = np.array([ratio(one, sheared) for one in without])
    whole = _PARTS * ratio(every.mean(axis=0), sheared) - (_PARTS - 1) * float(left.mean())
    if not 0 < whole < 1:
        return None
    error = math.sqrt((_PARTS - 1) / _PARTS * float(((left - left.mean()) ** 2).sum()))
    half = quantile(_PARTS - 1) * error
    low, high = (math.asin(min(max(whole + sign * half, 0.0), 1.0)) for sign in (-1, 1))
    return Angle(math.asin(whole), low, high)
