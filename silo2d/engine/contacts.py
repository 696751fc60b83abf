"""The contacts of a moment, with the forces that the next step applies; changes nothing."""

import numpy as np

from granulab.contact.jit import njit
from silo2d.engine.forces import contact_forces, edge_to_vertex, overlap_now
from silo2d.engine.geometry import turned
from silo2d.engine.pair_law import law_of
from silo2d.engine.state import BLOCK, CLOSE, COS, PARTICLE_CLOSE, SIN, X, Y

# Columns of what list_contacts gives.
POINT_X, POINT_Y, FORCE_X, FORCE_Y, NORMAL_X, NORMAL_Y, OVERLAP, SLIDES = range(8)


@njit
def list_contacts(row, close, forces, counts, laws, dt, bodies, numbers):
    """Write the contacts in the order of the close list, which is not stale; their number.

    bodies (n, 2) and numbers (n, 8), n at least the length of the close list, are written: the
    bodies of a contact, ascending, the point [m], the force on the second body [N], the normal
    towards it, the overlap [m], and 1 where the tangential spring is at its Coulomb limit.
    """
    found = np.int64(0)
    first, middle, last = np.int64(0), counts[PARTICLE_CLOSE], counts[CLOSE]
    found = list_class(row, close, forces, laws[0], first, middle, dt, bodies, numbers, found)
    return list_class(row, close, forces, laws[1], middle, last, dt, bodies, numbers, found)


@njit
def list_class(row, close, forces, law, first, last, dt, bodies, numbers, found):
    """Append the contacts of the pairs first ... last - 1, which are of one class."""
    for begin in range(first, last, BLOCK):
        n_pairs = min(last - begin, BLOCK)
        before = close.slip[begin : begin + n_pairs].copy()
        contact_forces(row, close, forces, law, begin, n_pairs, dt)
        for k in range(n_pairs):
            n = begin + k
            overlap = overlap_now(row, close, n)
            if overlap > 0.0:
                list_contact(row, close, n, overlap, bodies[found], numbers[found])
                own = law_of(law, n)
                limit = own.mu * own.kn / own.kt * overlap
                slides = abs(close.slip[n]) >= (1.0 - 1e-9) * limit  # but for rounding
                turn = 1.0 if close.edge_body[n] < close.vertex_body[n] else -1.0
                numbers[found, FORCE_X] = turn * forces.fx[k]
                numbers[found, FORCE_Y] = turn * forces.fy[k]
                numbers[found, SLIDES] = 1.0 if slides else 0.0
                found += 1
        close.slip[begin : begin + n_pairs] = before
    return found


@njit
def list_contact(row, close, n, overlap, pair, numbers):
    """Write bodies, point, normal and overlap of pair n."""
    j, i = close.vertex_body[n], close.edge_body[n]
    between = row[j, X] - row[i, X], row[j, Y] - row[i, Y]
    arm_v = turned(row[j, COS], row[j, SIN], (close.vertex_x[n], close.vertex_y[n]))
    dx, dy = edge_to_vertex(row, close, n, between, arm_v)
    distance = np.sqrt(dx * dx + dy * dy)
    nx, ny = dx / distance, dy / distance
    depth = close.depth[n] - 0.5 * overlap
    turn = 1.0 if i < j else -1.0  # the law's normal points to the vertex's body
    pair[0], pair[1] = min(i, j), max(i, j)
    numbers[POINT_X] = row[j, X] + arm_v[0] - depth * nx
    numbers[POINT_Y] = row[j, Y] + arm_v[1] - depth * ny
    numbers[NORMAL_X], numbers[NORMAL_Y] = turn * nx, turn * ny
    numbers[OVERLAP] = overlap
