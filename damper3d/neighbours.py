"""The search for contacts: cells, a list of near pairs, and lists of what touches or nearly does.

Near pairs are found with cells and kept for hundreds of steps; close ones are filtered from them
and kept for tens of steps. What matters is how pairs move against each other: the close list is
made anew when a sphere has left the mean motion of all by half the skin, so that a bed that flies
as one keeps its lists; the list of wall contacts when one has moved by its skin against the
enclosure. Skins follow the speed, so that a list lasts for a few tens of steps whatever it is.

Lists are in ascending order of the spheres' numbers. No force depends on when a list was made:
what does not touch adds exact zeros.
"""

import numpy as np

from contact.jit import uncounted
from damper3d.geometry import gap_of
from damper3d.state import (
    CLOSE,
    CLOSE_MADE,
    CLOSE_SEARCHES,
    CLOSE_SKIN,
    DAMPING,
    HERTZ,
    LANES,
    MASS,
    N_HISTORY,
    NEAR,
    NEAR_SEARCHES,
    NEAR_SKIN,
    NO_CONTACT,
    RADIUS_I,
    RADIUS_J,
    STALE_CLOSE,
    STALE_WALL,
    STEP,
    WALL,
    WALL_MADE,
    WALL_SEARCHES,
    WALL_SKIN,
)

DONE, NEAR_FULL, CLOSE_FULL, WALL_FULL, NOT_FINITE, TOO_DEEP = range(6)

# How many steps a list should last, and by how much its skin changes where it does not. Short
# lists are quick to pass through, long ones to make; the cost is flat about these.
_SHORT, _LONG = 12, 40
_NEAR_SHARE = 8.0  # near skin over close skin
_GROW, _SHRINK = 1.25, 0.9
_LEAST, _MOST = 0.002, 0.03  # of the close skin over the largest radius
_DEEPEST = 0.25  # overlap over the sum of the radii that is taken for a failure


@uncounted
def search(world, shift):
    """Make stale lists anew; DONE, or what is wrong."""
    counts = world.counts
    if counts[STALE_CLOSE]:
        outcome = search_pairs(world, shift)
        if outcome != DONE:
            return outcome
    if counts[STALE_WALL]:
        outcome = search_walls(world, shift)
        if outcome != DONE:
            return outcome
    return DONE


@uncounted
def search_pairs(world, shift):
    """The close list, after the near list where its reach is used up."""
    counts, lengths, spheres, near = world.counts, world.lengths, world.spheres, world.near
    store_history(near, world.close, counts)
    adapt(counts, lengths, CLOSE_SKIN, CLOSE_MADE, world.cells.largest)
    left = near_reach_left(spheres.position, near.place, lengths[NEAR_SKIN])
    if np.isnan(left):
        return NOT_FINITE
    if left < lengths[CLOSE_SKIN]:
        lengths[NEAR_SKIN] = _NEAR_SHARE * lengths[CLOSE_SKIN]
        outcome = search_near(world, lengths[NEAR_SKIN], shift)
        if outcome != DONE:
            return outcome
    outcome = filter_close(near, world.close, spheres, counts, lengths[CLOSE_SKIN])
    if outcome == DONE:
        counts[STALE_CLOSE] = 0
        counts[CLOSE_MADE] = counts[STEP]
    return outcome


@uncounted
def adapt(counts, lengths, skin, made, largest):
    """Widen a skin whose list was short-lived, and narrow one whose list lasted long."""
    lasted = counts[STEP] - counts[made]
    if 0 < lasted < _SHORT:
        lengths[skin] = min(_GROW * lengths[skin], _MOST * largest)
    elif lasted > _LONG:
        lengths[skin] = max(_SHRINK * lengths[skin], _LEAST * largest)


@uncounted
def store_history(near, close, counts):
    """Put the histories of the close list back into the near list."""
    for n in range(counts[CLOSE]):
        for h in range(N_HISTORY):
            near.history[close.near[n], h] = close.history[n, h]
    counts[CLOSE] = 0


