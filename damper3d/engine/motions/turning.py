"""A rotation about the axis of the enclosure, which is a body of revolution: it stays where it is.

Its surface passes the particles: at a place p from the origin the walls move at (-w p_y, w p_x, 0)
for the angular velocity w, the rate of an angle that is itself a registered motion.
"""

from typing import Any, NamedTuple

from damper3d.engine.geometry import entry, put, vector
from damper3d.engine.motions import registry
from damper3d.engine.state import STEP, WALL_WORK
from granulab.contact.jit import inlined_inner, njit, specialised


class Turning(NamedTuple):
    """A rotation about z."""

    angle: Any  # a motion whose displacement is an angle [rad]


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
    """Add the work of walls that turn on the bed, from the forces in the lanes of a block."""


def _turns(world):
    """Return whether the enclosure of a type of world, as numba has it, turns."""
    shaker = world[world.fields.index("shaker")]
    return getattr(shaker, "instance_class", None) is Turning


@specialised(turn_wall)
def _turn_wall(world, n_contacts, block):
    if _turns(world):
        return lambda world, n_contacts, block: _turned(world, n_contacts, block)
    return lambda world, n_contacts, block: None


@specialised(count_turning)
def _count_turning(world, n_contacts, block):
    if _turns(world):
        return lambda world, n_contacts, block: _counted(world, n_contacts, block)
    return lambda world, n_contacts, block: None


@inlined_inner
def _turned(world, n_contacts, block):
    rate = registry.velocity(world.shaker.angle, world.counts[STEP] * world.time_step)
    for k in range(n_contacts):
        vx, vy = _passing(block, k, rate)
        x, y, z = vector(block.velocity, k)
        put(block.velocity, k, (x + vx, y + vy, z))


@inlined_inner
def _counted(world, n_contacts, block):
    rate, power = registry.velocity(world.shaker.angle, world.counts[STEP] * world.time_step), 0.0
    for k in range(n_contacts):
        if block.overlap[k] > 0.0:
            vx, vy = _passing(block, k, rate)
            power += block.push[entry(0, k)] * vx + block.push[entry(1, k)] * vy
    world.balance[WALL_WORK] -= world.time_step * power


@inlined_inner
def _passing(block, k, rate):
    """Return the velocity (x, y) of the wall where contact k touches it [m/s].

    The separation leads from the sphere to the enclosure's origin, the normal to the wall.
    """
    x = block.arm_i[k] * block.normal[entry(0, k)] - block.separation[entry(0, k)]
    y = block.arm_i[k] * block.normal[entry(1, k)] - block.separation[entry(1, k)]
    return -rate * y, rate * x
