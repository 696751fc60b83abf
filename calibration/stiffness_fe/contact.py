"""Which points of two elastic surfaces touch, stick and slide: Signorini's and Coulomb's laws.

A contact's gap g >= 0, its pressing force p >= 0 and p g = 0; its friction |q| <= mu p, where no
slip s happens below the limit and slip is against the friction at it. The surfaces yield linearly:
(g, s) = (g0, s0) + W (p, q). Solved by a semismooth Newton method (Alart and Curnier 1991), which
in the plane is an active-set method: guess who touches, sticks and slides; solve; ask again.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

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
        forces = _forces(yielding, free, state, friction)
        before = state
    raise NoContactStateError


def _state(pressing: Array, rubbing: Array, friction: float) -> NDArray[np.int64]:
    """Who touches, sticks and slides, from the forces and what they would be for the motion."""
    touches = pressing > 0
    slides = np.abs(rubbing) >= friction * pressing
    state = np.where(slides, np.where(rubbing < 0, -SLIDE, SLIDE), STICK)
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
