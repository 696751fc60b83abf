"""The search for spheres of clusters that touch a wall or nearly do, wall by wall."""

import numpy as np

from damper3d.engine.multisphere.active import list_active
from damper3d.engine.multisphere.motion import arm_of, note_seen
from damper3d.engine.neighbours import DONE, TOO_DEEP, WALL_FULL, adapt
from damper3d.engine.spheres.walls import contacts_of_wall, store_wall_history
from damper3d.engine.state import (
    HERTZ,
    MASS,
    STALE_WALL,
    STEP,
    WALL,
    WALL_MADE,
    WALL_SEARCHES,
    WALL_SKIN,
)
from damper3d.engine.walls import gap_to_wall, note_listed
from granulab.contact.jit import inner


@inner
def search_walls(world, shift):
    """The list of wall contacts; only bodies whose ball is near a wall are looked at."""
    walls, wall, counts, lengths = world.walls, world.wall, world.counts, world.lengths
    adapt(counts, lengths, WALL_SKIN, WALL_MADE, world.cells.largest)
    store_wall_history(wall, walls, counts)
    skin, size = lengths[WALL_SKIN], len(world.shape.offset)
    place_near_walls(world, skin, shift)
    leeway = world.wall_seen.leeway
    leeway[:] = np.inf
    n = np.int64(0)
    for w in range(len(walls.force)):
        walls.first[w] = n
        for b in range(len(world.bodies.inverse_mass)):
            gap = gap_to_wall(world.walls, world.bodies.position, w, b, shift)
            leeway[b] = min(leeway[b], max(gap, skin))
            if gap < skin:
                begin, end = b * size, (b + 1) * size
                m = contacts_of_wall(
                    wall, walls, world.spheres, world.wall_law, skin, shift, w, begin, end, n
                )
                if m < 0:
                    return WALL_FULL if m == -1 else TOO_DEEP
                n = note_group(world, b, n, m)
    walls.first[len(walls.force)] = counts[WALL] = n
    counts[WALL_SEARCHES] += 1
    counts[STALE_WALL] = 0
    counts[WALL_MADE] = counts[STEP]
    note_seen(world.bodies, world.wall_seen)
    note_listed(world, leeway)
    for c in range(3):
        world.wall_seen.drift[c] = shift[c]
    list_active(world)
    return DONE


@inner
def note_group(world, b, begin, end):
    """Let wall contacts know their body, and their constants before a share is taken; the end."""
    wall, whole = world.wall, world.scratch.wall_whole
    for n in range(begin, end):
        wall.near[n] = b
        whole[n, 0], whole[n, 1] = wall.constants[n, HERTZ], wall.constants[n, MASS]
    return end


@inner
def place_near_walls(world, skin, shift):
    """Bring all spheres of the bodies that are near a wall to their places."""
    spheres, offset, bodies = world.spheres, world.shape.offset, world.bodies
    for b in range(len(bodies.inverse_mass)):
        for w in range(len(world.walls.force)):
            if gap_to_wall(world.walls, world.bodies.position, w, b, shift) < skin:
                for s in range(len(offset)):
                    r = arm_of(bodies.axes, offset, b, s)
                    for c in range(3):
                        spheres.position[b * len(offset) + s, c] = bodies.position[b, c] + r[c]
                break
