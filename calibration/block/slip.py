"""The instant at which a block first slips, from its way along the plate against time.

At rest before t0; from then on the pull down the plate exceeds friction by what the friction falls
once it slides, and by what the plate goes on tilting: s'' = a + j (t - t0) with a, j >= 0, so

    s = c + a (t - t0)^2/2 + j (t - t0)^3/6,   t > t0

For each t0 the best c, a, j (least squares, none negative) give a likelihood; t0 is its mean, its
sigma the standard deviation. The noise is that of the positions about the fit.
"""

from typing import NamedTuple

import numpy as np

from calibration.statistics.robust import for_correlation
from calibration.tracking.track import Array

_SLID = 8.0  # px of the way that is fitted: beyond it drag and a plate that stops count
_FEWEST = 3  # frames in motion; c, a, j and t0 need the last ones at rest, too
_BEFORE = 40  # frames at rest that are fitted with them: their mean is known to a sixth of a point
_GRID = 400  # instants that are tried
_FLOOR = 0.01  # px: no position is known better


class Slip(NamedTuple):
    """time      of the first slip, in the unit of the times given
    sigma     of it
    shown     times, and the fitted way at them [px]
    noise     of a position [px]
    """

    time: float
    sigma: float
    shown: tuple[Array, Array]
    noise: float


def first_slip(time: Array, way: Array) -> Slip | None:
    """The first slip in ways (n,) [px] at times (n,); None where the block does not slip away."""
    slid = np.flatnonzero(way > _SLID)
    if not len(slid):
        return None
    end = int(slid[0])
    # The last frame from which the way only grows is the first in motion, but for noise.
    still = int(np.flatnonzero(way[: end + 1] < _SLID / 8)[-1]) if way[0] < _SLID / 8 else 0
    end = max(end, min(still + _FEWEST, len(way) - 1))
    first = max(still - _BEFORE, 0)
    t, s = time[first : end + 1], way[first : end + 1]
    step = float(np.median(np.diff(t)))
    grid = np.linspace(t[0], t[-1], max(_GRID, 8 * len(t)))
    fits = [_fit(t, s, t0) for t0 in grid]
    square = np.array([one[1] for one in fits])
    best = int(square.argmin())
    off = s - _way(t, grid[best], fits[best][0])
    widened = for_correlation(off, [np.arange(len(off))])
    variance = max(float(square[best]) / max(len(t) - 4, 1), _FLOOR**2) * widened
    # Once more about the best, as finely as the likelihood is narrow.
    likely = grid[square - square[best] < 25 * variance]
    near = np.linspace(likely[0] - step / 4, likely[-1] + step / 4, _GRID)
    square = np.array([_fit(t, s, t0)[1] for t0 in near])
    weight = np.exp(-(square - square.min()) / (2 * variance))
    weight /= weight.sum()
    mean = float(weight @ near)
    sigma = float(np.sqrt(weight @ (near - mean) ** 2))
    shown = np.linspace(t[0], t[-1], 200)
    return Slip(
        mean, sigma, (shown, _way(shown, mean, _fit(t, s, mean)[0])), float(np.sqrt(variance))
    )


def _powers(t: Array, t0: float) -> Array:
    late = np.maximum(t - t0, 0.0)
    return np.column_stack([np.ones_like(t), -np.ones_like(t), late**2 / 2, late**3 / 6])


def _fit(t: Array, s: Array, t0: float) -> tuple[Array, float]:
    """c (as two numbers of either sign), a, j, none negative, and the sum of squares."""
    from scipy.optimize import nnls

    powers = _powers(t, t0)
    size = np.maximum(np.linalg.norm(powers, axis=0), 1e-12)
    found, root = nnls(powers / size, s)
    return found / size, float(root) ** 2


def _way(t: Array, t0: float, found: Array) -> Array:
    return np.asarray(_powers(t, t0) @ found)
