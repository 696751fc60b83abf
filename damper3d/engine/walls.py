"""Walls: flat ones, then curved ones; they move as one enclosure, or each by itself.

What differs is chosen by type, when a kernel is compiled: the geometry of curved walls by the type
of `walls.surface`, which damper3d.engine.enclosures registers, where that of triangles has contacts
of its own way (enclosures/places.py); whether walls are driven each by itself by that of
`walls.drive`.
"""

from typing import NamedTuple

import numpy as np
from numba import types

from damper3d.engine.enclosures import nearest_of
from damper3d.engine.enclosures.cavity import Triangles
from damper3d.engine.enclosures.cells import Sides
from damper3d.engine.enclosures.enclosure import Round
from damper3d.engine.enclosures.lines import Lines
from damper3d.engine.enclosures.places import to_feature, touching_places
from damper3d.engine.enclosures.sphere import Ball
from damper3d.engine.geometry import note_touching, to_plane, vector, wall_contact
from damper3d.engine.laws.table import halo, hertz_of
from damper3d.engine.simd import separate, whole
from damper3d.engine.state import BLOCK, HERTZ, STALE_WALL, WALL_SKIN
from granulab.contact.jit import inlined, inlined_inner, inner, specialised

# The servo of one wall: which, whether it is on; its target [N], viscosity [N s/m], speed limit.
WALL, ON, TARGET, VISCOSITY, FASTEST = range(5)
N_SERVO = 5


class Drive(NamedTuple):
    """Motion of walls each of which moves by itself, at a constant velocity or held to a force."""

    place: np.ndarray  # (n, 4) displacement [m]
    speed: np.ndarray  # (n, 4) velocity [m/s]
    listed: np.ndarray  # (n, 4) displacement when the list of contacts was made [m]
    servo: np.ndarray  # (N_SERVO,)
    before: np.ndarray  # (n,) the vertical entry of the walls' force when a step began [N]


def put_back(walls, sphere: np.ndarray, wall: np.ndarray, histories: np.ndarray) -> None:
    """Give walls without a list the histories (n, N_HISTORY) of contacts with spheres (n,).

    wall (n,): the number of each wall, or of the feature where they are triangles.
    """
    if isinstance(walls.surface, Triangles):
        held = walls.surface.held
        held[:] = -1
        at = np.zeros(len(held), np.int64)
        for i, feature, history in zip(sphere, wall, histories, strict=True):
            held[i, at[i]], walls.history[at[i], i] = feature, history
            at[i] += 1
    else:
        walls.history[wall, sphere] = histories


def nearest(surface, wall, x, y, z):
    """Distance, direction and curvature of a curved wall; see enclosures.register_surface."""


def wall_shift(walls, w, shift):
    """Displacement (x, y, z) of wall w [m]; shift: the enclosure's."""


def place_wall(spheres, walls, w, shift, speed):
    """Let the last row of the spheres be at wall w; shift and speed: the enclosure's."""


def bend(world, w, first, last):
    """Let contacts first ... last - 1 know the curvature of wall w at their places.

    Where it is the same all over they know it from when they were listed.
    """


def with_wall(walls, contacts, w, begin, n_contacts, block):
    """Geometry of contacts of spheres with wall w in the first lanes of a block."""


def touching_wall(spheres, walls, contacts, w, first, last, block):
    """Let `touching` name, from `first` on, those of contacts first ... last - 1 that touch wall w.

    Returns where they end.
    """


def drive_walls(world):
    """One step of walls that move each by itself."""


def note_listed(world, margin):
    """Take half of the wall skin off the margins (n,), for walls that move each by itself."""


_EVENLY_CURVED = Round, Ball, Sides, Lines, Triangles  # surfaces of one curvature, or flat ones
_COMPILED = {}  # geometry of curved walls, by the type of their numbers


@specialised(nearest)
def _nearest(surface, wall, x, y, z):
    kind = surface.instance_class
    if kind not in _COMPILED:
        _COMPILED[kind] = inlined(nearest_of(kind))
    chosen = _COMPILED[kind]
    return lambda surface, wall, x, y, z: chosen(surface, wall, x, y, z)


def is_triangulated(walls):
    """Return whether walls of a type, as numba has it, are triangles."""
    return walls[walls.fields.index("surface")].instance_class is Triangles


def is_driven(walls):
    """Return whether walls of a type, as numba has it, move each by itself."""
    return not isinstance(walls[walls.fields.index("drive")], types.NoneType)


