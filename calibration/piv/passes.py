"""Displacement by FFT cross-correlation of windows in several passes.

The first pass correlates windows of twice the side, which finds displacements up to a window's
side. The next ones deform both pictures by what was found so far, smooth between the vectors,
correlate again, and add what is left. That is small then: the sub-pixel fit works about shift 0,
where it is without bias and does not lock to whole pixels.
"""

import numpy as np

from calibration.piv.correlation import correlate, find_peaks
from calibration.piv.deformation import deformable, deformed, everywhere
from calibration.piv.field import Field, Flags, Reason, Vectors, field, replaced, screened
from calibration.piv.pictures import Pixels, Texture, texture
from calibration.piv.statistics import noise_gain, sigmas
from calibration.piv.validation import smoothed
from calibration.piv.windows import Grid, grid

_PASSES = 3  # with deformation; what a further one adds is below sigma
_LEAST_RATIO = 1.2  # of the two highest peaks (Keane and Adrian 1990, Meas. Sci. Technol. 1, 1202)
_LEAST_SHARE = 0.5  # of a window that must be inside the mask


def piv(a: Pixels, b: Pixels, window: int, overlap: float, mask: Flags) -> Field:
    """The displacement of windows; see calibration.piv.displacement."""
    first, second = texture(a, mask, window), texture(b, mask, window)
    one, other = deformable(first), deformable(second)
    u, v = coarse(first, second, window, overlap)
    where = grid(a.shape, window, overlap)
    for last in range(_PASSES):
        front, back = deformed(one, other, u, v)
        rest = _correlated(front, back, where)
        found = rest._replace(u=rest.u + where.middles(u), v=rest.v + where.middles(v))
        if last < _PASSES - 1:
            u, v = _between(found, where, a.shape)
    gain = noise_gain(where.size, where.step)
    sigma_u, sigma_v = (gain * one for one in sigmas(front, back, where))
    return field(found, sigma_u, sigma_v, where, "piv")


def coarse(a: Texture, b: Texture, window: int, overlap: float) -> tuple[Pixels, Pixels]:
    """(height, width) displacement to within a few pixels, by windows of twice the side."""
    shape = a.grey.shape
    where = grid(shape, min(2 * window, *shape), overlap)
    return _between(_correlated(a, b, where), where, shape)


def outside(a: Texture, b: Texture, where: Grid) -> Flags:
    """(rows, columns) which windows lie outside the mask, by most of their pixels."""
    return np.asarray(where.means(a.weight * b.weight) < _LEAST_SHARE)


def _correlated(a: Texture, b: Texture, where: Grid) -> Vectors:
    """The shift of each window from a to b, up to half its side."""
    weights, parts = a.weight * b.weight, []
    for rows in where.chunks():
        front, back, weight = (where.cut(one, rows) for one in (a.grey, b.grey, weights))
        parts.append(find_peaks(correlate(front, back, weight, where.size // 2)))
    u, v, _, ratio, at_edge = (np.concatenate(one) for one in zip(*parts, strict=True))
    reason = np.select(
        [outside(a, b, where), np.isnan(u), at_edge, ratio < _LEAST_RATIO],
        [Reason.MASKED, Reason.NO_TEXTURE, Reason.TOO_FAR, Reason.AMBIGUOUS],
        Reason.MEASURED,
    )
    return Vectors(u, v, ratio, reason.astype(np.int8))


def _between(found: Vectors, where: Grid, shape: tuple[int, int]) -> tuple[Pixels, Pixels]:
    """(height, width) u and v: replaced where not valid, smoothed, interpolated."""
    u, v = (everywhere(smoothed(one), where, shape) for one in replaced(screened(found)))
    return u, v
