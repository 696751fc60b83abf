"""What a step does in one way with balls and in another with clusters, chosen when compiled.

Each name stands for the kernel that goes with the kind of world it is given: state.World, whose
bodies are balls, or clusters.state.ClusterWorld, whose bodies have many spheres and turn them.
"""

from damper3d.engine import moving, neighbours, touching, wall_list
from damper3d.engine.clusters import motion, pairs, treatments, walls
from damper3d.engine.clusters.state import ClusterWorld
from damper3d.engine.state import CLOSE
from granulab.contact.jit import substituted


def search_pairs(world, shift):
    """Make the list of pairs of spheres anew; DONE, or what is wrong."""


def search_walls(world, shift):
    """Make the list of contacts with walls anew; DONE, or what is wrong."""


def find_pairs(world):
    """Let `touching` of the list of pairs name those that act; how many they are."""


def find_at_wall(world, w):
    """The same of the contacts with wall w."""


def move(world, shift):
    """One step of the bodies; the enclosure is displaced by shift after it."""


def mean_motion(world, shift, row):
    """Kinetic and potential energy, mean place in the enclosure and mean velocity, into a row."""


def _are_clusters(world):
    return getattr(world, "instance_class", None) is ClusterWorld


@substituted(search_pairs)
def _search_pairs(world, shift):
    if _are_clusters(world):
        return lambda world, shift: pairs.search_pairs(world, shift)
    return lambda world, shift: neighbours.search_pairs(world, shift)


@substituted(search_walls)
def _search_walls(world, shift):
    if _are_clusters(world):
        return lambda world, shift: walls.search_walls(world, shift)
    return lambda world, shift: wall_list.search_walls(world, shift)


@substituted(find_pairs)
def _find_pairs(world):
    if _are_clusters(world):
        return lambda world: treatments.acting_pairs(world)
    return lambda world: touching.touching_pairs(
        world.spheres, world.close, world.counts[CLOSE], world.block
    )


@substituted(find_at_wall)
def _find_at_wall(world, w):
    if _are_clusters(world):
        return lambda world, w: treatments.acting_at_wall(world, w)
    return lambda world, w: touching.touching_wall(
        world.spheres, world.walls, world.wall, w, world.block
    )


@substituted(move)
def _move(world, shift):
    if _are_clusters(world):
        return lambda world, shift: motion.move(world, shift)
    return lambda world, shift: moving.move(world, shift)


@substituted(mean_motion)
def _mean_motion(world, shift, row):
    if _are_clusters(world):
        return lambda world, shift, row: motion.mean_motion(world, shift, row)
    return lambda world, shift, row: moving.mean_motion(world, shift, row)
