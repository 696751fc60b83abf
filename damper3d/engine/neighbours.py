"""Neighbour lists: pairs of particles that are outer, then the spheres that touch or nearly do.

The outer list holds pairs of particles; it is made with linked cells and lasts for hundreds of
steps. From it the inner list, of pairs of spheres, is made every few tens of steps, in the way that
goes with the particles (spheres/pairs.py, multisphere/pairs.py). What matters is how particles move
against each other: the inner list is made again when one has left the mean motion of all by its
margin, so that a bed that flies as one keeps its lists; the list of wall contacts when one has
moved by its margin against the enclosure. Skins follow the speed, so that a list lasts for a few
tens of steps whatever it is.

Lists are in ascending order of the numbers of particles, then of spheres. No bit depends on when a
list was made: what does not touch is not asked, or adds exact zeros.
"""

import numpy as np

from damper3d.engine.enclosures.places import keep_places, list_places
from damper3d.engine.geometry import copy_rows
from damper3d.engine.kinds import (
    first_sphere,
    key_of,
    know_pairs,
    list_pairs,
    list_spheres,
    measure_gaps,
    note_positions,
    note_ways,
    outer_skin,
    place_near_walls,
    remember_pairs,
)
from damper3d.engine.laws.rolling import copy_rolled, wipe_rolled
from damper3d.engine.laws.table import face_wall
from damper3d.engine.motions.host import mobility
from damper3d.engine.state import (
    DAMPING,
    DEEPEST,
    DONE,
    HERTZ,
    INNER,
    INNER_FULL,
    INNER_MADE,
    INNER_SEARCHES,
    INNER_SKIN,
    LANES,
    MASS,
    N_HISTORY,
    NO_CONTACT,
    NOT_FINITE,
    OUTER,
    OUTER_FULL,
    OUTER_SEARCHES,
    OUTER_SKIN,
    RADIUS_I,
    STALE_INNER,
    STALE_WALL,
    STEP,
    TOO_DEEP,
    WALL,
    WALL_FULL,
    WALL_MADE,
    WALL_SEARCHES,
    WALL_SKIN,
)
from damper3d.engine.walls import (
    gap_to_wall,
    hertz_at_wall,
    is_triangulated,
    note_listed,
)
from granulab.contact.jit import inner, specialised

# How many steps a list should last, and by how much its skin changes where it does not. Short
# lists are quick to pass through, long ones to make; the cost is flat about these.
_SHORT, _LONG = 12, 40
_GROW, _SHRINK = 1.25, 0.9
_LEAST, _MOST = 0.002, 0.03  # of the inner skin over the largest radius


@inner
def adapt(counts, lengths, skin, made, largest):
    """Widen a skin whose list was short-lived, and narrow one whose list lasted long."""
    lasted = counts[STEP] - counts[made]
    if 0 < lasted < _SHORT:
        lengths[skin] = min(_GROW * lengths[skin], _MOST * largest)
    elif lasted > _LONG:
        lengths[skin] = max(_SHRINK * lengths[skin], _LEAST * largest)


@inner
def search_pairs(world, shift):
    """Make the inner list again, after the outer one where its cutoff is used up; DONE, or why not.

    Nothing is lost where a list is full: the caller makes it longer and comes back.
    """
    if world.counts[INNER] > 0:  # else there was no room, or a state was put back: they are kept
        give_up_list(world, keep_histories(world, np.int64(0), world.counts[INNER], np.int64(0)))
    left = begin_search(world)
    if np.isnan(left):
        return NOT_FINITE
    if left < 0.0 and not search_outer(world, -left, shift):
        return OUTER_FULL
    measure_gaps(world, np.int64(0), world.counts[OUTER])
    outcome = list_inner(world, abs(left))
    if outcome == DONE:
        inherit_histories(world, np.int64(0), world.counts[INNER])
        world.kept.number[0] = 0
    return outcome


@inner
def begin_search(world):
    """Measure the gap below which all pairs of particles are in the outer list [m].

    With a minus sign where that list is to be made first; NaN where a position is no longer a
    finite number.
    """
    counts, lengths, outer = world.counts, world.lengths, world.outer
    adapt(counts, lengths, INNER_SKIN, INNER_MADE, world.cells.largest)
    note_positions(world)
    left = outer_cutoff_left(outer.now, outer.made_at, lengths[OUTER_SKIN])
    if not note_ways(world):
        return np.nan
    if left < lengths[INNER_SKIN]:
        lengths[OUTER_SKIN] = outer_skin(world)
        return -lengths[OUTER_SKIN]
    return left


