"""The largest stable time step of a set of shapes, from the stiffest configurations.

The stiffest contact between two particles is that their longest faces meet fully
aligned: each of the four corners touches the facing edge and the flank behind it, eight
vertex-edge pairs at once. Against a wall it is two pairs on a body that moves alone. Both are
built for each shape, with all their modes: pushing, sliding and rocking. A step beyond their limit
is unstable for any two particles that come to lie so.

In a heap a particle may be held on several faces at once. The bound for a like partner on every
face, all of them moving against it, is lower; but alignment so complete is rare, and contacts that
ring open and lose their energy: between the two bounds such a spot chatters at the level of 1e-5 of
what lifts a particle by its size, and discharge times do not change. It is reported with the limit,
so that those who need a heap free of it can take a smaller step.
"""

import math
from typing import NamedTuple

import numpy as np

from granulab.contact.laws import LinearLaw
from granulab.contact.restitution import linear_restitution
from granulab.contact.timestep import highest_rate, stable_time_step
from silo2d.case.shape import Shape, ShapeSet

USUAL_TIME_STEP = 5e-6  # [s] discharge times do not change between 2 and 10 us
RESTITUTION_OF_ELASTIC = 0.98  # [-] of one contact
_AT_A_CORNER = 3  # contacts of a disc


class Margin(NamedTuple):
    """Parts of the largest stable step: that a chosen one has, and up to which the usual one is."""

    part: float
    usual: float


# The shipped particles keep their energy to 0.4 % close to the limit. Of 200 silos of strangers
# (docs/results/own-silos.csv) 75 of 181 would have to be repeated so; elastic particles lose so
# little energy that the error of a longer step shows.
SHIPPED, OTHERS, ELASTIC = Margin(0.8, 1.0), Margin(0.6, 0.6), Margin(0.3, 0.3)


def largest_stable_step(
    shapes: ShapeSet, surface_density: float, particle_law: LinearLaw, wall_law: LinearLaw
) -> tuple[float, str]:
    """The largest stable time step [s] and the shape and configuration that set it."""
    found = []
    for shape in shapes.shapes:
        for law, pairs, against in ((particle_law, 4, "a like one"), (wall_law, 1, "a wall")):
            step = _face_step(shape, surface_density, law, pairs, with_partner=pairs == 4)
            found.append((step, f"shape {shape.name} face to face with {against}"))
    return min(found)


def margin_of(law: LinearLaw, reduced_mass: float, shipped: bool) -> Margin:
    """The margin of the time step of particles with a law, shipped or a stranger's own ones."""
    if linear_restitution(law.gamma_n, law.kn, reduced_mass) >= RESTITUTION_OF_ELASTIC:
        return ELASTIC
    return SHIPPED if shipped else OTHERS


def chosen_step(times_usual: float, limit: float, margin: Margin = SHIPPED) -> float:
    """A multiple of the usual time step [s], or a part of the limit rounded down to two digits."""
    if margin.usual * limit >= times_usual * USUAL_TIME_STEP:
        return times_usual * USUAL_TIME_STEP
    exponent = math.floor(math.log10(margin.part * limit)) - 1
    return math.floor(margin.part * limit / 10**exponent) * 10.0**exponent


def step_for_held_particles(
    shapes: ShapeSet, surface_density: float, particle_law: LinearLaw
) -> float:
    """The step [s] that is stable even where particles are held by like ones on all their faces."""
    return min(_held_step(shape, surface_density, particle_law) for shape in shapes.shapes)


def _held_step(shape: Shape, surface_density: float, law: LinearLaw) -> float:
    """Stable step with an aligned partner on every face, each moving against the particle.

    A partner that mirrors the particle's motion doubles the force of each spring on it. A disc is
    held by six.
    """
    rows = []
    for ends, normal, tangent in _faces(shape):
        for point in ends:
            touched = point + shape.spheroradius * normal
            for direction in (normal, tangent):
                torque = touched[0] * direction[1] - touched[1] * direction[0]
                rows.append([*direction, torque])
    mass, inertia = surface_density * shape.area, surface_density * shape.polar_moment
    n_ends = len(rows) // 2
    pairs = 1 if shape.is_disc else 4
    return _stable(
        np.array(rows),
        2 * pairs * np.tile([law.kn, law.kt], n_ends),
        2 * pairs * mass / 2 * np.tile([law.gamma_n, law.gamma_t], n_ends),
        np.array([1 / mass, 1 / mass, 1 / inertia]),
    )


def _stable(
    jacobian: np.ndarray, stiffness: np.ndarray, damping: np.ndarray, inverse_mass: np.ndarray
) -> float:
    return stable_time_step(
        highest_rate(jacobian, stiffness, inverse_mass),
        highest_rate(jacobian, damping, inverse_mass),
    )


def _faces(shape: Shape) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Ends (2, 2) [m] of the edges of the core, with outward normal and tangent (2,) of each.

    Of a disc: its centre (1, 2), in six directions.
    """
    if shape.is_disc:
        around = [(math.cos(k * math.pi / 3), math.sin(k * math.pi / 3)) for k in range(6)]
        return [(shape.core, np.array([c, s]), np.array([-s, c])) for c, s in around]
    after = np.roll(shape.core, -1, axis=0)
    found = []
    for start, end in zip(shape.core, after, strict=True):
        tangent = (end - start) / np.linalg.norm(end - start)
        # Outwards: the outline is counter-clockwise.
        found.append((np.array([start, end]), np.array([tangent[1], -tangent[0]]), tangent))
    return found


def _face_step(
    shape: Shape, surface_density: float, law: LinearLaw, pairs: int, with_partner: bool
) -> float:
    """Stable step with the longest face of a shape on a partner, `pairs` pairs at each end.

    A disc has one contact with another, and three where it meets the corner of a polygon or of two
    walls: that corner and the ends of both its edges.
    """
    pairs = _AT_A_CORNER if shape.is_disc else pairs
    ends, normal, tangent = max(_faces(shape), key=lambda face: np.linalg.norm(np.ptp(face[0], 0)))
    points = ends + shape.spheroradius * normal
    # The partner is the same shape rotated by 180 degrees about the middle of the face.
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
    stiffness = pairs * np.tile([law.kn, law.kt], len(ends))
    damping = pairs * reduced * np.tile([law.gamma_n, law.gamma_t], len(ends))
    return _stable(np.array(rows), stiffness, damping, inverse)
