"""Who can touch whom: three levels of lists, made anew when something has moved too far.

Level 3: pairs of bodies whose bounding circles are near, from linked cells.
Level 2: vertex-edge pairs that are near, from level 3.
Level 1: vertex-edge pairs that touch or nearly do, from level 2; the force pass works on these.

At each level every particle has room to move: pairs are listed that are closer than their reach
plus the room of both bodies, and no point of a particle may leave its room before the level is made
anew. So every pair that touches is in the list. The room follows the particle's speed: those that
fall get much, those that rest get little. All lists are in an order that does not depend on when
they were made, and pairs that do not touch add exact zeros: the same bits follow, whatever the
rooms.
"""

import numpy as np

from granulab.contact.jit import njit
from granulab.contact.reduced import reduced_mass
from silo2d.engine.door import give_door_room, place_door
from silo2d.engine.geometry import to_edge, turned
from silo2d.engine.pair_law import draw_near, hand_on, near_kt
from silo2d.engine.state import (
    ANGLE,
    BODY_LIST,
    BODY_SEARCHES,
    BOUNDING_RADIUS,
    CLOSE,
    CLOSE_LIST,
    CLOSE_SEARCHES,
    COS,
    DOOR,
    EDGE_X,
    EDGE_Y,
    FIRST,
    FRICTION,
    INV_LENGTH2,
    INV_MASS,
    LIVE,
    MAX_VERTICES,
    N_CORNERS,
    N_EDGES,
    NEAR,
    NEAR_LIST,
    NEAR_SEARCHES,
    PAIRS,
    PARTICLE_CLOSE,
    PARTICLE_NEAR,
    PARTICLE_PAIRS,
    PARTICLE_PARTICLE,
    PARTICLE_WALL,
    SIN,
    SPHERORADIUS,
    SPIN,
    STALE,
    VERTEX_X,
    VERTEX_Y,
    VX,
    VY,
    WALL_KEY,
    X,
    Y,
)

# Steps that a level should last, least room, and room for what the fastest particle may hand on to
# another, as a part of its speed: the fastest that were tried for an A4 discharge, whose cost
# changes by less than a tenth when any of them is halved or doubled.
CLOSE_STEPS, CLOSE_LEAST = 12, 4e-6  # [m]
NEAR_STEPS, NEAR_LEAST, NEAR_MOST = 80, 0.05e-3, 1.5e-3  # [m]
HANDED_ON = 0.1
DEEPEST = 0.5  # overlap over reach; much beyond it a vertex would pass through an edge

# Outcomes of a search.
DONE, PAIRS_FULL, NEAR_FULL, NOT_FINITE, TOO_DEEP = range(5)


@njit
def search(world):
    """Make the stale levels of the lists anew; returns DONE, or what stands in the way.

    A level whose particles have moved too far since it was made becomes stale as well.
    """
    bodies, local, vertices, counts = world.bodies, world.local, world.vertices, world.counts
    keep_close(world.near, world.close, counts)
    give_room(bodies, counts, world.time_step)
    steps = (np.float64(CLOSE_STEPS), np.float64(NEAR_STEPS))
    give_door_room(bodies, counts, world.time_step, steps, CLOSE_LEAST)
    if counts[STALE] < 2 and outgrown(bodies, counts, NEAR_LIST):
        counts[STALE] = 2
    if counts[STALE] >= 2:
        give_near_room(bodies, counts)
    if counts[STALE] == 2 and outgrown(bodies, counts, BODY_LIST):
        counts[STALE] = 3
    laws = (world.particle_law, world.wall_law)
    outcome = DONE
    if counts[STALE] >= 3:
        outcome = find_bodies(bodies, local, vertices, world.cells, counts)
    place_vertices(bodies, local, vertices, counts)
    if counts[DOOR] > 0:
        place_door(world)
    if outcome == DONE and counts[STALE] >= 2:
        outcome = find_near(bodies, local, vertices, world.cells.pairs, world.near, counts)
        if outcome == DONE:
            carry_over(world.near, counts, world.books, laws)
            draw_near(laws[0], laws[1], world.near, counts, len(bodies.row))
    if outcome == DONE:
        measure_distances(local, vertices, world.near, counts)
        let_go(bodies.room, world.near, counts, world.books, laws)
        outcome = find_close(bodies.room, local, world.near, world.close, counts)
    if outcome == DONE:
        hand_on(laws[0], world.close, counts)
        note_positions(bodies, counts, CLOSE_LIST)
        counts[STALE] = 0
    return outcome


