"""Neighbour search: three levels of Verlet lists, made again when a particle has moved too far.

Body list: pairs of bodies whose bounding circles are within range, from linked cells (cells.py).
Outer list: vertex-edge pairs within range, from the list of bodies (lists.py).
Inner list: vertex-edge pairs that touch or nearly do, from the outer one; the force pass works on
these.

At each level every particle has a skin: pairs are listed that are closer than their cutoff plus the
skins of both bodies, and no point of a particle may move farther than its skin before the level is
made again. So every pair that touches is in the list. The skin follows the particle's speed: it is
wide for those that fall and narrow for those that rest. All lists are in an order that does not
depend on when they were made, and pairs that do not touch add exact zeros: the same bits follow,
whatever the skins.
"""

import numpy as np

from granulab.contact.jit import inner
from silo2d.engine.beds.door import set_door_skins, update_door
from silo2d.engine.beds.vibration import place_walls
from silo2d.engine.cells import find_bodies, note_positions
from silo2d.engine.geometry import rotated
from silo2d.engine.lists import (
    carry_over,
    find_inner,
    find_outer,
    measure_distances,
    release_springs,
    store_slips,
)
from silo2d.engine.pair_law import copy_constants, draw_outer
from silo2d.engine.state import (
    ANGLE,
    BODY_LIST,
    BOUNDING_RADIUS,
    COS,
    DONE,
    DOOR,
    EDGE_X,
    EDGE_Y,
    FIRST,
    INNER,
    INNER_LIST,
    LIVE,
    N_EDGES,
    OMEGA,
    OUTER,
    OUTER_LIST,
    PARTICLE_INNER,
    SIN,
    STALE,
    VERTEX_X,
    VERTEX_Y,
    VX,
    VY,
    X,
    Y,
)

# Steps that a level should last, least and most skin over that of the particle at the level of
# bodies, and skin for what the fastest particle may pass on to another, as a part of its speed: the
# fastest that were tried for an A4 discharge, whose cost changes by less than a tenth when any of
# them is halved or doubled.
INNER_STEPS, INNER_LEAST = 12, 4e-3 / 3
OUTER_STEPS, OUTER_LEAST, OUTER_MOST = 80, 0.05 / 3, 0.5
DOOR_LEAST = 4e-6  # [m]
PASSED_ON = 0.1


@inner
def search(world):
    """Make the stale levels of the lists again; return DONE, or what stands in the way.

    A level whose particles have moved too far since it was made becomes stale as well.
    """
    outcome = begin_search(world)
    update_vertices(world, np.int64(0), world.counts[LIVE])
    if outcome == DONE:
        outcome = search_outer(world)
    if outcome == DONE:
        last = world.counts[OUTER]
        measure_distances(world.local, world.vertices, world.outer, np.int64(0), last)
        outcome = search_inner(world)
    return outcome


@inner
def begin_search(world):
    """Give the inner list up, and find the bodies that are near each other where it is time."""
    bodies, local, vertices, counts = world.bodies, world.local, world.vertices, world.counts
    store_slips(world.outer, world.inner, counts)
    set_inner_skins(bodies, counts, world.time_step)
    steps = (np.float64(INNER_STEPS), np.float64(OUTER_STEPS))
    set_door_skins(bodies, counts, world.time_step, steps, DOOR_LEAST)
    if counts[STALE] < 2 and outgrown(bodies, counts, OUTER_LIST):
        counts[STALE] = 2
    if counts[STALE] >= 2:
        set_outer_skins(bodies, counts)
    if counts[STALE] == 2 and outgrown(bodies, counts, BODY_LIST):
        counts[STALE] = 3
    place_walls(world, world.vibration)
    if counts[STALE] >= 3:
        return find_bodies(bodies, local, vertices, world.cells, counts)
    return DONE


@inner
def search_outer(world):
    """Make the outer list again where it is time, from vertices that are up to date."""
    bodies, counts, outer = world.bodies, world.counts, world.outer
    if counts[DOOR] > 0:
        update_door(world)
    if counts[STALE] < 2:
        return DONE
    pairs = world.cells.pairs
    outcome = find_outer(bodies, world.local, world.vertices, pairs, outer, counts)
    if outcome == DONE:
        carry_over(outer, counts, world.account, (world.particle_law, world.wall_law))
        draw_outer(world.particle_law, world.wall_law, outer, counts, len(bodies.row))
    return outcome


