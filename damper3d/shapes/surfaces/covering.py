"""Covers the pieces of a surface with few balls, the greedy way: kernels."""

import numpy as np

from granulab.contact.jit import njit

_ROUNDING = 1e-9  # of the whole area, below which a gain is none


@njit
def reaches(corners, centres, radii, found):
    """By how much each ball must grow to hold each piece, into found (m, n) [m].

    corners (m, c, 3): of m pieces [m]; centres (n, 3), radii (n,): of the balls [m]. Balls are
    convex, so one that holds the corners of a piece holds the piece.
    """
    for m in range(len(corners)):
        for k in range(len(centres)):
            farthest = 0.0
            for c in range(corners.shape[1]):
                x = corners[m, c, 0] - centres[k, 0]
                y = corners[m, c, 1] - centres[k, 1]
                z = corners[m, c, 2] - centres[k, 2]
                farthest = max(farthest, x * x + y * y + z * z)
            found[m, k] = np.sqrt(farthest) - radii[k]


@njit
def cover(reach, area, limit, chosen):
    """Choose balls that hold all pieces when they grow by a limit [m]; how many, or -1.

    reach as of `reaches`; area (m,): of the pieces [m2]. The next ball is always the one that holds
    most of the area that is left, the first of equals. chosen (most,): numbers of the balls, to be
    written; -1 where it is too short, or where some piece is in no ball.
    """
    left = np.ones(len(reach), np.bool_)
    gain = np.zeros(reach.shape[1])
    for m in range(len(reach)):
        for k in range(reach.shape[1]):
            gain[k] += area[m] * (reach[m, k] <= limit)
    least = _ROUNDING * area.sum()
    number = 0
    while left.any():
        best = np.argmax(gain)
        if gain[best] <= least or number == len(chosen):
            return -1
        chosen[number] = best
        number += 1
        for m in range(len(reach)):
            if left[m] and reach[m, best] <= limit:
                left[m] = False
                for k in range(reach.shape[1]):
                    gain[k] -= area[m] * (reach[m, k] <= limit)
    return number
