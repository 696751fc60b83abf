"""The outer and the inner list of vertex-edge pairs, and the slips that their springs hold."""

import numpy as np

from granulab.contact.jit import inner
from granulab.contact.laws import tangential_energy
from granulab.contact.reduced import reduced_mass
from silo2d.engine.cells import note_positions
from silo2d.engine.geometry import to_edge
from silo2d.engine.pair_law import outer_law
from silo2d.engine.state import (
    BOUNDING_RADIUS,
    DONE,
    EDGE_X,
    EDGE_Y,
    FIRST,
    FRICTION,
    INNER,
    INNER_LIST,
    INNER_SEARCHES,
    INV_LENGTH2,
    INV_MASS,
    MAX_VERTICES,
    N_CORNERS,
    N_EDGES,
    OUTER,
    OUTER_FULL,
    OUTER_LIST,
    OUTER_SEARCHES,
    PAIRS,
    PARTICLE_INNER,
    PARTICLE_OUTER,
    PARTICLE_PAIRS,
    PARTICLE_PARTICLE,
    PARTICLE_WALL,
    SPHERORADIUS,
    TOO_DEEP,
    VERTEX_X,
    VERTEX_Y,
    WALL_KEY,
    X,
    Y,
)

DEEPEST = 0.5  # overlap over cutoff; much beyond it a vertex would pass through an edge


@inner
def find_outer(bodies, local, vertices, pairs, outer, counts):
    """Make the outer list: vertex-edge pairs of the pairs of bodies, both ways."""
    n_old = counts[OUTER]
    for c in range(n_old):
        outer.old_key[c], outer.old_slip[c] = outer.key[c], outer.slip[c]
    n = np.int64(0)
    n_particle = 0
    for p in range(counts[PAIRS]):
        i, j = pairs[p, 0], pairs[p, 1]
        if dropped(bodies, i) or (p < counts[PARTICLE_PAIRS] and dropped(bodies, j)):
            continue
        most = bodies.layout[i, N_CORNERS] * bodies.layout[j, N_EDGES]
        most += bodies.layout[j, N_CORNERS] * bodies.layout[i, N_EDGES]
        if n + most >= len(outer.key):
            # The old list goes back, so that the search can be made again with more capacity.
            for c in range(n_old):
                outer.key[c], outer.slip[c] = outer.old_key[c], outer.old_slip[c]
            return OUTER_FULL
        n = find_vertex_edge_pairs(bodies, local, vertices, outer, i, j, n)
        # Two discs, which have one edge of no length each, would touch twice.
        if p >= counts[PARTICLE_PAIRS] or (
            bodies.layout[i, N_EDGES] > 1 or bodies.layout[j, N_EDGES] > 1
        ):
            n = find_vertex_edge_pairs(bodies, local, vertices, outer, j, i, n)
        if p < counts[PARTICLE_PAIRS]:
            n_particle = n
    counts[PARTICLE_OUTER], counts[OUTER] = n_particle, n
    for c in range(n):
        outer.slip[c] = 0.0
    outer.old_key[n_old] = -1  # ends the merge
    note_positions(bodies, counts, OUTER_LIST)
    counts[OUTER_SEARCHES] += 1
    return DONE


@inner
def dropped(bodies, i):
    """True for a particle that has left since the list of bodies was made."""
    return bodies.row[i, Y] < -bodies.size[i, BOUNDING_RADIUS]


@inner
def find_vertex_edge_pairs(bodies, local, vertices, outer, i, j, n):
    """Append the pairs of a vertex of i and an edge of j; return their new number."""
    radius_i, radius_j = bodies.size[i, SPHERORADIUS], bodies.size[j, SPHERORADIUS]
    skin = bodies.skin[i, OUTER_LIST] + bodies.skin[j, OUTER_LIST]
    far2 = (radius_i + radius_j + skin) ** 2
    circle2 = (bodies.size[j, BOUNDING_RADIUS] + radius_i + skin) ** 2
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
                outer.key[n] = base + a * MAX_VERTICES + b
                outer.vertex[n], outer.edge[n] = v, e
                outer.vertex_body[n], outer.edge_body[n] = i, j
                outer.mass[n], outer.cutoff[n], outer.depth[n] = mass, radius_i + radius_j, radius_i
                n += 1
    return n


