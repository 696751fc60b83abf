"""Geometry of a vertex against an edge; knows no force and no index."""

from granulab.contact.jit import inner, uncounted


@inner
def rotated(cos, sin, local):
    """A vector of a body's frame in the silo's frame."""
    return cos * local[0] - sin * local[1], sin * local[0] + cos * local[1]


@uncounted
def to_edge(rx, ry, ex, ey, inv_length2):
    """Vector to a point from the closest point of a closed segment [m].

    (rx, ry) is the point as seen from the segment's start, (ex, ey) the segment, inv_length2 =
    1/(ex^2 + ey^2) [1/m2].
    """
    along = min(max((rx * ex + ry * ey) * inv_length2, 0.0), 1.0)
    return rx - along * ex, ry - along * ey


@inner
def point_velocity(vx, vy, omega, arm):
    """Velocity of a body's point at `arm` from its centroid [m/s]: v + omega x arm."""
    return vx - omega * arm[1], vy + omega * arm[0]


@inner
def cross(a, b):
    """The out-of-plane component of a x b."""
    return a[0] * b[1] - a[1] * b[0]
