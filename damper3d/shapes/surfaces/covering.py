"""Covers the pieces of a surface with few spheres, the greedy way: kernels."""

import numpy as np

from granulab.contact.jit import njit
from granulab.contact.vectors import add, dot, norm, scale

_ROUNDING = 1e-9  # of the whole area, below which a gain is none


@njit
def needed_growth(corners, centres, radii, found):
    """Length by which each sphere must grow to hold each piece, into found (m, n) [m].

    corners (m, c, 3): of m pieces [m]; centres (n, 3), radii (n,): of the spheres [m]. Spheres are
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
def cover(growth, area, limit, chosen):
    """Choose spheres that hold all pieces when they grow by a limit [m]; their number, or -1.

    growth as of `needed_growth`; area (m,): of the pieces [m2]. The next sphere is always the one
    that holds most of the area that is left, the first of equals. chosen (most,): numbers of the
    spheres, to be written; -1 where it is too short, or where some piece is in no sphere.
    """
    left = np.ones(len(growth), np.bool_)
    gain = np.zeros(growth.shape[1])
    for m in range(len(growth)):
        for k in range(growth.shape[1]):
            gain[k] += area[m] * (growth[m, k] <= limit)
    least = _ROUNDING * area.sum()
    number = 0
    while left.any():
        best = np.argmax(gain)
        if gain[best] <= least or number == len(chosen):
            return -1
        chosen[number] = best
        number += 1
        for m in range(len(growth)):
            if left[m] and growth[m, best] <= limit:
                left[m] = False
                for k in range(growth.shape[1]):
                    gain[k] -= area[m] * (growth[m, k] <= limit)
    return number


@njit
def to_segment(p, a, b):
    """Distance from p to the segment from a to b; vectors of three numbers [m]."""
    along = add(b, scale(-1.0, a))
    from_a = add(p, scale(-1.0, a))
    length2 = dot(along, along)
    share = dot(from_a, along) / length2 if length2 > 0.0 else 0.0
    share = min(max(share, 0.0), 1.0)
    return norm(add(from_a, scale(-share, along)))


@njit
def to_triangle(p, a, b, c):
    """Distance from p to the triangle a, b, c; vectors of three numbers [m].

    To its plane where the foot lies inside, by the barycentric shares of the foot; else to the
    nearest edge.
    """
    ab, ac, ap = add(b, scale(-1.0, a)), add(c, scale(-1.0, a)), add(p, scale(-1.0, a))
    bb, bc, cc = dot(ab, ab), dot(ab, ac), dot(ac, ac)
    pb, pc = dot(ap, ab), dot(ap, ac)
    area2 = bb * cc - bc * bc
    v, w = cc * pb - bc * pc, bb * pc - bc * pb
    if area2 > 0.0 and v >= 0.0 and w >= 0.0 and v + w <= area2:
        foot = add(scale(v / area2, ab), scale(w / area2, ac))
        return norm(add(ap, scale(-1.0, foot)))
    return min(to_segment(p, a, b), to_segment(p, b, c), to_segment(p, c, a))


@njit
def to_surface(points, corners, middles, needed_growth):
    """Distance of each point (n, 3) to a surface of triangles (m, 3, 3), (n,) [m].

    middles (m, 3) [m]: of the triangles; needed_growth (m,): from there to the farthest corner [m].
    """
    found = np.empty(len(points))
    for k in range(len(points)):
        p = (points[k, 0], points[k, 1], points[k, 2])
        nearest = np.inf
        for m in range(len(corners)):
            to_middle = norm((p[0] - middles[m, 0], p[1] - middles[m, 1], p[2] - middles[m, 2]))
            if to_middle - needed_growth[m] < nearest:
                t = corners[m]
                a = (t[0, 0], t[0, 1], t[0, 2])
                b = (t[1, 0], t[1, 1], t[1, 2])
                c = (t[2, 0], t[2, 1], t[2, 2])
                nearest = min(nearest, to_triangle(p, a, b, c))
        found[k] = nearest
    return found
