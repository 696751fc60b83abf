"""Distances from points to triangles and to surfaces of them: kernels."""

import numpy as np

from granulab.contact.jit import njit
from granulab.contact.vectors import add, dot, norm, scale


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
def to_surface(points, corners, middles, reaches):
    """Distance of each point (n, 3) to a surface of triangles (m, 3, 3), (n,) [m].

    middles (m, 3) [m]: of the triangles; reaches (m,): from there to the farthest corner [m].
    """
    found = np.empty(len(points))
    for k in range(len(points)):
        p = (points[k, 0], points[k, 1], points[k, 2])
        nearest = np.inf
        for m in range(len(corners)):
            to_middle = norm((p[0] - middles[m, 0], p[1] - middles[m, 1], p[2] - middles[m, 2]))
            if to_middle - reaches[m] < nearest:
                t = corners[m]
                a = (t[0, 0], t[0, 1], t[0, 2])
                b = (t[1, 0], t[1, 1], t[1, 2])
                c = (t[2, 0], t[2, 1], t[2, 2])
                nearest = min(nearest, to_triangle(p, a, b, c))
        found[k] = nearest
    return found
