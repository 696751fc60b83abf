"""Where the points of one surface meet the other: node to segment, where the two are now.

Each point of the upper surface faces the segment of the lower one that it stands over; beyond
the lower surface's ends it faces nothing, or the next period. The normal goes from the lower to
the upper body, the tangent a quarter turn clockwise from it: to the right on level ground.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pairing:
    """Contacts of k points of the upper surface with places on the lower one.

    points       (k,) which of the upper surface's points
    left, share  (k,) the segment's left point, and how far along the segment, 0 to 1
    turn         (2, 2, k) rows: normal and tangent in x and y
    gap          (k,) along the normal [m]; negative where the surfaces overlap
    """

    points: NDArray[np.int64]
    left: NDArray[np.int64]
    share: Array
    turn: Array
    gap: Array

    def below(self, values: Array) -> Array:
        """Values (..., m) of the lower surface's points in the places that are faced, (..., k)."""
        found: Array = (1 - self.share) * values[..., self.left]
        found += self.share * values[..., self.left + 1]
        return found

    def handed_down(self, forces: Array, n_points: int) -> Array:
        """Forces (2, k) on the faced places as forces (2, m) on the lower surface's points."""
        found = np.zeros((2, n_points))
        for axis in (0, 1):
            np.add.at(found[axis], self.left, (1 - self.share) * forces[axis])
            np.add.at(found[axis], self.left + 1, self.share * forces[axis])
        return found

    def yielding(self, upper: Array, lower: Array) -> Array:
        """By how much unit forces (p of all, q of all) part the surfaces, (2k, 2k) [m2/N].

        From the flexibilities (2, n, 2, n) and (2, m, 2, m) of the two surfaces.
        """
        k = len(self.points)
        above = upper[:, self.points][..., self.points]
        under = np.moveaxis(self.below(np.moveaxis(self.below(lower), 1, -1)), -1, 1)
        whole: Array = np.einsum("aci,cidj,bdj->aibj", self.turn, above + under, self.turn)
        return whole.reshape(2 * k, 2 * k)

    def parted(self, upper: Array, lower: Array) -> Array:
        """By how much displacements (2, n) and (2, m) part the surfaces, (2, k) [m]."""
        apart = upper[:, self.points] - self.below(lower)
        turned: Array = np.einsum("aci,ci->ai", self.turn, apart)
        return turned


def pair(upper: Array, lower: Array, period: float | None = None) -> Pairing:
    """Pair the points (n, 2) of the upper surface with the lower surface's (m, 2), both [m].

    With a period [m] the last point of each is the first of the next.
    """
    x, z = lower.T
    slopes = np.gradient(z, x)
    if period is None:
        at = upper[:, 0]
        points = np.flatnonzero((at >= x[0]) & (at <= x[-1]))
    else:
        at = x[0] + np.mod(upper[:, 0] - x[0], period)
        points = np.arange(len(upper) - 1)
        slopes[[0, -1]] = (slopes[0] + slopes[-1]) / 2
    at = at[points]
    left = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(x) - 2)
    share = (at - x[left]) / (x[left + 1] - x[left])
    # the slope of smooth ground: a segment's own would jump at its ends
    slope = (1 - share) * slopes[left] + share * slopes[left + 1]
    cos, sin = 1 / np.hypot(1, slope), slope / np.hypot(1, slope)
    turn = np.array([[-sin, cos], [cos, sin]])
    height = (1 - share) * z[left] + share * z[left + 1]
    return Pairing(points, left, share, turn, (upper[points, 1] - height) * cos)