@njit
def give_room(bodies, counts, dt):
    """Room at the level of close pairs [m], by the speed of each particle's fastest point."""
    row, room = bodies.row, bodies.room
    fastest = 0.0
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        speed = abs(row[i, VX]) + abs(row[i, VY])
        speed += bodies.size[i, BOUNDING_RADIUS] * abs(row[i, SPIN])
        room[i, CLOSE_LIST] = speed
        fastest = max(fastest, speed)
    most = NEAR_MOST * CLOSE_STEPS / NEAR_STEPS
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        path = CLOSE_STEPS * dt * (room[i, CLOSE_LIST] + HANDED_ON * fastest)
        room[i, CLOSE_LIST] = min(path + CLOSE_LEAST, most)


@njit
def give_near_room(bodies, counts):
    """Room at the level of near pairs [m], for as many more steps."""
    room = bodies.room
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        path = room[i, CLOSE_LIST] * NEAR_STEPS / CLOSE_STEPS
        room[i, NEAR_LIST] = min(path + NEAR_LEAST, NEAR_MOST)


@njit
def outgrown(bodies, counts, level):
    """Whether the room that a level has left is less than the level below it needs."""
    row, listed, room = bodies.row, bodies.listed, bodies.room
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        at = 3 * level
        far = abs(row[i, X] - listed[i, at]) + abs(row[i, Y] - listed[i, at + 1])
        far += bodies.size[i, BOUNDING_RADIUS] * abs(row[i, ANGLE] - listed[i, at + 2])
        if not far + room[i, level + 1] <= room[i, level]:  # true for NaN as well
            return True
    door = counts[DOOR]
    if door > 0 and level == NEAR_LIST:  # it leaves no list of bodies
        far = row[door, X] - listed[door, 3 * level]
        return far + room[door, level + 1] > room[door, level]
    return False


@njit
def note_positions(bodies, counts, level):
    """Note where the live particles are, now that a level is made."""
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        bodies.listed[i, 3 * level] = bodies.row[i, X]
        bodies.listed[i, 3 * level + 1] = bodies.row[i, Y]
        bodies.listed[i, 3 * level + 2] = bodies.row[i, ANGLE]
    if counts[DOOR] > 0:
        bodies.listed[counts[DOOR], 3 * level] = bodies.row[counts[DOOR], X]


@njit
def place_vertices(bodies, local, vertices, counts):
    """Vertices and edge vectors of all live particles, from position and direction."""
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        cos, sin = bodies.row[i, COS], bodies.row[i, SIN]
        for v in range(
            bodies.layout[i, FIRST], bodies.layout[i, FIRST] + bodies.layout[i, N_EDGES]
        ):
            dx, dy = turned(cos, sin, (local[v, VERTEX_X], local[v, VERTEX_Y]))
            ex, ey = turned(cos, sin, (local[v, EDGE_X], local[v, EDGE_Y]))
            vertices[v, VERTEX_X], vertices[v, VERTEX_Y] = (
                bodies.row[i, X] + dx,
                bodies.row[i, Y] + dy,
            )
            vertices[v, EDGE_X], vertices[v, EDGE_Y] = ex, ey


@njit
def from_edge(local, vertices, v, e):
    """Vector to vertex v from the closest point of edge e [m], as of the last search."""
    rx = vertices[v, VERTEX_X] - vertices[e, VERTEX_X]
    ry = vertices[v, VERTEX_Y] - vertices[e, VERTEX_Y]
    return to_edge(rx, ry, vertices[e, EDGE_X], vertices[e, EDGE_Y], local[e, INV_LENGTH2])