@inner
def list_inner(world, left):
    """Make the inner list from the outer one, but for the histories; DONE, or why not.

    left: the size of what begin_search gave.
    """
    counts, lengths = world.counts, world.lengths
    n = list_pairs(world, lengths[INNER_SKIN], left)
    if n < 0:
        return INNER_FULL if n == -1 else TOO_DEEP
    counts[INNER] = n
    note_parts(world)
    counts[INNER_SEARCHES] += 1
    counts[STALE_INNER] = 0
    counts[INNER_MADE] = counts[STEP]
    list_spheres(world, world.inner_seen)
    return DONE


@inner
def note_parts(world):
    """Note where the pairs of each part begin in the inner list."""
    i, n = world.inner.i, np.int64(0)
    for part in range(len(world.parts)):
        first = first_sphere(world.shape, world.parts[part])
        while n < world.counts[INNER] and i[n] < first:
            n += 1
        world.first_pair[part] = n


@inner
def outer_cutoff_left(x, place, skin):
    """The gap below which all pairs are in the outer list, by how far particles have spread [m].

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


@inner
def search_outer(world, skin, shift):
    """All pairs of particles, where they are now, with a gap below the skin; False: no room."""
    outer, n_particles = world.outer, np.int64(len(world.outer.now))
    begin_outer(world, shift)
    n = near_pairs(outer.i, outer.j, world.cells, outer.now, skin, np.int64(0), n_particles)
    return know_outer(world, n)


@inner
def begin_outer(world, shift):
    """Give the outer list up, and sort the particles into cells."""
    remember_pairs(world)
    fill_cells(world.cells, world.outer.now, len(world.outer.now), shift)


@inner
def near_pairs(first, second, cells, x, skin, begin, end):
    """Write all pairs of particles begin ... end - 1 and later ones, nearer than the skin.

    How many there are, or -1 for no room in the lists first and second.
    """
    n = np.int64(0)
    for i in range(begin, end):
        n = pairs_of(first, second, cells, x, skin, i, n)
        if n < 0:
            return n
    return n


@inner
def know_outer(world, n):
    """Let the outer list be the n pairs that stand in it now; False if there was no room: -1."""
    if n < 0:
        world.counts[OUTER] = 0
        world.lengths[OUTER_SKIN] = -1.0
        return False
    know_pairs(world, n)
    world.counts[OUTER] = n
    copy_rows(world.outer.made_at, world.outer.now)
    world.counts[OUTER_SEARCHES] += 1
    return True


@inner
def fill_cells(cells, x, n_particles, shift):
    """Sort the particles into cells; those outside the grid go into the nearest cell."""
    nx, ny, nz = cells.shape
    n_cells = nx * ny * nz
    cells.start[:] = 0
    for i in range(n_particles):
        a = min(max(int((x[i, 0] - shift[0] - cells.origin[0]) / cells.size), 0), nx - 1)
        b = min(max(int((x[i, 1] - shift[1] - cells.origin[1]) / cells.size), 0), ny - 1)
        c = min(max(int((x[i, 2] - shift[2] - cells.origin[2]) / cells.size), 0), nz - 1)
        cells.home[i] = (c * ny + b) * nx + a
        cells.start[cells.home[i] + 1] += 1
    for cell in range(n_cells + 1):
        cells.start[cell + 1] += cells.start[cell]
    for i in range(n_particles - 1, -1, -1):  # backwards: the particles of a cell ascend
        cell = cells.home[i]
        cells.start[cell + 1] -= 1
        at = cells.start[cell + 1]
        cells.members[at] = i
        for d in range(4):
            cells.place[at, d] = x[i, d]


@inner
def pairs_of(first, second, cells, x, skin, i, n):
    """Append the near pairs (i, j > i) in ascending order; the new length, or -1 for no room.

    After fill_cells the particles of a cell stand between its own entry of `start`, shifted by one,
    and the next.
    """
    nx, ny, nz = cells.shape
    cell, place = cells.home[i], cells.place
    a, b, c = cell % nx, (cell // nx) % ny, cell // (nx * ny)
    x_i, y_i, z_i, reach = x[i, 0], x[i, 1], x[i, 2], skin + x[i, 3]
    begin = n
    for cc in range(max(c - 1, 0), min(c + 2, nz)):
        for bb in range(max(b - 1, 0), min(b + 2, ny)):
            row = (cc * ny + bb) * nx
            low, high = row + max(a - 1, 0), row + min(a + 1, nx - 1)
            if n + cells.start[high + 2] - cells.start[low + 1] >= len(second):
                return np.int64(-1)
            for k in range(np.uintp(cells.start[low + 1]), np.uintp(cells.start[high + 2])):
                dx, dy, dz = place[k, 0] - x_i, place[k, 1] - y_i, place[k, 2] - z_i
                most, j = reach + place[k, 3], cells.members[k]
                second[n] = j  # each is written, and only counted where it is one of them
                n += np.int64((dx * dx + dy * dy + dz * dz < most * most) & (j > i))
    for at in range(begin, n):
        first[at] = i
    ascend(second, begin, n)
    return n


@inner
def ascend(numbers, begin, end):
    """Sort a handful of numbers, by insertion."""
    for n in range(begin + 1, end):
        number, at = numbers[n], n
        while at > begin and numbers[at - 1] > number:
            numbers[at] = numbers[at - 1]
            at -= 1
        numbers[at] = number


@inner
def keep_histories(world, first, last, n):
    """Remember the histories of those of pairs first ... last - 1 in contact, n being there before.

    Returns how many there are then. By keys that ascend as the pairs are listed: by pair of
    particles, then by sphere.
    """
    contacts, kept = world.inner, world.kept
    for m in range(first, last):
        if contacts.history[m, DAMPING] >= 0.0:
            kept.key[n] = key_of(
                world.shape, len(world.outer.made_at), contacts.i[m], contacts.j[m]
            )
            for h in range(N_HISTORY):
                kept.history[n, h] = contacts.history[m, h]
            copy_rolled(kept.rolling, n, contacts.rolling, m)
            n += 1
    return n


@inner
def give_up_list(world, n):
    """Give the inner list up, of which n histories are remembered."""
    world.kept.number[0] = n
    world.counts[INNER] = 0


@inner
def inherit_histories(world, first, last):
    """Give pairs first ... last - 1 the histories that are remembered; both ascend by keys."""
    contacts, kept = world.inner, world.kept
    old = np.int64(0)
    for n in range(first, last):
        for h in range(N_HISTORY):
            contacts.history[n, h] = 0.0
        contacts.history[n, DAMPING] = NO_CONTACT
    wipe_rolled(contacts.rolling, first, last)
    if first > 0 and first < last:
        old = key_from(world, contacts.i[first], contacts.j[first])
    for n in range(first, last):
        if old == kept.number[0]:
            break
        key = key_of(world.shape, len(world.outer.made_at), contacts.i[n], contacts.j[n])
        while old < kept.number[0] and kept.key[old] < key:
            old += 1
        if old < kept.number[0] and kept.key[old] == key:
            for h in range(N_HISTORY):
                contacts.history[n, h] = kept.history[old, h]
            copy_rolled(contacts.rolling, n, kept.rolling, old)


@inner
def key_from(world, i, j):
    """Return the first of the remembered keys that is not below that of a pair of spheres."""
    kept, key = world.kept, key_of(world.shape, len(world.outer.made_at), i, j)
    low, high = np.int64(0), kept.number[0]
    while low < high:
        middle = (low + high) // 2
        if kept.key[middle] < key:
            low = middle + 1
        else:
            high = middle
    return low


@inner
def search_walls(world, shift):
    """Make the list of wall contacts again, wall by wall; DONE, or why not.

    Only particles whose bounding sphere is near a wall are looked at. How far one may go before the
    list is made again is its gap to the nearest wall that it is not listed with, at least the skin.
    """
    walls, counts, lengths, x = world.walls, world.counts, world.lengths, world.outer.now
    note_positions(world)
    adapt(counts, lengths, WALL_SKIN, WALL_MADE, world.cells.largest)
    store_wall_history(world.wall, walls, counts)
    skin, margin = lengths[WALL_SKIN], world.wall_seen.margin
    place_near_walls(world, skin, shift)
    margin[:] = np.inf
    n = np.int64(0)
    for w in range(len(walls.force)):
        face_wall(world.wall_law, w)
        walls.first[w] = n
        for b in range(len(margin)):
            gap = gap_to_wall(walls, x, w, b, shift)
            margin[b] = min(margin[b], max(gap, skin))
            if gap < skin:
                n = contacts_of_wall(world, w, b, shift, n)
                if n < 0:
                    return WALL_FULL if n == -1 else TOO_DEEP
    walls.first[len(walls.force)] = counts[WALL] = n
    counts[WALL_SEARCHES] += 1
    counts[STALE_WALL] = 0
    counts[WALL_MADE] = counts[STEP]
    note_listed(world, margin)
    list_spheres(world, world.wall_seen)
    for c in range(3):
        world.wall_seen.drift[c] = shift[c]
    return DONE


def store_wall_history(wall, walls, counts):
    """Put the histories of the wall contacts back into the walls' own table."""


