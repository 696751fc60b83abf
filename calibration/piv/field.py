"""What a measurement of displacement between two pictures gives: vectors on a grid."""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


class Reason(IntEnum):
    """Why a vector counts, or does not; the first that holds."""

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