@uncounted
def near_reach_left(x, place, skin):
    """The gap below which all pairs are in the near list, by how far the spheres have spread [m].

    NaN where a position is no longer a finite number.
    """
    n = len(place)
    a = b = c = 0.0
    for i in range(n):
        a += x[i, 0] - place[i, 0]
        b += x[i, 1] - place[i, 1]
        c += x[i, 2] - place[i, 2]
    a, b, c = a / n, b / n, c / n
    farthest = 0.0
    for i in range(n):
        dx, dy, dz = x[i, 0] - place[i, 0] - a, x[i, 1] - place[i, 1] - b, x[i, 2] - place[i, 2] - c
        square = dx * dx + dy * dy + dz * dz
        if not square <= farthest:
            farthest = square
    return skin - 2.0 * np.sqrt(farthest)


@uncounted
def search_near(world, skin, shift):
    """All pairs with a gap below the skin, with the histories of those known before."""
    near, spheres, counts = world.near, world.spheres, world.counts
    x, n_spheres = spheres.position, len(spheres.inverse_mass)
    fill_cells(world.cells, x, n_spheres, shift)
    n_old = counts[NEAR]
    copy(near.old_j, near.j, n_old)
    copy(near.old_first, near.first, n_spheres + 1)
    copy_histories(near.old_history, near.history, n_old)
    n = 0
    for i in range(n_spheres):
        near.first[i] = n
        begin = n
        n = pairs_of(near, world.cells, x, skin, i, n)
        if n < 0:
            # Nothing is lost: the caller makes room and comes back.
            copy(near.j, near.old_j, n_old)
            copy(near.first, near.old_first, n_spheres + 1)
            copy_histories(near.history, near.old_history, n_old)
            fill_i(near, n_spheres)
            return NEAR_FULL
        inherit(near, i, begin, n)
        note_constants(near, spheres, world.pair_law, i, begin, n)
    near.first[n_spheres] = n
    copy_rows(near.place, x)
    counts[NEAR] = n
    counts[NEAR_SEARCHES] += 1
    return DONE


@uncounted
def note_constants(near, spheres, law, i, begin, end):
    """What the law needs to know of the pairs of sphere i."""
    radius = spheres.position[:, 3]
    for n in range(begin, end):
        j = near.j[n]
        near.reach[n] = radius[i] + radius[j]
        near.hertz[n] = law.hertz * np.sqrt(radius[i] * radius[j] / near.reach[n])
        near.mass[n] = 1.0 / (spheres.inverse_mass[i] + spheres.inverse_mass[j])


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
def fill_i(near, n_spheres):
    """The first spheres of all pairs, from where the pairs of each begin."""
    for i in range(n_spheres):
        for n in range(near.first[i], near.first[i + 1]):
            near.i[n] = i


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


@uncounted
def inherit(near, i, begin, end):
    """Give the pairs of sphere i the histories that they had; both lists ascend."""
    old, old_end = near.old_first[i], near.old_first[i + 1]
    for n in range(begin, end):
        while old < old_end and near.old_j[old] < near.j[n]:
            old += 1
        if old < old_end and near.old_j[old] == near.j[n]:
            for h in range(N_HISTORY):
                near.history[n, h] = near.old_history[old, h]
        else:
            near.history[n, :] = 0.0
            near.history[n, DAMPING] = NO_CONTACT


@uncounted
def filter_close(near, close, spheres, counts, skin):
    """The close list: near pairs with a gap below the skin, or in contact so far."""
    x, n_near = spheres.position, counts[NEAR]
    gaps(near, x, n_near)
    n = 0
    for k in range(np.uintp(n_near)):
        if near.gap[k] < skin or near.history[k, DAMPING] >= 0.0:
            if n + LANES >= len(close.i):
                return CLOSE_FULL
            if near.gap[k] < -_DEEPEST * near.reach[k]:
                return TOO_DEEP
            close.i[n], close.j[n], close.near[n] = near.i[k], near.j[k], k
            close.reach[n] = near.reach[k]
            close.constants[n, RADIUS_I] = x[near.i[k], 3]
            close.constants[n, RADIUS_J] = x[near.j[k], 3]
            close.constants[n, HERTZ], close.constants[n, MASS] = near.hertz[k], near.mass[k]
            for h in range(N_HISTORY):
                close.history[n, h] = near.history[k, h]
            n += 1
    counts[CLOSE] = n
    counts[CLOSE_SEARCHES] += 1
    note_places(close, spheres)
    return DONE


