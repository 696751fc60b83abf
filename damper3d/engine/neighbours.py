"""Neighbour search of spheres and multi-sphere particles: cells, results of a search, skins.

Cells are a cubic grid over the enclosure, in which the pairs of particles that are near are found.
Skins follow the speed, so that a list lasts for a few tens of steps whatever it is.
"""

from damper3d.engine.geometry import gap_of
from damper3d.engine.state import N_HISTORY, STEP
from granulab.contact.jit import uncounted

DONE, NEAR_FULL, CLOSE_FULL, WALL_FULL, NOT_FINITE, TOO_DEEP = range(6)
DEEPEST = 0.25  # overlap over the sum of the radii that is taken for a failure

# How many steps a list should last, and by how much its skin changes where it does not. Short
# lists are quick to pass through, long ones to make; the cost is flat about these.
_SHORT, _LONG = 12, 40
_GROW, _SHRINK = 1.25, 0.9
_LEAST, _MOST = 0.002, 0.03  # of the close skin over the largest radius


@uncounted
def adapt(counts, lengths, skin, made, largest):
    """Widen a skin whose list was short-lived, and narrow one whose list lasted long."""
    lasted = counts[STEP] - counts[made]
    if 0 < lasted < _SHORT:
        lengths[skin] = min(_GROW * lengths[skin], _MOST * largest)
    elif lasted > _LONG:
        lengths[skin] = max(_SHRINK * lengths[skin], _LEAST * largest)


@uncounted
def copy(to, what, n):
    """The first n numbers of an array, into another."""
    for k in range(n):
        to[k] = what[k]


@uncounted
def copy_histories(to, histories, n):
    """The first n histories, into others."""
    for k in range(n):
        for h in range(N_HISTORY):
            to[k, h] = histories[k, h]


@uncounted
def copy_rows(to, rows):
    """As many rows of four as there is room for."""
    for i in range(len(to)):
        for c in range(4):
            to[i, c] = rows[i, c]


@uncounted
def fill_cells(cells, x, n_spheres, shift):
    """Sort the spheres into cells; those outside the grid go into the nearest cell."""
    nx, ny, nz = cells.shape
    n_cells = nx * ny * nz
    cells.start[:] = 0
    for i in range(n_spheres):
        a = min(max(int((x[i, 0] - shift[0] - cells.origin[0]) / cells.size), 0), nx - 1)
        b = min(max(int((x[i, 1] - shift[1] - cells.origin[1]) / cells.size), 0), ny - 1)
        c = min(max(int((x[i, 2] - shift[2] - cells.origin[2]) / cells.size), 0), nz - 1)
        cells.of_sphere[i] = (c * ny + b) * nx + a
        cells.start[cells.of_sphere[i] + 1] += 1
    for cell in range(n_cells + 1):
        cells.start[cell + 1] += cells.start[cell]
    for i in range(n_spheres - 1, -1, -1):  # backwards: the spheres of a cell ascend
        cell = cells.of_sphere[i]
        cells.start[cell + 1] -= 1
        cells.spheres[cells.start[cell + 1]] = i


@uncounted
def pairs_of(near, cells, x, skin, i, n):
    """Append the near pairs (i, j > i) in ascending order; the new length, or -1 for no room.

    After fill_cells the spheres of a cell stand between its own entry of `start`, shifted by one,
    and the next.
    """
    nx, ny, nz = cells.shape
    cell = cells.of_sphere[i]
    a, b, c = cell % nx, (cell // nx) % ny, cell // (nx * ny)
    begin = n
    for cc in range(max(c - 1, 0), min(c + 2, nz)):
        for bb in range(max(b - 1, 0), min(b + 2, ny)):
            row = (cc * ny + bb) * nx
            first, last = row + max(a - 1, 0), row + min(a + 1, nx - 1)
            for k in range(cells.start[first + 1], cells.start[last + 2]):
                j = cells.spheres[k]
                if j > i and gap_of(x, i, j) < skin:
                    if n == len(near.j):
                        return -1
                    at = n  # insertion: a sphere has a handful of neighbours
                    while at > begin and near.j[at - 1] > j:
                        near.j[at] = near.j[at - 1]
                        at -= 1
                    near.i[n], near.j[at] = i, j
                    n += 1
    return n
