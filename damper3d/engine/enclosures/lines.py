"""Thin walls of revolution about the axis, which spheres touch from either side.

In the half-plane of the axis, at the distance rho from it and the height z, a wall is a straight
line: rho = R from z_0 to z_1 is the side of a container, z = z_0 from the axis to R a disc. The
nearest point to a centre (rho, z) is where both numbers are brought within those of the line: on
the line next to it, and beyond its end on the edge. So a sphere rolls from the inner face over the
rim without a jump of normal or overlap, and keeps its one contact with the wall, with its history.
"""

from typing import NamedTuple

import numpy as np


class Lines(NamedTuple):
    """The lines of the walls."""

    line: np.ndarray  # (n, 4) least and largest rho, least and largest z [m]


def nearest_line(surface, wall, x, y, z):
    """Distance of a point from a thin wall, and what belongs to it; it counts as flat."""
    line = surface.line[wall]
    away = np.sqrt(x * x + y * y)
    out = min(max(away, line[0]), line[1]) - away
    up = min(max(z, line[2]), line[3]) - z
    distance = np.sqrt(out * out + up * up)
    far = max(distance, 1e-300)
    outwards = out / (far * max(away, 1e-300))
    return distance, (outwards * x, outwards * y, up / far), np.inf