@uncounted
def gaps(near, x, n_near):
    """The gaps of all near pairs; without a branch, so that it is vectorised."""
    for k in range(np.uintp(n_near)):
        i, j = near.i[k], near.j[k]
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        near.gap[k] = np.sqrt(dx * dx + dy * dy + dz * dz) - near.reach[k]


@uncounted
def note_places(close, spheres):
    """Where the spheres are now, and how fast they move on the whole."""
    u, place = spheres.velocity, close.place
    copy_rows(place, spheres.position)
    a = b = c = 0.0
    n = len(place)
    for i in range(np.uintp(n)):
        a += u[i, 0]
        b += u[i, 1]
        c += u[i, 2]
    close.drift[0], close.drift[1], close.drift[2] = a / n, b / n, c / n


@uncounted
def search_walls(world, shift):
    """The list of wall contacts, wall by wall."""
    walls, wall, counts, lengths = world.walls, world.wall, world.counts, world.lengths
    adapt(counts, lengths, WALL_SKIN, WALL_MADE, world.cells.largest)
    store_wall_history(wall, walls, counts)
    n = np.int64(0)
    for w in range(len(walls.force)):
        walls.first[w] = n
        n = contacts_of_wall(
            wall, walls, world.spheres, world.wall_law, lengths[WALL_SKIN], shift, w, n
        )
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


@uncounted
def store_wall_history(wall, walls, counts):
    """Put the histories of the wall contacts back into the walls' own table."""
    if counts[WALL] > 0:
        for w in range(len(walls.force)):
            for n in range(walls.first[w], walls.first[w + 1]):
                for h in range(N_HISTORY):
                    walls.history[w, wall.i[n], h] = wall.history[n, h]
    counts[WALL] = 0
    walls.first[:] = 0


@uncounted
def contacts_of_wall(wall, walls, spheres, law, skin, shift, w, n):
    """Append the spheres that touch wall w or nearly do; the new length.

    -1 if there is no room, -2 if a sphere is half outside.
    """
    x, n_spheres = spheres.position, len(spheres.inverse_mass)
    for i in range(n_spheres):
        px, py, pz = x[i, 0] - shift[0], x[i, 1] - shift[1], x[i, 2] - shift[2]
        if w < len(walls.planes):
            plane = walls.planes[w]
            gap = plane[0] * px + plane[1] * py + plane[2] * pz - plane[3] - x[i, 3]
        else:
            gap = walls.radius - np.sqrt(px * px + py * py) - x[i, 3]
        if gap < skin or walls.history[w, i, DAMPING] >= 0.0:
            if not gap >= -2.0 * _DEEPEST * x[i, 3]:
                return -2
            if n + LANES >= len(wall.i):
                return -1
            radius = x[i, 3]
            if walls.curved and w == len(walls.planes):
                # Half the cylinder's curvature, the mean of 1/r and 1/r - 1/R: r D / (D - r).
                radius = 2.0 * radius * walls.radius / (2.0 * walls.radius - radius)
            wall.i[n], wall.j[n] = i, n_spheres  # the enclosure's row
            wall.reach[n] = wall.constants[n, RADIUS_I] = x[i, 3]
            wall.constants[n, HERTZ] = law.hertz * np.sqrt(radius)
            wall.constants[n, MASS] = 1.0 / spheres.inverse_mass[i]
            for h in range(N_HISTORY):
                wall.history[n, h] = walls.history[w, i, h]
            n += 1
    return n