def contacts_of_sphere(world, w, i, b, shift, n):
    """Append the contacts of sphere i of particle b with wall w; the new length, or -1 or -2."""


@specialised(store_wall_history)
def _store_wall_history(wall, walls, counts):
    if is_triangulated(walls):
        return lambda wall, walls, counts: _store_places(wall, walls, counts)
    return lambda wall, walls, counts: _store_by_wall(wall, walls, counts)


@inner
def _store_places(wall, walls, counts):
    if counts[WALL] > 0:
        keep_places(wall, walls, counts[WALL])
    counts[WALL] = 0
    walls.first[:] = 0


@inner
def _store_by_wall(wall, walls, counts):
    if counts[WALL] > 0:
        for w in range(len(walls.force)):
            for n in range(walls.first[w], walls.first[w + 1]):
                for h in range(N_HISTORY):
                    walls.history[w, wall.i[n], h] = wall.history[n, h]
                copy_rolled(walls.rolling, w * walls.history.shape[1] + wall.i[n], wall.rolling, n)
    counts[WALL] = 0
    walls.first[:] = 0


@inner
def contacts_of_wall(world, w, b, shift, n):
    """Append the spheres of particle b that touch wall w or nearly do; the new length.

    -1 if there is no room, -2 if a sphere is half outside.
    """
    for i in range(first_sphere(world.shape, b), first_sphere(world.shape, b + 1)):
        n = contacts_of_sphere(world, w, i, b, shift, n)
        if n < 0:
            return n
    return n


