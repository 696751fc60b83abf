"""The search for pairs of spheres: a list of near pairs, and one of what touches or nearly does.

Near pairs are found with cells and kept for hundreds of steps; close ones are filtered from them
and kept for tens of steps. What matters is how pairs move against each other: the close list is
made anew when a sphere has left the mean motion of all by half the skin, so that a bed that flies
as one keeps its lists; the list of wall contacts when one has moved by its skin against the
enclosure.

Lists are in ascending order of the spheres' numbers. No force depends on when a list was made:
what does not touch is not asked.
"""

import numpy as np

from damper3d.engine.neighbours import (
    CLOSE_FULL,
    DEEPEST,
    DONE,
    NEAR_FULL,
    NOT_FINITE,
    TOO_DEEP,
    adapt,
    copy,
    copy_histories,
    copy_rows,
    fill_cells,
    pairs_of,
)
from damper3d.engine.state import (
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
    STEP,
)
from granulab.contact.jit import inner

_NEAR_SHARE = 8.0  # near skin over close skin


@inner
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


@inner
def store_history(near, close, counts):
    """Put the histories of the close list back into the near list."""
    for n in range(counts[CLOSE]):
        for h in range(N_HISTORY):
            near.history[close.near[n], h] = close.history[n, h]
    counts[CLOSE] = 0


@inner
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


@inner
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


@inner
def note_constants(near, spheres, law, i, begin, end):
    """Return what the law needs to know of the pairs of sphere i."""
    radius = spheres.position[:, 3]
    for n in range(begin, end):
        j = near.j[n]
        near.reach[n] = radius[i] + radius[j]
        near.hertz[n] = law.hertz * np.sqrt(radius[i] * radius[j] / near.reach[n])
        near.mass[n] = 1.0 / (spheres.inverse_mass[i] + spheres.inverse_mass[j])


@inner
def fill_i(near, n_spheres):
    """The first spheres of all pairs, from where the pairs of each begin."""
    for i in range(n_spheres):
        for n in range(near.first[i], near.first[i + 1]):
            near.i[n] = i


@inner
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


@inner
def filter_close(near, close, spheres, counts, skin):
    """The close list: near pairs with a gap below the skin, or in contact so far."""
    x, n_near = spheres.position, counts[NEAR]
    gaps(near, x, n_near)
    n = 0
    for k in range(np.uintp(n_near)):
        if near.gap[k] < skin or near.history[k, DAMPING] >= 0.0:
            if n + LANES >= len(close.i):
                return CLOSE_FULL
            if near.gap[k] < -DEEPEST * near.reach[k]:
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


@inner
def gaps(near, x, n_near):
    """The gaps of all near pairs; without a branch, so that it is vectorised."""
    for k in range(np.uintp(n_near)):
        i, j = near.i[k], near.j[k]
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        near.gap[k] = np.sqrt(dx * dx + dy * dy + dz * dz) - near.reach[k]


@inner
def note_places(close, spheres):
    """Return where the spheres are now, and how fast they move on the whole."""
    u, place = spheres.velocity, close.place
    copy_rows(place, spheres.position)
    a = b = c = 0.0
    n = len(place)
    for i in range(np.uintp(n)):
        a += u[i, 0]
        b += u[i, 1]
        c += u[i, 2]
    close.drift[0], close.drift[1], close.drift[2] = a / n, b / n, c / n