@njit
def find_bodies(bodies, local, vertices, cells, counts):
    """Level 3: particle-particle pairs in ascending order, then particle-wall pairs."""
    if not sort_into_cells(bodies, cells, counts):
        return NOT_FINITE
    n = np.int64(0)  # typed: numba would compile what takes it once more for a literal
    for k in range(counts[LIVE]):
        n = find_particles_near(bodies, cells, bodies.live[k], n)
        if n < 0:
            return PAIRS_FULL
    counts[PARTICLE_PAIRS] = n
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        for wall in range(len(bodies.live), len(bodies.row)):
            if n == len(cells.pairs):
                return PAIRS_FULL
            if wall_is_near(bodies, local, vertices, i, wall):
                cells.pairs[n, 0], cells.pairs[n, 1] = i, wall
                n += 1
    counts[PAIRS] = n
    note_positions(bodies, counts, BODY_LIST)
    counts[BODY_SEARCHES] += 1
    return DONE


@njit
def sort_into_cells(bodies, cells, counts):
    """Counting sort of the live particles into the cells; False if a position is not finite."""
    n_cells = cells.columns * cells.rows
    for c in range(n_cells + 1):
        cells.start[c] = 0
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        column = (bodies.row[i, X] - cells.left) / cells.size
        row = (bodies.row[i, Y] - cells.bottom) / cells.size
        if not (np.isfinite(column) and np.isfinite(row)):
            return False
        # A particle outside of the grid counts as in the cell at its border.
        column = min(max(column, 0.0), cells.columns - 1.0)
        row = min(max(row, 0.0), cells.rows - 1.0)
        cells.of_particle[i] = int(row) * cells.columns + int(column)
        cells.start[cells.of_particle[i]] += 1
    for c in range(n_cells):
        cells.start[c + 1] += cells.start[c]
    for k in range(counts[LIVE] - 1, -1, -1):
        i = bodies.live[k]
        # Filled from its end, the cell's entry walks down to its start.
        cells.start[cells.of_particle[i]] -= 1
        cells.particles[cells.start[cells.of_particle[i]]] = i
    return True


@njit
def find_particles_near(bodies, cells, i, n):
    """Append the pairs (i, j > i) from the 3 x 3 cells round i, j ascending; -1 where full."""
    row, pairs = bodies.row, cells.pairs
    cell_column, cell_row = (
        cells.of_particle[i] % cells.columns,
        cells.of_particle[i] // cells.columns,
    )
    first = n
    for r in range(max(cell_row - 1, 0), min(cell_row + 2, cells.rows)):
        begin = cells.start[r * cells.columns + max(cell_column - 1, 0)]
        end = cells.start[r * cells.columns + min(cell_column + 2, cells.columns)]
        for c in range(begin, end):
            j = cells.particles[c]
            far = bodies.size[i, BOUNDING_RADIUS] + bodies.size[j, BOUNDING_RADIUS]
            far += bodies.room[i, BODY_LIST] + bodies.room[j, BODY_LIST]
            dx, dy = row[j, X] - row[i, X], row[j, Y] - row[i, Y]
            if j <= i or dx * dx + dy * dy >= far * far:
                continue
            if n == len(pairs):
                return -1
            at = n
            while at > first and pairs[at - 1, 1] > j:
                pairs[at, 1] = pairs[at - 1, 1]
                at -= 1
            pairs[at, 1] = j
            pairs[n, 0] = i
            n += 1
    return n


