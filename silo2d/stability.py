"""The largest stable time step of a set of shapes: two like grains face to face.

The stiffest thing that can happen between two grains is that their longest faces meet fully
aligned: each of the four corners touches the facing edge and the flank behind it, eight
vertex-edge pairs at once. Against a wall it is two pairs on a body that moves alone. Both
configurations are built for each shape, with all their modes: pushing, sliding and rocking.
"""

import numpy as np

from contact.laws import LinearLaw
from contact.timestep import highest_rate, stable_time_step
from silo2d.shape import Shape, ShapeSet


def largest_stable_step(
    shapes: ShapeSet, surface_density: float, grain_law: LinearLaw, wall_law: LinearLaw
) -> tuple[float, str]:
    """The largest stable time step [s] and the shape and configuration that set it."""
    found = []
    for shape in shapes.shapes:
        for law, pairs, against in ((grain_law, 4, "a like one"), (wall_law, 1, "a wall")):
            step = _face_step(shape, surface_density, law, pairs, with_partner=pairs == 4)
            found.append((step, f"shape {shape.name} face to face with {against}"))
    return min(found)


def _face_step(
    shape: Shape, surface_density: float, law: LinearLaw, pairs: int, with_partner: bool
) -> float:
    """Stable step with the longest face of a shape on a partner, `pairs` pairs at each end."""
    edges = np.roll(shape.core, -1, axis=0) - shape.core
    longest = int(np.argmax(np.linalg.norm(edges, axis=1)))
    tangent = edges[longest] / np.linalg.norm(edges[longest])
    normal = np.array([tangent[1], -tangent[0]])  # outwards: the outline is counter-clockwise
    ends = np.array([shape.core[longest], np.roll(shape.core, -1, axis=0)[longest]])
    points = ends + shape.spheroradius * normal
    # The partner is the same shape turned by half a turn about the middle of the face.
    partner = points - 2 * points.mean(axis=0)
    rows = []
    for point, other in zip(points, partner, strict=True):
        for direction in (normal, tangent):
            own = [*direction, point[0] * direction[1] - point[1] * direction[0]]
            theirs = [*-direction, -(other[0] * direction[1] - other[1] * direction[0])]
            rows.append([*own, *theirs] if with_partner else own)
    mass, inertia = surface_density * shape.area, surface_density * shape.polar_moment
    inverse = np.array([1 / mass, 1 / mass, 1 / inertia])
    if with_partner:
        inverse = np.tile(inverse, 2)
    reduced = mass / 2 if with_partner else mass
    stiffness = pairs * np.tile([law.kn, law.kt], 2)
    damping = pairs * reduced * np.tile([law.gamma_n, law.gamma_t], 2)
    jacobian = np.array(rows)
    return stable_time_step(
        highest_rate(jacobian, stiffness, inverse), highest_rate(jacobian, damping, inverse)
    )
