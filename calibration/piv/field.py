"""Displacement between two pictures: vectors on a grid, and which of them count."""

from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.piv.validation import filled, outliers
from calibration.piv.windows import Grid

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


class Reason(IntEnum):
    """Reason why a vector counts, or does not; the first that holds."""

    MEASURED = 0
    MASKED = 1  # less than half of the window is inside the mask
    NO_TEXTURE = 2  # one grey level, or nothing that is found again
    TOO_FAR = 3  # beyond the range of displacements that was searched
    AMBIGUOUS = 4  # the second peak is about as high as the first
    VAGUE = 5  # its sigma is above half a pixel
    OUTLIER = 6  # unlike its neighbours


@dataclass(frozen=True)
class Field:
    """Displacement from picture a to picture b on a grid of windows.

    Lengths in pixels, x to the right and y downwards, (0, 0) the middle of the pixel above on the
    left. A vector is that of the texture which is midway between the pictures at (x, y).

    x, y        (rows, columns) middle of each window
    u, v        (rows, columns) displacement along x and y; where not `valid`, the median of valid
                neighbours as a replacement; NaN where masked
    sigma_u, sigma_v   (rows, columns) standard uncertainty of u and v; NaN where not `valid`
    reason      (rows, columns) a Reason, as a number
    quality     (rows, columns) ratio of the highest peak of the correlation to the second ('piv'),
                1 where it has no second; forward-backward residual in pixels ('flow')
    window      side of a window
    method      'piv' or 'flow'
    """

    x: Array
    y: Array
    u: Array
    v: Array
    sigma_u: Array
    sigma_v: Array
    reason: NDArray[np.int8]
    quality: Array
    window: int
    method: str

    @property
    def valid(self) -> Flags:
        """(rows, columns) whether a vector was measured; the others are replaced or NaN."""
        return np.asarray(self.reason == Reason.MEASURED)

    @property
    def sigma(self) -> Array:
        """(rows, columns) standard uncertainty of one component, the root mean square of both."""
        return np.asarray(np.hypot(self.sigma_u, self.sigma_v) / np.sqrt(2.0))


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


def screened(found: Vectors) -> Vectors:
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
    found = screened(found._replace(reason=np.where(vague, np.int8(Reason.VAGUE), found.reason)))
    masked = found.reason == Reason.MASKED
    u, v = (np.where(masked, np.nan, one) for one in replaced(found))
    sigma_u, sigma_v = (np.where(found.good, one, np.nan) for one in (sigma_u, sigma_v))
    x, y = np.meshgrid(where.x, where.y)
    return Field(x, y, u, v, sigma_u, sigma_v, found.reason, found.quality, where.size, method)
