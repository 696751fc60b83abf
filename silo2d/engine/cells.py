"""The list of bodies: pairs whose bounding circles are within range, from linked cells."""

import numpy as np

from granulab.contact.jit import inner
from silo2d.engine.geometry import to_edge
from silo2d.engine.state import (
    ANGLE,
    BODY_LIST,
    BODY_SEARCHES,
    BOUNDING_RADIUS,
    DONE,
    DOOR,
    EDGE_X,
    EDGE_Y,
    FIRST,
    INV_LENGTH2,
    LIVE,
    N_EDGES,
    NOT_FINITE,
    PAIRS,
    PAIRS_FULL,
    PARTICLE_PAIRS,
    VERTEX_X,
    VERTEX_Y,
    X,
    Y,
)


@inner
def find_bodies(bodies, local, vertices, cells, counts):
    """Make the list of bodies: pairs of particles in ascending order, then particle-wall pairs."""
    if not sort_into_cells(bodies, cells, counts):
        return NOT_FINITE
    n = np.int64(0)  # typed: numba would compile what takes it once more for a literal
    for k in range(counts[LIVE]):
        n = find_particle_pairs(bodies, cells, bodies.live[k], n)
        if n < 0:
            return PAIRS_FULL
    counts[PARTICLE_PAIRS] = n
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        for wall in range(len(bodies.live), len(bodies.row)):
            if n == len(cells.pairs):
                return PAIRS_FULL
            if wall_in_range(bodies, local, vertices, i, wall):
                cells.pairs[n, 0], cells.pairs[n, 1] = i, wall
                n += 1
    counts[PAIRS] = n
    note_positions(bodies, counts, BODY_LIST)
    counts[BODY_SEARCHES] += 1
    return DONE


@inner
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


@inner
def find_particle_pairs(bodies, cells, i, n):
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
            far += bodies.skin[i, BODY_LIST] + bodies.skin[j, BODY_LIST]
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


@inner
def wall_in_range(bodies, local, vertices, i, wall):
    """True where the bounding circle of particle i is within range of a wall's segment."""
    if bodies.layout[wall, N_EDGES] == 0:
        return False
    v = bodies.layout[wall, FIRST]
    rx, ry = bodies.row[i, X] - vertices[v, VERTEX_X], bodies.row[i, Y] - vertices[v, VERTEX_Y]
    dx, dy = to_edge(rx, ry, vertices[v, EDGE_X], vertices[v, EDGE_Y], local[v, INV_LENGTH2])
    far = bodies.size[i, BOUNDING_RADIUS]
    far += bodies.skin[i, BODY_LIST] + bodies.skin[wall, BODY_LIST]
    return dx * dx + dy * dy < far * far


@inner
def note_positions(bodies, counts, level):
    """Note where the live particles are, now that a level is made."""
    for k in range(counts[LIVE]):
        i = bodies.live[k]
        bodies.listed[i, 3 * level] = bodies.row[i, X]
        bodies.listed[i, 3 * level + 1] = bodies.row[i, Y]
        bodies.listed[i, 3 * level + 2] = bodies.row[i, ANGLE]
    if counts[DOOR] > 0:
        bodies.listed[counts[DOOR], 3 * level] = bodies.row[counts[DOOR], X]