@specialised(wall_shift)
def _wall_shift(walls, w, shift):
    if is_driven(walls):
        return lambda walls, w, shift: (
            walls.drive.place[w, 0], walls.drive.place[w, 1], walls.drive.place[w, 2]
        )  # fmt: skip
    return lambda walls, w, shift: shift


@specialised(place_wall)
def _place_wall(spheres, walls, w, shift, speed):
    if is_driven(walls):
        return lambda spheres, walls, w, shift, speed: _place_driven(spheres, walls, w)
    return lambda spheres, walls, w, shift, speed: _place_enclosure(spheres, shift, speed)


@inlined_inner
def _place_enclosure(spheres, shift, speed):
    last = len(spheres.inverse_mass)
    for c in range(3):
        spheres.position[last, c], spheres.velocity[last, c] = shift[c], speed[c]


@inlined_inner
def _place_driven(spheres, walls, w):
    """Also notes the force so far, so that the servo knows that of this step."""
    last, drive = len(spheres.inverse_mass), walls.drive
    drive.before[w] = walls.force[w, 2]
    for c in range(3):
        spheres.position[last, c], spheres.velocity[last, c] = drive.place[w, c], drive.speed[w, c]


@inlined_inner
def distance_to_wall(walls, w, x, y, z):
    """Distance of a point in the frame of wall w from it [m]."""
    if w < len(walls.planes):
        plane = walls.planes[w]
        return plane[0] * x + plane[1] * y + plane[2] * z - plane[3]
    return nearest(walls.surface, w - len(walls.planes), x, y, z)[0]


@inlined
def gap_to_wall(walls, x, w, i, shift):
    """Gap between wall w and the sphere of row i of x, its radius the fourth number [m]."""
    s = wall_shift(walls, w, shift)
    return distance_to_wall(walls, w, x[i, 0] - s[0], x[i, 1] - s[1], x[i, 2] - s[2]) - x[i, 3]


@inner
def radius_at_wall(walls, x, w, i, shift):
    """Reduced radius of the sphere of row i of x against wall w [m].

    With half the sum of the wall's curvatures 1/D, where asked: the mean of 1/r - 1/R_1 and
    1/r - 1/R_2 is 1/r - 1/D, D the harmonic mean of R_1 and R_2.
    """
    radius = x[i, 3]
    if not walls.curved or w < len(walls.planes):
        return radius
    s = wall_shift(walls, w, shift)
    number = w - len(walls.planes)
    mean = nearest(walls.surface, number, x[i, 0] - s[0], x[i, 1] - s[1], x[i, 2] - s[2])[2]
    return radius if mean == np.inf else mean * radius / (mean - radius)


@inlined_inner
def hertz_at_wall(world, w, i, shift):
    """Hertz constant of sphere i against wall w, at the place of it that is nearest [N/m^1.5]."""
    walls, spheres, law = world.walls, world.spheres, world.wall_law
    own_radius = radius_at_wall(walls, spheres.position, w, i, shift) - halo(law)
    return hertz_of(law, i, len(spheres.inverse_mass)) * np.sqrt(own_radius)


@specialised(bend)
def _bend(world, w, first, last):
    surface = world[world.fields.index("walls")]
    surface = surface[surface.fields.index("surface")].instance_class
    if surface in _EVENLY_CURVED:
        return lambda world, w, first, last: None
    return lambda world, w, first, last: _bend_contacts(world, w, first, last)


@inner
def _bend_contacts(world, w, first, last):
    walls, contacts, x = world.walls, world.wall, world.spheres.position
    if walls.curved and w >= len(walls.planes):
        wall = x[len(x) - 1]
        shift = wall[0], wall[1], wall[2]
        for n in range(first, last):
            hertz = hertz_at_wall(world, w, contacts.i[n], shift)
            contacts.constants[n, HERTZ] = contacts.whole[n, 0] = hertz


@specialised(with_wall)
def _with_wall(walls, contacts, w, begin, n_contacts, block):
    if is_triangulated(walls):
        return lambda walls, contacts, w, begin, n_contacts, block: _with_places(
            walls.surface, contacts, begin, n_contacts, block
        )
    return lambda walls, contacts, w, begin, n_contacts, block: _with_one_wall(
        walls, w, whole(n_contacts), block
    )


@inlined_inner
def _with_places(surface, contacts, begin, n_contacts, block):
    for k in range(np.uintp(n_contacts)):
        feature = contacts.feature[contacts.touching[np.uintp(begin) + k]]
        x, y, z = vector(block.separation, k)
        distance, normal = to_feature(surface, feature, -x, -y, -z)
        wall_contact(normal, distance, block, k)


