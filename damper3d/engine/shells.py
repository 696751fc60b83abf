"""Thin walls of revolution about vertical axes, each of which moves by itself: state and geometry.

In the half-plane of its axis, at the distance rho from it and the height z, a wall is a straight
line: rho = R from z_0 to z_1 is the side of a container, z = z_0 from the axis to R a disc. The
nearest point to a centre (rho, z) is where both numbers are brought within those of the line: on
the line beside it, and beyond its end on the edge. So a sphere rolls from the inner face over the
rim without a jump of normal or overlap, and keeps its one contact with the wall, with its history.
A sphere touches a thin wall from either side.
"""

from typing import NamedTuple

import numpy as np

from damper3d.engine.geometry import vector, wall_contact
from damper3d.engine.lanes import separate, whole
from damper3d.engine.state import BLOCK
from damper3d.engine.touching import note_touching
from granulab.contact.jit import inlined, inner, uncounted

# The servo of one wall: which, whether it is on; its target [N], viscosity [N s/m], speed limit.
WALL, ON, TARGET, VISCOSITY, FASTEST = range(5)
N_SERVO = 5


class Shells(NamedTuple):
    """Walls that move each by itself; `first`, `force` and `history` as in engine.state.Walls."""

    line: np.ndarray  # (n, 4) least and largest rho, least and largest z, at the start [m]
    place: np.ndarray  # (n, 4) displacement [m]
    speed: np.ndarray  # (n, 4) velocity [m/s]
    listed: np.ndarray  # (n, 4) displacement when the list of contacts was made [m]
    servo: np.ndarray  # (N_SERVO,)
    before: np.ndarray  # (n,) the vertical entry of `force` when a step began [N]
    first: np.ndarray
    force: np.ndarray
    history: np.ndarray


@uncounted
def nearest_on(line, separation):
    """From a centre to the nearest point of a wall: outwards, up, and the distance [m].

    separation: of the wall's origin from the centre [m]; also the centre's distance from the axis.
    """
    x, y, z = separation
    away = np.sqrt(x * x + y * y)
    out = min(max(away, line[0]), line[1]) - away
    up = min(max(-z, line[2]), line[3]) + z
    return out, up, np.sqrt(out * out + up * up), away


@uncounted
def gap_to_shell(walls, x, w, i):
    """Gap between wall w and the ball of row i of x, its radius the fourth number [m]."""
    place = walls.place
    separation = place[w, 0] - x[i, 0], place[w, 1] - x[i, 1], place[w, 2] - x[i, 2]
    return nearest_on(walls.line[w], separation)[2] - x[i, 3]


@inlined
def with_shell(line, n_contacts, block):
    """Geometry of the contacts of spheres with a wall, in the first lanes of a block."""
    for k in range(np.uintp(n_contacts)):
        x, y, z = vector(block.separation, k)
        out, up, distance, away = nearest_on(line, (x, y, z))
        far = max(distance, 1e-300)
        outwards = -out / (far * max(away, 1e-300))
        wall_contact((outwards * x, outwards * y, up / far), distance, block, k)


@inlined
def touching_shell(spheres, walls, contacts, w, block):
    """How many of the contacts with wall w touch; `touching` names them (engine.touching)."""
    found = np.int64(0)
    for begin in range(walls.first[w], walls.first[w + 1], BLOCK):
        n = min(walls.first[w + 1] - begin, BLOCK)
        separate(spheres, contacts, begin, n, block)
        for k in range(np.uintp(whole(n))):
            distance = nearest_on(walls.line[w], vector(block.separation, k))[2]
            block.clearance[k] = distance - contacts.reach[np.uintp(begin) + k]
        found = note_touching(contacts, begin, n, block, found)
    return found


@inner
def depths_at_shell(world, w, n_touching):
    """How deep the touching contacts of wall w are, into scratch.depth [m]."""
    contacts, x = world.wall, world.spheres.position
    for t in range(n_touching):
        n = contacts.touching[t]
        gap = gap_to_shell(world.walls, x, w, np.int64(contacts.i[n]))
        world.scratch.depth[t] = max(-gap, 0.0)