@njit
def wall_is_near(bodies, local, vertices, i, wall):
    """Whether the bounding circle of particle i is near a wall's segment."""
    if bodies.layout[wall, N_EDGES] == 0:
        return False
    v = bodies.layout[wall, FIRST]
    rx, ry = bodies.row[i, X] - vertices[v, VERTEX_X], bodies.row[i, Y] - vertices[v, VERTEX_Y]
    dx, dy = to_edge(rx, ry, vertices[v, EDGE_X], vertices[v, EDGE_Y], local[v, INV_LENGTH2])
    far = bodies.size[i, BOUNDING_RADIUS] + bodies.room[i, BODY_LIST]
    return dx * dx + dy * dy < far * far


@njit
def find_near(bodies, local, vertices, pairs, near, counts):
    """Level 2: vertex-edge pairs of the pairs of bodies, both ways."""
    n_old = counts[NEAR]
    for c in range(n_old):
        near.old_key[c], near.old_slip[c] = near.key[c], near.slip[c]
    n = np.int64(0)
    n_particle = 0
    for p in range(counts[PAIRS]):
        i, j = pairs[p, 0], pairs[p, 1]
        if dropped(bodies, i) or (p < counts[PARTICLE_PAIRS] and dropped(bodies, j)):
            continue
        most = bodies.layout[i, N_CORNERS] * bodies.layout[j, N_EDGES]
        most += bodies.layout[j, N_CORNERS] * bodies.layout[i, N_EDGES]
        if n + most >= len(near.key):
            # The old list goes back, so that the search can be made again with more room.
            for c in range(n_old):
                near.key[c], near.slip[c] = near.old_key[c], near.old_slip[c]
            return NEAR_FULL
        n = find_vertices_near(bodies, local, vertices, near, i, j, n)
        n = find_vertices_near(bodies, local, vertices, near, j, i, n)
        if p < counts[PARTICLE_PAIRS]:
            n_particle = n
    counts[PARTICLE_NEAR], counts[NEAR] = n_particle, n
    for c in range(n):
        near.slip[c] = 0.0
    near.old_key[n_old] = -1  # ends the merge
    note_positions(bodies, counts, NEAR_LIST)
    counts[NEAR_SEARCHES] += 1
    return DONE


@njit
def dropped(bodies, i):
    """Whether particle i has left since the list of bodies was made."""
    return bodies.row[i, Y] < -bodies.size[i, BOUNDING_RADIUS]


@njit
def find_vertices_near(bodies, local, vertices, near, i, j, n):
    """Append the pairs of a vertex of i and an edge of j; returns their new number."""
    radius_i, radius_j = bodies.size[i, SPHERORADIUS], bodies.size[j, SPHERORADIUS]
    room = bodies.room[i, NEAR_LIST] + bodies.room[j, NEAR_LIST]
    far2 = (radius_i + radius_j + room) ** 2
    circle2 = (bodies.size[j, BOUNDING_RADIUS] + radius_i + room) ** 2
    mass = reduced_mass(bodies.row[i, INV_MASS], bodies.row[j, INV_MASS])
    low, high = np.int64(min(i, j)), np.int64(max(i, j))  # a key needs more than 32 bits
    base = ((low * len(bodies.row) + high) * 2 + (i > j)) * MAX_VERTICES * MAX_VERTICES
    if high >= len(bodies.live):
        base += WALL_KEY
    for a in range(bodies.layout[i, N_CORNERS]):
        v = bodies.layout[i, FIRST] + a
        dx, dy = vertices[v, VERTEX_X] - bodies.row[j, X], vertices[v, VERTEX_Y] - bodies.row[j, Y]
        if dx * dx + dy * dy > circle2:
            continue
        for b in range(bodies.layout[j, N_EDGES]):
            e = bodies.layout[j, FIRST] + b
            dx, dy = from_edge(local, vertices, v, e)
            if dx * dx + dy * dy < far2:
                near.key[n] = base + a * MAX_VERTICES + b
                near.vertex[n], near.edge[n] = v, e
                near.vertex_body[n], near.edge_body[n] = i, j
                near.mass[n], near.reach[n], near.depth[n] = mass, radius_i + radius_j, radius_i
                n += 1
    return n


