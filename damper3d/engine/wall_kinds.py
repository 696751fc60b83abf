"""What a wall is like, by the kind of walls, chosen when compiled.

Each name stands for the kernel that goes with the walls it is given: state.Walls, flat ones and a
round one that move as one enclosure, or quasistatic.shells.Shells, each of which moves by itself.
They are inlined by the compiler's back end, as contact.jit.inlined: numba's own inlining (as
in damper3d.engine.kinds) loses stores to fields of `walls` in the loops that call these.
"""

from typing import Any

import numpy as np
from numba.extending import overload

from damper3d.engine.geometry import with_cylinder, with_plane
from damper3d.engine.shells import Shells, gap_to_shell, with_shell
from granulab.contact.jit import inlined_inner, uncounted


def put_wall(spheres, walls, w, shift, speed):
    """Where wall w is and how fast it moves, in the last row; shift and speed: the enclosure's."""


def gap_to_wall(walls, x, w, i, shift):
    """Gap between wall w and the ball of row i of x, its radius the fourth number [m]."""


def radius_at_wall(walls, w, radius):
    """The reduced radius of a sphere against wall w [m]."""


def with_wall(walls, w, n_contacts, block):
    """Geometry of contacts with wall w in the first lanes of a block; see engine.geometry."""


def are_shells(walls):
    """Whether the walls, of this type, move each by itself."""
    return getattr(walls, "instance_class", None) is Shells


_INLINED: Any = {"_nrt": False, "forceinline": True, "error_model": "numpy", "noalias": True}


@overload(put_wall, jit_options=_INLINED)
def _put_wall(spheres, walls, w, shift, speed):
    if are_shells(walls):
        return lambda spheres, walls, w, shift, speed: _put_shell(spheres, walls, w)
    return lambda spheres, walls, w, shift, speed: _put_enclosure(spheres, shift, speed)


@overload(gap_to_wall, jit_options=_INLINED)
def _gap_to_wall(walls, x, w, i, shift):
    if are_shells(walls):
        return lambda walls, x, w, i, shift: gap_to_shell(walls, x, w, i)
    return lambda walls, x, w, i, shift: _gap_in_enclosure(walls, x, w, i, shift)


@overload(radius_at_wall, jit_options=_INLINED)
def _radius_at_wall(walls, w, radius):
    if are_shells(walls):
        return lambda walls, w, radius: radius
    return lambda walls, w, radius: _radius_in_enclosure(walls, w, radius)


@overload(with_wall, jit_options=_INLINED)
def _with_wall(walls, w, n_contacts, block):
    if are_shells(walls):
        return lambda walls, w, n_contacts, block: with_shell(walls.line[w], n_contacts, block)
    return lambda walls, w, n_contacts, block: _in_enclosure(walls, w, n_contacts, block)


@inlined_inner
def _put_enclosure(spheres, shift, speed):
    last = len(spheres.inverse_mass)
    for c in range(3):
        spheres.position[last, c], spheres.velocity[last, c] = shift[c], speed[c]


@inlined_inner
def _put_shell(spheres, walls, w):
    """Also notes the force so far, so that the servo knows that of this step."""
    last = len(spheres.inverse_mass)
    walls.before[w] = walls.force[w, 2]
    for c in range(3):
        spheres.position[last, c], spheres.velocity[last, c] = walls.place[w, c], walls.speed[w, c]


@uncounted
def _gap_in_enclosure(walls, x, w, i, shift):
    px, py, pz = x[i, 0] - shift[0], x[i, 1] - shift[1], x[i, 2] - shift[2]
    if w < len(walls.planes):
        plane = walls.planes[w]
        return plane[0] * px + plane[1] * py + plane[2] * pz - plane[3] - x[i, 3]
    return walls.radius - np.sqrt(px * px + py * py) - x[i, 3]


@uncounted
def _radius_in_enclosure(walls, w, radius):
    """With half the cylinder's curvature, mean of 1/r and 1/r - 1/R, where asked: r D/(D - r)."""
    if walls.curved and w == len(walls.planes):
        return 2.0 * radius * walls.radius / (2.0 * walls.radius - radius)
    return radius


@inlined_inner
def _in_enclosure(walls, w, n_contacts, block):
    if w < len(walls.planes):
        with_plane(walls.planes[w], n_contacts, block)
    else:
        with_cylinder(walls.radius, n_contacts, block)