@inlined_inner
def _with_one_wall(walls, w, n_contacts, block):
    if w < len(walls.planes):
        plane = walls.planes[w]
        for k in range(np.uintp(n_contacts)):
            distance = to_plane(plane, vector(block.separation, k))
            wall_contact((-plane[0], -plane[1], -plane[2]), distance, block, k)
    else:
        for k in range(np.uintp(n_contacts)):
            x, y, z = vector(block.separation, k)
            distance, normal, _ = nearest(walls.surface, w - len(walls.planes), -x, -y, -z)
            wall_contact(normal, distance, block, k)


@inlined_inner
def clear_of_wall(walls, w, contacts, begin, n_contacts, block):
    """Note how far the contacts of a block are from touching wall w, from their separations."""
    if w < len(walls.planes):
        for k in range(np.uintp(n_contacts)):
            distance = to_plane(walls.planes[w], vector(block.separation, k))
            block.clearance[k] = distance - contacts.cutoff[np.uintp(begin) + k]
    else:
        for k in range(np.uintp(n_contacts)):
            x, y, z = vector(block.separation, k)
            distance = nearest(walls.surface, w - len(walls.planes), -x, -y, -z)[0]
            block.clearance[k] = distance - contacts.cutoff[np.uintp(begin) + k]


@specialised(touching_wall)
def _touching_wall(spheres, walls, contacts, w, first, last, block):
    if is_triangulated(walls):
        return lambda spheres, walls, contacts, w, first, last, block: touching_places(
            spheres, walls, contacts, first, last
        )
    return lambda spheres, walls, contacts, w, first, last, block: _touching_one_wall(
        spheres, walls, contacts, w, first, last, block
    )


@inlined_inner
def _touching_one_wall(spheres, walls, contacts, w, first, last, block):
    found = first
    for begin in range(first, last, BLOCK):
        n = min(last - begin, BLOCK)
        separate(spheres, contacts, begin, n, block)
        clear_of_wall(walls, w, contacts, begin, whole(n), block)
        found = note_touching(contacts, begin, n, block, found)
    return found


@specialised(drive_walls)
def _drive_walls(world):
    if is_driven(world[world.fields.index("walls")]):
        return lambda world: _drive(world)
    return lambda world: None


@inlined_inner
def _drive(world):
    """One step of the walls; marks the list of contacts where one has come too far for it."""
    drive, counts, dt = world.walls.drive, world.counts, world.time_step
    _keep_to_force(world.walls)
    margin = 0.5 * world.lengths[WALL_SKIN]
    for w in range(len(drive.place)):
        way = 0.0
        for c in range(3):
            drive.place[w, c] += dt * drive.speed[w, c]
            way += (drive.place[w, c] - drive.listed[w, c]) ** 2
        counts[STALE_WALL] |= not way <= margin * margin


@inlined_inner
def _keep_to_force(walls):
    """Let the servo choose the vertical velocity of its wall, from the force of this step.

    The servo's wall has no mass: it hangs on a dashpot and carries the target F,

        v = (P - F)/c,   |v| <= v_max,

    with P the upward force of the particles on it and c the viscosity. A dashpot and a dead load
    give back no energy, so that the servo is stable on any bed, as long as its steps are: c is far
    above the stiffness of the bed times the time step. It approaches its target in c over that
    stiffness, and where the bed gives way at a velocity v it lacks c v.
    """
    drive, servo = walls.drive, walls.drive.servo
    if servo[ON] > 0.0:
        w = int(servo[WALL])
        pushed = walls.force[w, 2] - drive.before[w]
        wanted = (pushed - servo[TARGET]) / servo[VISCOSITY]
        drive.speed[w, 2] = min(max(wanted, -servo[FASTEST]), servo[FASTEST])


@specialised(note_listed)
def _note_listed(world, margin):
    if is_driven(world[world.fields.index("walls")]):
        return lambda world, margin: _note_driven(world, margin)
    return lambda world, margin: None


@inlined_inner
def _note_driven(world, margin):
    """Half of the skin is left for the walls to move."""
    drive = world.walls.drive
    for b in range(len(margin)):
        margin[b] -= 0.5 * world.lengths[WALL_SKIN]
    for w in range(len(drive.place)):
        for c in range(3):
            drive.listed[w, c] = drive.place[w, c]
