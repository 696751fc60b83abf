"""Specialisations of a step by the type of the world, chosen when compiled.

Each name stands for the kernel that goes with the world it is given: state.World, whose particles
are one sphere each (spheres/), or multisphere.state.ClusterWorld, whose particles are many spheres
and rotate (multisphere/).
"""

from damper3d.engine.multisphere import contact_models
from damper3d.engine.multisphere import motion as multisphere_motion
from damper3d.engine.multisphere import pairs as multisphere_pairs
from damper3d.engine.multisphere import walls as multisphere_walls
from damper3d.engine.multisphere.state import ClusterWorld
from damper3d.engine.spheres import motion, pairs, touching, walls
from damper3d.engine.state import CLOSE
from granulab.contact.jit import substituted


def search_pairs(world, shift):
    """Make the inner list of pairs of spheres again; DONE, or what is wrong."""


def search_walls(world, shift):
    """Make the list of contacts with walls again; DONE, or what is wrong."""


def find_pairs(world):
    """Let `touching` of the inner list name the pairs that act; return their number."""


def find_at_wall(world, w):
    """Let `touching` of the wall list name the contacts with wall w that act; their number."""


def move(world, shift):
    """Move the particles by one step; the enclosure is displaced by shift after it."""


def mean_motion(world, shift, row):
    """Write kinetic and potential energy, mean position in the enclosure and velocity to a row."""


def _of_many_spheres(world):
    return getattr(world, "instance_class", None) is ClusterWorld


@substituted(search_pairs)
def _search_pairs(world, shift):
    if _of_many_spheres(world):
        return lambda world, shift: multisphere_pairs.search_pairs(world, shift)
    return lambda world, shift: pairs.search_pairs(world, shift)


@substituted(search_walls)
def _search_walls(world, shift):
    if _of_many_spheres(world):
        return lambda world, shift: multisphere_walls.search_walls(world, shift)
    return lambda world, shift: walls.search_walls(world, shift)


@substituted(find_pairs)
def _find_pairs(world):
    if _of_many_spheres(world):
        return lambda world: contact_models.acting_pairs(world)
    return lambda world: touching.touching_pairs(
        world.spheres, world.close, world.counts[CLOSE], world.block
    )


@substituted(find_at_wall)
def _find_at_wall(world, w):
    if _of_many_spheres(world):
        return lambda world, w: contact_models.acting_at_wall(world, w)
    return lambda world, w: touching.touching_wall(
        world.spheres, world.walls, world.wall, w, world.block
    )


@substituted(move)
def _move(world, shift):
    if _of_many_spheres(world):
        return lambda world, shift: multisphere_motion.move(world, shift)
    return lambda world, shift: motion.move(world, shift)


@substituted(mean_motion)
def _mean_motion(world, shift, row):
    if _of_many_spheres(world):
        return lambda world, shift, row: multisphere_motion.mean_motion(world, shift, row)
    return lambda world, shift, row: motion.mean_motion(world, shift, row)
