"""Walls and particles of a case in a pymunk space: for filling, and for the baseline."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from silo2d.case.case import GRAVITY
from silo2d.case.outline import Outline
from silo2d.case.shape import Shape

if TYPE_CHECKING:
    import pymunk


class Surface(NamedTuple):
    """Surface of a shape; a contact has the product of two shapes' numbers."""

    friction: float
    elasticity: float


class Placed(NamedTuple):
    """A wall or particle in a space."""

    body: "pymunk.Body"
    shape: "pymunk.Shape"


SMOOTH = Surface(0.0, 0.0)


def empty_space(iterations: int, slop: float) -> "pymunk.Space":
    """A space with gravity; slop is the overlap [m] that is left alone."""
    import pymunk

    space = pymunk.Space()
    space.gravity = 0.0, -GRAVITY
    space.iterations = iterations
    space.collision_slop = slop
    return space


def add_walls(space: "pymunk.Space", segments: np.ndarray, surface: Surface) -> list[Placed]:
    """Walls with end points (w, 2, 2) [m], without thickness, each on a body of its own."""
    import pymunk

    walls = []
    for start, end in segments.tolist():
        body = pymunk.Body(body_type=pymunk.Body.STATIC)
        wall = pymunk.Segment(body, start, end, radius=0.0)
        wall.friction, wall.elasticity = surface
        space.add(body, wall)
        walls.append(Placed(body, wall))
    return walls


def add_particle(
    space: "pymunk.Space",
    shape: Shape,
    surface_density: float,
    pose: list[float],
    surface: Surface,
    skin: float = 0.0,
) -> Placed:
    """A particle at x, y [m], angle [rad]: the core with the spheroradius round it.

    Mass and moment are those of the rounded outline; the skin [m] adds to the size, not to them.
    """
    import pymunk

    body = pymunk.Body(surface_density * shape.area, surface_density * shape.polar_moment)
    body.position, body.angle = (pose[0], pose[1]), pose[2]
    radius = shape.spheroradius + skin
    placed: pymunk.Shape
    if shape.is_disc:
        placed = pymunk.Circle(body, radius)
    else:
        placed = pymunk.Poly(body, shape.core.tolist(), radius=radius)
    placed.friction, placed.elasticity = surface
    space.add(body, placed)
    return Placed(body, placed)


def strays(outline: Outline, positions: np.ndarray) -> int:
    """Number of positions (n, 2) [m] that are outside the silo."""
    from shapely import contains_xy

    return int(np.sum(~contains_xy(outline.inside, positions)))