@njit
def carry_over(near, counts, books, laws):
    """Slips from the previous list, by a merge of ascending keys.

    A pair that touches is in both lists, except where a particle was dropped or a wall was taken
    away: then friction takes what its spring held. laws: (particle-particle, particle-wall).
    """
    c = 0
    old = 0
    while near.old_key[old] >= 0:
        if near.old_slip[old] != 0.0:
            while c < counts[NEAR] and near.key[c] < near.old_key[old]:
                c += 1
            if c < counts[NEAR] and near.key[c] == near.old_key[old]:
                near.slip[c] = near.old_slip[old]
            elif near.old_key[old] < WALL_KEY:
                books[PARTICLE_PARTICLE + FRICTION] += (
                    0.5 * near_kt(laws[0], old) * near.old_slip[old] ** 2
                )
            else:
                books[PARTICLE_WALL + FRICTION] += (
                    0.5 * near_kt(laws[1], old) * near.old_slip[old] ** 2
                )
        old += 1


@njit
def keep_close(near, close, counts):
    """Write the slips of the close pairs back to the near list."""
    for n in range(counts[CLOSE]):
        near.slip[close.near[n]] = close.slip[n]
    counts[PARTICLE_CLOSE], counts[CLOSE] = 0, 0


@njit
def measure_distances(local, vertices, near, counts):
    """Squared distances of all near pairs: no branch, so that the compiler vectorises it."""
    for c in range(np.uintp(counts[NEAR])):
        dx, dy = from_edge(local, vertices, near.vertex[c], near.edge[c])
        near.distance2[c] = dx * dx + dy * dy


@njit
def let_go(room, near, counts, books, laws):
    """Springs of pairs that are not close any more: friction takes what they held.

    That happens only to a pair that comes apart by more than its room within one step.
    laws: (particle-particle, particle-wall).
    """
    for c in range(counts[NEAR]):
        far = near.reach[c] + room[near.vertex_body[c], CLOSE_LIST]
        far += room[near.edge_body[c], CLOSE_LIST]
        if near.slip[c] != 0.0 and near.distance2[c] >= far * far:
            wall = c >= counts[PARTICLE_NEAR]
            book = (PARTICLE_WALL if wall else PARTICLE_PARTICLE) + FRICTION
            kt = near_kt(laws[1], c) if wall else near_kt(laws[0], c)
            books[book] += 0.5 * kt * near.slip[c] ** 2
            near.slip[c] = 0.0


@njit
def find_close(room, local, near, close, counts):
    """Level 1: the near pairs that touch or nearly do, with what the force pass needs of them."""
    n = np.int64(0)
    n_particle = 0
    for c in range(counts[NEAR]):
        distance2, reach = near.distance2[c], near.reach[c]
        j, i = near.vertex_body[c], near.edge_body[c]
        far = reach + room[j, CLOSE_LIST] + room[i, CLOSE_LIST]
        if distance2 >= far * far:
            continue
        if distance2 < (1.0 - DEEPEST) * (1.0 - DEEPEST) * reach * reach:
            return TOO_DEEP
        v, e = near.vertex[c], near.edge[c]
        close.near[n] = c
        close.vertex_body[n], close.edge_body[n] = j, i
        close.vertex_x[n], close.vertex_y[n] = local[v, VERTEX_X], local[v, VERTEX_Y]
        close.start_x[n], close.start_y[n] = local[e, VERTEX_X], local[e, VERTEX_Y]
        close.edge_x[n], close.edge_y[n] = local[e, EDGE_X], local[e, EDGE_Y]
        close.inv_length2[n], close.slip[n] = local[e, INV_LENGTH2], near.slip[c]
        close.mass[n], close.reach[n], close.depth[n] = near.mass[c], reach, near.depth[c]
        n += 1
        if c < counts[PARTICLE_NEAR]:
            n_particle = n
    counts[PARTICLE_CLOSE], counts[CLOSE] = n_particle, n
    counts[CLOSE_SEARCHES] += 1
    return DONE