@specialised(contacts_of_sphere)
def _contacts_of_sphere(world, w, i, b, shift, n):
    if is_triangulated(world[world.fields.index("walls")]):
        return lambda world, w, i, b, shift, n: _contacts_with_places(world, w, i, b, shift, n)
    return lambda world, w, i, b, shift, n: _contact_with_wall(world, w, i, b, shift, n)


@inner
def _contacts_with_places(world, w, i, b, shift, n):
    x = world.spheres.position
    gap = gap_to_wall(world.walls, x, w, i, shift)
    if gap >= world.lengths[WALL_SKIN]:
        return n
    if not gap >= -2.0 * DEEPEST * x[i, 3]:
        return np.int64(-2)
    return list_places(world, i, b, shift, n)


@inner
def _contact_with_wall(world, w, i, b, shift, n):
    wall, walls, spheres, x = world.wall, world.walls, world.spheres, world.spheres.position
    gap = gap_to_wall(walls, x, w, i, shift)
    if gap < world.lengths[WALL_SKIN] or walls.history[w, i, DAMPING] >= 0.0:
        if not gap >= -2.0 * DEEPEST * x[i, 3]:
            return np.int64(-2)
        if n + LANES >= len(wall.i):
            return np.int64(-1)
        # row m is the enclosure
        wall.i[n], wall.j[n], wall.group[n] = i, len(spheres.inverse_mass), b
        wall.cutoff[n] = wall.constants[n, RADIUS_I] = x[i, 3]
        hertz = hertz_at_wall(world, w, i, shift)
        wall.constants[n, HERTZ] = wall.whole[n, 0] = hertz
        mass = 1.0 / (spheres.inverse_mass[i] + mobility(world.shaker))
        wall.constants[n, MASS] = wall.whole[n, 1] = mass
        for h in range(N_HISTORY):
            wall.history[n, h] = walls.history[w, i, h]
        copy_rolled(wall.rolling, n, walls.rolling, w * len(spheres.inverse_mass) + i)
        n += 1
    return n
