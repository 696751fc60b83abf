"""Specialisations of a step by the type of the particles, chosen when compiled.

Each name stands for the kernel that goes with the world it is given, by the type of its `shape`:
OneSphere, whose particles are spheres (spheres/), or ManySpheres, whose particles have many spheres
and rotate (multisphere/).
"""

from damper3d.engine.geometry import copy_rows, touching_pairs
from damper3d.engine.multisphere import contact_models, form
from damper3d.engine.multisphere import motion as multisphere_motion
from damper3d.engine.multisphere import pairs as multisphere_pairs
from damper3d.engine.multisphere.particles import SUM, ManySpheres
from damper3d.engine.spheres import motion, pairs
from damper3d.engine.walls import touching_wall
from granulab.contact.jit import specialised, substituted

# The search for neighbours (neighbours.py).


def note_positions(world):
    """Copy the positions of the particles, and their bounding radii, to the outer list's `now`."""


def first_sphere(shape, b):
    """Return the number of the first sphere of particle b; of one after the last, of all."""


def key_of(shape, n, i, j):
    """Return a number by which pairs of spheres of n particles ascend as they are listed."""


def note_ways(world):
    """Note how far the particles have come since the inner list; False if that is no number."""


def outer_skin(world):
    """Gap of the particles that the outer list shall hold [m]."""


def remember_pairs(world):
    """Remember what is known of the pairs of the outer list, as it is given up."""


def know_pairs(world, n):
    """Note what is known of the first n pairs of a new outer list."""


def measure_gaps(world, first, last):
    """Note the gaps of pairs first ... last - 1 of the outer list, where list_pairs takes them."""


def list_pairs(world, skin, left):
    """Fill the inner list with the pairs of spheres nearer than the skin; how many there are.

    -1 if there is no room, -2 if an overlap is too deep. `left`: the gap below which all particles
    are in the outer list [m].
    """


def list_spheres(world, seen):
    """Note where the particles are now, for the list that was just made."""


def place_near_walls(world, skin, shift):
    """Bring the spheres of particles nearer to a wall than the skin to their positions."""


# A step (forces.py, sampling.py, integrate.py).


def find_pairs(world, first, last):
    """Let `touching` of the inner list name, from `first` on, those of its pairs that act.

    Of pairs first ... last - 1; returns where they end.
    """


def alone(shape):
    """Return whether each pair acts as if it were alone."""


def find_at_wall(world, w, first, last):
    """Likewise of contacts first ... last - 1 of the wall list, which are with wall w."""


def move(world, shift, first, last):
    """Move particles first ... last - 1 by a step; the enclosure is displaced by shift after it."""


def mean_motion(world, shift, row):
    """Write kinetic and potential energy, mean position in the enclosure and velocity to a row."""


def _rotate(world):
    """Return whether the particles of a type of world have many spheres."""
    return _are_many(world[world.fields.index("shape")])


def _are_many(shape):
    return shape.instance_class is ManySpheres


@specialised(note_positions)
def _note_positions(world):
    if _rotate(world):
        return lambda world: copy_rows(world.outer.now, world.particles.position)
    return lambda world: copy_rows(world.outer.now, world.spheres.position)


@specialised(first_sphere)
def _first_sphere(shape, b):
    if _are_many(shape):
        return lambda shape, b: form.first_sphere(shape.form, b)
    return lambda shape, b: b


@specialised(key_of)
def _key_of(shape, n, i, j):
    if _are_many(shape):
        return lambda shape, n, i, j: form.key_of(shape.form, n, i, j)
    return lambda shape, n, i, j: pairs.key_of(n, i, j)


@specialised(note_ways)
def _note_ways(world):
    if _rotate(world):
        return lambda world: multisphere_pairs.note_ways(world)
    return lambda world: True


@specialised(outer_skin)
def _outer_skin(world):
    if _rotate(world):
        return lambda world: multisphere_pairs.outer_skin(world)
    return lambda world: pairs.outer_skin(world)


@specialised(remember_pairs)
def _remember_pairs(world):
    if _rotate(world):
        return lambda world: multisphere_pairs.remember_pairs(world)
    return lambda world: None


@specialised(know_pairs)
def _know_pairs(world, n):
    if _rotate(world):
        return lambda world, n: multisphere_pairs.know_pairs(world, n)
    return lambda world, n: pairs.know_pairs(world, n)


@specialised(measure_gaps)
def _measure_gaps(world, first, last):
    if _rotate(world):
        return lambda world, first, last: None
    return lambda world, first, last: pairs.measure_gaps(world, first, last)


@specialised(list_pairs)
def _list_pairs(world, skin, left):
    if _rotate(world):
        return lambda world, skin, left: multisphere_pairs.list_pairs(world, skin, left)
    return lambda world, skin, left: pairs.list_pairs(world, skin)


@specialised(list_spheres)
def _list_spheres(world, seen):
    if _rotate(world):
        return lambda world, seen: multisphere_motion.list_spheres(world, seen)
    return lambda world, seen: motion.note_seen(world, seen)


@specialised(place_near_walls)
def _place_near_walls(world, skin, shift):
    if _rotate(world):
        return lambda world, skin, shift: multisphere_motion.place_near_walls(world, skin, shift)
    return lambda world, skin, shift: None


@specialised(alone)
def _alone(shape):
    if _are_many(shape):
        return lambda shape: shape.treatment == SUM
    return lambda shape: True


@substituted(find_pairs)
def _find_pairs(world, first, last):
    if _rotate(world):
        return lambda world, first, last: contact_models.acting_pairs(world, first, last)
    return lambda world, first, last: touching_pairs(
        world.spheres, world.inner, first, last, world.block
    )


@substituted(find_at_wall)
def _find_at_wall(world, w, first, last):
    if _rotate(world):
        return lambda world, w, first, last: contact_models.acting_at_wall(world, w, first, last)
    return lambda world, w, first, last: touching_wall(
        world.spheres, world.walls, world.wall, w, first, last, world.block
    )


@substituted(move)
def _move(world, shift, first, last):
    if _rotate(world):
        return lambda world, shift, first, last: multisphere_motion.move(world, shift, first, last)
    return lambda world, shift, first, last: motion.move(world, shift, first, last)


@substituted(mean_motion)
def _mean_motion(world, shift, row):
    if _rotate(world):
        return lambda world, shift, row: multisphere_motion.mean_motion(world, shift, row)
    return lambda world, shift, row: motion.mean_motion(world, shift, row)
