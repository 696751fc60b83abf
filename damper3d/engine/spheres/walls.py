"""The list of wall contacts: the spheres that touch a wall or nearly do, wall by wall."""

import numpy as np

from damper3d.engine.neighbours import DEEPEST, DONE, TOO_DEEP, WALL_FULL, adapt, copy_rows
from damper3d.engine.state import (
    DAMPING,
    HERTZ,
    LANES,
    MASS,
    N_HISTORY,
    RADIUS_I,
    STALE_WALL,
    STEP,
    WALL,
    WALL_MADE,
    WALL_SEARCHES,
    WALL_SKIN,
)
from damper3d.engine.walls import gap_to_wall, radius_at_wall
from granulab.contact.jit import inner


@inner
def search_walls(world, shift):
    """The list of wall contacts, wall by wall."""
    walls, wall, counts, lengths = world.walls, world.wall, world.counts, world.lengths
    adapt(counts, lengths, WALL_SKIN, WALL_MADE, world.cells.largest)
    store_wall_history(wall, walls, counts)
    n = np.int64(0)
    for w in range(len(walls.force)):
        walls.first[w] = n
        n = contacts_of_wall(
            wall, walls, world.spheres, world.wall_law, lengths[WALL_SKIN], shift, w, 0,
            len(world.spheres.inverse_mass), n,
        )  # fmt: skip
        if n < 0:
            return WALL_FULL if n == -1 else TOO_DEEP
    walls.first[len(walls.force)] = counts[WALL] = n
    counts[WALL_SEARCHES] += 1
    counts[STALE_WALL] = 0
    counts[WALL_MADE] = counts[STEP]
    copy_rows(wall.place, world.spheres.position)
    for c in range(3):
        wall.drift[c] = shift[c]
    return DONE


@inner
def store_wall_history(wall, walls, counts):
    """Put the histories of the wall contacts back into the walls' own table."""
    if counts[WALL] > 0:
        for w in range(len(walls.force)):
            for n in range(walls.first[w], walls.first[w + 1]):
                for h in range(N_HISTORY):
                    walls.history[w, wall.i[n], h] = wall.history[n, h]
    counts[WALL] = 0
    walls.first[:] = 0


@inner
def contacts_of_wall(wall, walls, spheres, law, skin, shift, w, begin, end, n):
    """Append those of the spheres begin ... end - 1 that touch wall w or nearly do; the new length.

    -1 if there is no room, -2 if a sphere is half outside.
    """
    x, n_spheres = spheres.position, len(spheres.inverse_mass)
    for i in range(begin, end):
        gap = gap_to_wall(walls, x, w, i, shift)
        if gap < skin or walls.history[w, i, DAMPING] >= 0.0:
            if not gap >= -2.0 * DEEPEST * x[i, 3]:
                return -2
            if n + LANES >= len(wall.i):
                return -1
            radius = radius_at_wall(walls, x, w, i, shift)
            wall.i[n], wall.j[n] = i, n_spheres  # the enclosure's row
            wall.reach[n] = wall.constants[n, RADIUS_I] = x[i, 3]
            wall.constants[n, HERTZ] = law.hertz * np.sqrt(radius)
            wall.constants[n, MASS] = 1.0 / spheres.inverse_mass[i]
            for h in range(N_HISTORY):
                wall.history[n, h] = walls.history[w, i, h]
            n += 1
    return n
