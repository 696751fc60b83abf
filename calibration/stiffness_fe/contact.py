"""Contact of two elastic surfaces: which points meet, and which touch, stick and slide.

Each point of the upper surface faces the segment of the lower one that it stands over; beyond the
lower surface's ends it faces nothing, or the next period. The normal goes from the lower to the
upper body, the tangent a quarter rotation clockwise from it: to the right on level ground.

Signorini's and Coulomb's laws:
A contact's gap g >= 0, its pressing force p >= 0 and p g = 0; its friction |q| <= mu p, where no
slip s happens below the limit and slip is against the friction at it. The surfaces yield linearly:
(g, s) = (g0, s0) + W (p, q). Solved by a semismooth Newton method (Alart and Curnier 1991), which
in the plane is an active-set method: guess who touches, sticks and slides; solve; repeat.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pairing:
    """Contacts of k points of the upper surface with positions on the lower one.

    points       (k,) which of the upper surface's points
    left, share  (k,) the segment's left point, and how far along the segment, 0 to 1
    rotation     (2, 2, k) rows: normal and tangent in x and y
    gap          (k,) along the normal [m]; negative where the surfaces overlap
    """

    points: NDArray[np.int64]
    left: NDArray[np.int64]
    share: Array
    rotation: Array
    gap: Array

    def below(self, values: Array) -> Array:
        """Values (..., m) of the lower surface's points in the faced positions, (..., k)."""
        found: Array = (1 - self.share) * values[..., self.left]
        found += self.share * values[..., self.left + 1]
        return found

    def handed_down(self, forces: Array, n_points: int) -> Array:
        """Forces (2, k) on the faced positions as forces (2, m) on the lower surface's points."""
        found = np.zeros((2, n_points))
        for axis in (0, 1):
            np.add.at(found[axis], self.left, (1 - self.share) * forces[axis])
            np.add.at(found[axis], self.left + 1, self.share * forces[axis])
        return found

    def yielding(self, upper: Array, lower: Array) -> Array:
        """Gaps and slips by unit forces (p of all, q of all), (2k, 2k) [m2/N].

        From the flexibilities (2, n, 2, n) and (2, m, 2, m) of the two surfaces.
        """
        k = len(self.points)
        above = upper[:, self.points][..., self.points]
        under = np.moveaxis(self.below(np.moveaxis(self.below(lower), 1, -1)), -1, 1)
        whole: Array = np.einsum("aci,cidj,bdj->aibj", self.rotation, above + under, self.rotation)
        return whole.reshape(2 * k, 2 * k)

    def parted(self, upper: Array, lower: Array) -> Array:
        """Gaps and slips by displacements (2, n) and (2, m) of the surfaces, (2, k) [m]."""
        apart = upper[:, self.points] - self.below(lower)
        rotated: Array = np.einsum("aci,ci->ai", self.rotation, apart)
        return rotated


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
    rotation = np.array([[-sin, cos], [cos, sin]])
    height = (1 - share) * z[left] + share * z[left + 1]
    return Pairing(points, left, share, rotation, (upper[points, 1] - height) * cos)


OPEN, STICK, SLIDE = 0, 1, 2  # a sliding contact is SLIDE or -SLIDE, by the sign of its friction
_ROUNDS = 60  # of guesses; a load step takes about five


class NoContactStateError(Exception):
    """No set of touching, sticking and sliding contacts was found that agrees with itself."""


def solve_contact(
    yielding: Array, free: Array, friction: float, guess: Array
) -> tuple[Array, NDArray[np.int64]]:
    """Forces (p, q), (2n,) [N/m], and what each contact does, (n,).

    yielding  W (2n, 2n) [m2/N], symmetric and positive definite
    free      (g0, s0) of all contacts, without forces (2n,) [m]
    guess     forces of the step before (2n,)

    Raises NoContactStateError.
    """
    n = len(free) // 2
    scale = 1.0 / np.mean(np.diag(yielding))
    forces, before = guess, None
    for _ in range(_ROUNDS):
        trial = forces - scale * (free + yielding @ forces)
        state = _state(trial[:n], trial[n:], friction)
        if before is not None and np.array_equal(state, before):
            return forces, state
        try:
            forces = _forces(yielding, free, state, friction)
        except np.linalg.LinAlgError:
            raise NoContactStateError from None
        before = state
    raise NoContactStateError


def _state(pressing: Array, friction_force: Array, friction: float) -> NDArray[np.int64]:
    """State of each contact, from the forces and what they would be for the motion."""
    touches = pressing > 0
    slides = np.abs(friction_force) >= friction * pressing
    state = np.where(slides, np.where(friction_force < 0, -SLIDE, SLIDE), STICK)
    found: NDArray[np.int64] = np.where(touches, state, OPEN).astype(np.int64)
    return found


def _forces(yielding: Array, free: Array, state: NDArray[np.int64], friction: float) -> Array:
    """Forces that close the gap of all that touch, and hold all that stick.

    The unknowns are p of those that touch and q of those that stick; q = +-mu p of the others.
    """
    n = len(state)
    touch, stick = np.flatnonzero(state), np.flatnonzero(state == STICK)
    rows = np.concatenate([touch, n + stick])
    matrix = yielding[np.ix_(rows, rows)]
    slide = np.flatnonzero(np.abs(state) == SLIDE)
    of_slide = np.searchsorted(touch, slide)
    limit = friction * np.sign(state[slide])
    matrix[:, of_slide] += yielding[np.ix_(rows, n + slide)] * limit
    forces = np.zeros(2 * n)
    forces[rows] = np.linalg.solve(matrix, -free[rows])
    forces[n + slide] = limit * forces[slide]
    return forces
