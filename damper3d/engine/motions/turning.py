"""A rotation about the axis of the enclosure, which is a body of revolution: it stays where it is.

Its surface passes the particles: at a place p from the origin the walls move at (-w p_y, w p_x, 0)
for the angular velocity w = v/R, with v the velocity of a point at the distance R from the axis.
That is a registered motion, or a host's: its coordinate then is the arc x = R theta, its mass I/R^2
for a moment of inertia I, and the bed's force on it the torque over R.
"""

from typing import Any, NamedTuple

import numpy as np

from damper3d.engine.geometry import entry, put, vector
from damper3d.engine.motions import registry
from damper3d.engine.motions.host import Behind, Host, mobility
from damper3d.engine.state import STEP, WALL_WORK, World
from granulab.contact.jit import inlined_inner, njit, specialised


class Turning(NamedTuple):
    """A rotation about z."""

    arc: Any  # a motion [m] of a point at the distance R from the axis, or a Host
    radius: float  # R [m]
    torque: np.ndarray  # (1,) of the bed on the enclosure in this step [N m]


@njit
def displacement(motion, t):
    """Return the displacement of the enclosure [m]: none."""
    return 0.0


@njit
def velocity(motion, t):
    """Return its velocity [m/s]: none."""
    return 0.0


def turn_wall(world, n_contacts, block):
    """Add the velocity of walls that turn to that of the surfaces in the lanes of a block."""


def count_turning(world, n_contacts, block):
    """Add the work of walls that turn on the bed, from the forces in the lanes of a block.

    And from the couples by which its contacts resist rolling, which stand in the last row.
    """


def wall_spin(world):
    """Return the angular velocity about z of walls that turn [rad/s]; 0 of others."""


def turns(world):
    """Return whether the enclosure of a type of world, as numba has it, turns."""
    shaker = world[world.fields.index("shaker")]
    return getattr(shaker, "instance_class", None) is Turning


def twists(world):
    """Return whether it turns with a host, likewise."""
    if not turns(world):
        return False
    shaker = world[world.fields.index("shaker")]
    arc = shaker[shaker.fields.index("arc")]
    return getattr(arc, "instance_class", None) is Host


@inlined_inner
def without_walls(world):
    """Return the world of the particles among themselves.

    What takes it compiles once for all enclosures and shakers.
    """
    return World(*world[:-4], None, None, None, world.results)


def without_shaker(world):
    """Return the world with no more of its shaker than contacts with walls need.

    What takes it compiles once for all shakers that do not turn.
    """
    if isinstance(world.shaker, Turning):
        return world
    return world._replace(shaker=Behind(mobility(world.shaker)))


@specialised(without_shaker)
def _without_shaker(world):
    if turns(world):
        return lambda world: world
    return lambda world: _with_what_is_behind(world)


@inlined_inner
def _with_what_is_behind(world):
    return World(*world[:-2], Behind(mobility(world.shaker)), world.results)


@specialised(turn_wall)
def _turn_wall(world, n_contacts, block):
    if turns(world):
        return lambda world, n_contacts, block: _turned(world, n_contacts, block)
    return lambda world, n_contacts, block: None


@specialised(count_turning)
def _count_turning(world, n_contacts, block):
    if turns(world):
        return lambda world, n_contacts, block: _counted(world, n_contacts, block)
    return lambda world, n_contacts, block: None


@specialised(wall_spin)
def _wall_spin(world):
    if turns(world):
        return lambda world: _rate(world)
    return lambda world: 0.0


@inlined_inner
def _rate(world):
    now = world.counts[STEP] * world.time_step
    return registry.velocity(world.shaker.arc, now) / world.shaker.radius


@inlined_inner
def _turned(world, n_contacts, block):
    rate = _rate(world)
    for k in range(n_contacts):
        px, py = _place(block, k)
        x, y, z = vector(block.velocity, k)
        put(block.velocity, k, (x - rate * py, y + rate * px, z))


@inlined_inner
def _counted(world, n_contacts, block):
    torque, last = 0.0, len(world.spheres.inverse_mass)
    for k in range(n_contacts):
        if block.overlap[k] > 0.0:
            px, py = _place(block, k)
            torque += px * block.push[entry(1, k)] - py * block.push[entry(0, k)]
    torque += world.spheres.torque[last, 2]
    world.spheres.torque[last, 2] = 0.0
    world.balance[WALL_WORK] -= world.time_step * _rate(world) * torque
    world.shaker.torque[0] += torque


@inlined_inner
def _place(block, k):
    """Return where contact k lies from the axis (x, y) [m].

    The separation leads from the sphere to the enclosure's origin, the normal to the wall.
    """
    return (
        block.arm_i[k] * block.normal[entry(0, k)] - block.separation[entry(0, k)],
        block.arm_i[k] * block.normal[entry(1, k)] - block.separation[entry(1, k)],
    )