@inner
def from_edge(local, vertices, v, e):
    """Vector to vertex v from the closest point of edge e [m], as of the last search."""
    rx = vertices[v, VERTEX_X] - vertices[e, VERTEX_X]
    ry = vertices[v, VERTEX_Y] - vertices[e, VERTEX_Y]
    return to_edge(rx, ry, vertices[e, EDGE_X], vertices[e, EDGE_Y], local[e, INV_LENGTH2])


@inner
def carry_over(outer, counts, account, laws):
    """Take over the slips of the previous list, by a merge of ascending keys.

    A pair that touches is in both lists, except where a particle was dropped or a wall was taken
    away: then friction takes what its spring held. laws: (particle-particle, particle-wall).
    """
    c = 0
    old = 0
    while outer.old_key[old] >= 0:
        if outer.old_slip[old] != 0.0:
            while c < counts[OUTER] and outer.key[c] < outer.old_key[old]:
                c += 1
            if c < counts[OUTER] and outer.key[c] == outer.old_key[old]:
                outer.slip[c] = outer.old_slip[old]
            elif outer.old_key[old] < WALL_KEY:
                lost = tangential_energy(outer_law(laws[0], old), (outer.old_slip[old],))
                account[PARTICLE_PARTICLE + FRICTION] += lost
            else:
                lost = tangential_energy(outer_law(laws[1], old), (outer.old_slip[old],))
                account[PARTICLE_WALL + FRICTION] += lost
        old += 1


@inner
def store_slips(outer, inner, counts):
    """Write the slips of the inner pairs back to the outer list."""
    for n in range(counts[INNER]):
        outer.slip[inner.outer[n]] = inner.slip[n]
    counts[PARTICLE_INNER], counts[INNER] = 0, 0


@inner
def measure_distances(local, vertices, outer, first, last):
    """Squared distances of outer pairs first ... last - 1: no branch, so that it is vectorised."""
    for c in range(np.uintp(first), np.uintp(last)):
        dx, dy = from_edge(local, vertices, outer.vertex[c], outer.edge[c])
        outer.distance2[c] = dx * dx + dy * dy


@inner
def release_springs(skin, outer, counts, account, laws):
    """Release the springs of pairs out of range: friction takes what they held.

    That happens only to a pair that comes apart by more than its skin within one step.
    laws: (particle-particle, particle-wall).
    """
    for c in range(counts[OUTER]):
        far = outer.cutoff[c] + skin[outer.vertex_body[c], INNER_LIST]
        far += skin[outer.edge_body[c], INNER_LIST]
        if outer.slip[c] != 0.0 and outer.distance2[c] >= far * far:
            held = (outer.slip[c],)
            if c >= counts[PARTICLE_OUTER]:
                lost = tangential_energy(outer_law(laws[1], c), held)
                account[PARTICLE_WALL + FRICTION] += lost
            else:
                lost = tangential_energy(outer_law(laws[0], c), held)
                account[PARTICLE_PARTICLE + FRICTION] += lost
            outer.slip[c] = 0.0


@inner
def find_inner(skin, local, outer, inner, counts):
    """Make the inner list: the outer pairs that touch or nearly do, for the force pass."""
    n = np.int64(0)
    n_particle = 0
    for c in range(counts[OUTER]):
        distance2, cutoff = outer.distance2[c], outer.cutoff[c]
        j, i = outer.vertex_body[c], outer.edge_body[c]
        far = cutoff + skin[j, INNER_LIST] + skin[i, INNER_LIST]
        if distance2 >= far * far:
            continue
        if distance2 < (1.0 - DEEPEST) * (1.0 - DEEPEST) * cutoff * cutoff:
            return TOO_DEEP
        v, e = outer.vertex[c], outer.edge[c]
        inner.outer[n] = c
        inner.vertex_body[n], inner.edge_body[n] = j, i
        inner.vertex_x[n], inner.vertex_y[n] = local[v, VERTEX_X], local[v, VERTEX_Y]
        inner.start_x[n], inner.start_y[n] = local[e, VERTEX_X], local[e, VERTEX_Y]
        inner.edge_x[n], inner.edge_y[n] = local[e, EDGE_X], local[e, EDGE_Y]
        inner.inv_length2[n], inner.slip[n] = local[e, INV_LENGTH2], outer.slip[c]
        inner.mass[n], inner.cutoff[n], inner.depth[n] = outer.mass[c], cutoff, outer.depth[c]
        n += 1
        if c < counts[PARTICLE_OUTER]:
            n_particle = n
    counts[PARTICLE_INNER], counts[INNER] = n_particle, n
    counts[INNER_SEARCHES] += 1
    return DONE
