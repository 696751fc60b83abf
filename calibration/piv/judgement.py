"""Vectors as they were found, and which of them count."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.piv.field import Array, Field, Flags, Reason
from calibration.piv.validation import filled, outliers
from calibration.piv.windows import Grid

_MOST_SIGMA = 0.5  # px; beyond it a vector is not known to the pixel, and matched by chance


class Vectors(NamedTuple):
    """Vectors of one pass on a grid of windows.

    u, v      (rows, columns) [px], NaN where there is no texture
    quality   (rows, columns) see Field
    reason    (rows, columns) a Reason, as a number
    """

    u: Array
    v: Array
    quality: Array
    reason: NDArray[np.int8]

    @property
    def good(self) -> Flags:
        """(rows, columns) which of them count."""
        return np.asarray(self.reason == Reason.MEASURED)


def judged(found: Vectors) -> Vectors:
    """The same with those marked that are unlike their neighbours."""
    u, v = (np.where(found.good, one, np.nan) for one in found[:2])
    reason = np.where(outliers(u, v), np.int8(Reason.OUTLIER), found.reason)
    return found._replace(reason=reason)


def replaced(found: Vectors) -> tuple[Array, Array]:
    """(rows, columns) u and v, the median of good neighbours where they do not count."""
    u, v = (filled(np.where(found.good, one, np.nan)) for one in found[:2])
    return u, v


def field(found: Vectors, sigma_u: Array, sigma_v: Array, where: Grid, method: str) -> Field:
    """Vectors that are well enough known, and the others replaced."""
    vague = found.good & ~(np.maximum(sigma_u, sigma_v) <= _MOST_SIGMA)
    found = judged(found._replace(reason=np.where(vague, np.int8(Reason.VAGUE), found.reason)))
    masked = found.reason == Reason.MASKED
    u, v = (np.where(masked, np.nan, one) for one in replaced(found))
    sigma_u, sigma_v = (np.where(found.good, one, np.nan) for one in (sigma_u, sigma_v))
    x, y = np.meshgrid(where.x, where.y)
    return Field(x, y, u, v, sigma_u, sigma_v, found.reason, found.quality, where.size, method)