@inner
def search_inner(world):
    """Make the inner list, from the distances of all outer pairs."""
    bodies, counts, laws = world.bodies, world.counts, (world.particle_law, world.wall_law)
    release_springs(bodies.skin, world.outer, counts, world.account, laws)
    outcome = find_inner(bodies.skin, world.local, world.outer, world.inner, counts)
    if outcome == DONE:
        note_parts(world)
        copy_constants(laws[0], world.inner, counts)
        note_positions(bodies, counts, INNER_LIST)
        counts[STALE] = 0
    return outcome


@inner
def note_parts(world):
    """Note where the inner pairs of each part begin: by their first body, as they are listed."""
    inner, n = world.inner, np.int64(0)
    for which in range(2):
        last = world.counts[PARTICLE_INNER] if which == 0 else world.counts[INNER]
        for part in range(len(world.parts)):
            begins = world.parts[part]
            while n < last and min(inner.vertex_body[n], inner.edge_body[n]) < begins:
                n += 1
            world.first_pair[which, part] = n


@inner
def set_inner_skins(bodies, counts, dt):
    """Skins of the inner list [m], by the speed of each particle's fastest point."""
    row, skin = bodies.row, bodies.skin
    fastest = 0.0
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        speed = abs(row[i, VX]) + abs(row[i, VY])
        speed += bodies.size[i, BOUNDING_RADIUS] * abs(row[i, OMEGA])
        skin[i, INNER_LIST] = speed
        fastest = max(fastest, speed)
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        least = INNER_LEAST * skin[i, BODY_LIST]
        most = OUTER_MOST * skin[i, BODY_LIST] * INNER_STEPS / OUTER_STEPS
        path = INNER_STEPS * dt * (skin[i, INNER_LIST] + PASSED_ON * fastest)
        skin[i, INNER_LIST] = min(path + least, most)


@inner
def set_outer_skins(bodies, counts):
    """Skins of the outer list [m], for as many more steps."""
    skin = bodies.skin
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        path = skin[i, INNER_LIST] * OUTER_STEPS / INNER_STEPS
        least, most = OUTER_LEAST * skin[i, BODY_LIST], OUTER_MOST * skin[i, BODY_LIST]
        skin[i, OUTER_LIST] = min(path + least, most)


@inner
def outgrown(bodies, counts, level):
    """True where the skin that a level has left is less than the level below it needs."""
    row, listed, skin = bodies.row, bodies.listed, bodies.skin
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        at = 3 * level
        far = abs(row[i, X] - listed[i, at]) + abs(row[i, Y] - listed[i, at + 1])
        far += bodies.size[i, BOUNDING_RADIUS] * abs(row[i, ANGLE] - listed[i, at + 2])
        if not far + skin[i, level + 1] <= skin[i, level]:  # true for NaN as well
            return True
    door = counts[DOOR]
    if door > 0 and level == OUTER_LIST:  # it leaves no list of bodies
        far = row[door, X] - listed[door, 3 * level]
        return far + skin[door, level + 1] > skin[door, level]
    return False


@inner
def update_vertices(world, first, last):
    """Compute vertices and edges of the live particles that stand at first ... last - 1."""
    bodies, local, vertices = world.bodies, world.local, world.vertices
    for k in range(first, last):
        i = bodies.live[k]
        cos, sin = bodies.row[i, COS], bodies.row[i, SIN]
        for v in range(
            bodies.layout[i, FIRST], bodies.layout[i, FIRST] + bodies.layout[i, N_EDGES]
        ):
            dx, dy = rotated(cos, sin, (local[v, VERTEX_X], local[v, VERTEX_Y]))
            ex, ey = rotated(cos, sin, (local[v, EDGE_X], local[v, EDGE_Y]))
            vertices[v, VERTEX_X], vertices[v, VERTEX_Y] = (
                bodies.row[i, X] + dx,
                bodies.row[i, Y] + dy,
            )
            vertices[v, EDGE_X], vertices[v, EDGE_Y] = ex, ey
