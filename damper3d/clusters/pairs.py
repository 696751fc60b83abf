"""The search for spheres of two bodies that touch or nearly do.

Bodies whose balls are near stand in a list of body pairs. Across any direction d, body i reaches up
to the highest h_i of its spheres' centre . d + radius, and body j down to the lowest l_j: the gap
between the bodies is at least l_j - h_i, and only spheres that reach beyond l_j - skin and
h_i + skin can be as near as the skin. That holds for any shape; with the direction in which the
bodies are nearest, few spheres are left, and these are compared one by one. The direction is
improved from the highest and the lowest sphere, and kept for the next search.

Pairs that are apart rest until all bodies together may have come as near as the skin.
"""

import numpy as np

from contact.jit import uncounted
from damper3d.cells import fill_cells, pairs_of
from damper3d.clusters.active import list_active
from damper3d.clusters.motion import arm_of, note_seen, way_since
from damper3d.lists import (
    CLOSE_FULL,
    DEEPEST,
    DONE,
    NEAR_FULL,
    NOT_FINITE,
    TOO_DEEP,
    adapt,
    copy,
    copy_rows,
)
from damper3d.neighbours import near_reach_left
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
    STEP,
)

_NEAR_SHARE = 0.1  # near skin over the radius of the ball round a body
_TRIES = 4  # directions across which a pair is looked at


@uncounted
def key_of(world, i, j):
    """A number by which pairs of spheres ascend as they are listed: by body pair, then spheres."""
    k, n = len(world.shape.offset), len(world.bodies.inverse_mass)
    a, b = np.int64(i) // k, np.int64(j) // k
    return ((a * n + b) * k + (i - a * k)) * k + (j - b * k)


@uncounted
def search_pairs(world, shift):
    """The list of pairs of spheres, after that of body pairs where its reach is used up."""
    counts, lengths, near, bodies = world.counts, world.lengths, world.near, world.bodies
    keep_histories(world)
    adapt(counts, lengths, CLOSE_SKIN, CLOSE_MADE, world.cells.largest)
    skin = lengths[CLOSE_SKIN]
    left = near_reach_left(bodies.position, near.place, lengths[NEAR_SKIN])
    used = approach_since(world)
    if not used < np.inf:
        return NOT_FINITE
    for k in range(counts[NEAR]):
        near.free[k] -= used
    if left < skin:
        lengths[NEAR_SKIN] = _NEAR_SHARE * bodies.position[:, 3].max()
        if not search_near(world, lengths[NEAR_SKIN], shift):
            return NEAR_FULL
    n = np.int64(0)
    for k in range(counts[NEAR]):
        if near.free[k] < skin:
            n = pairs_of_bodies(world, k, skin, n)
            if n < 0:
                return CLOSE_FULL if n == -1 else TOO_DEEP
    inherit_histories(world, n)
    counts[CLOSE] = n
    counts[CLOSE_SEARCHES] += 1
    counts[STALE_CLOSE] = 0
    counts[CLOSE_MADE] = counts[STEP]
    note_seen(bodies, world.close_seen)
    note_drift(bodies, world.close_seen)
    list_active(world)
    return DONE


@uncounted
def approach_since(world):
    """By how much the gap of two bodies can have shrunk since the list was made [m]."""
    since = (world.counts[STEP] - world.counts[CLOSE_MADE]) * world.time_step
    drift = world.close_seen.drift
    carried = since * drift[0], since * drift[1], since * drift[2]
    farthest = 0.0
    for b in range(len(world.bodies.inverse_mass)):
        way = way_since(world.bodies, world.close_seen, world.shape.arm, b, carried)
        if not way <= farthest:
            farthest = way
    return 2.0 * farthest


@uncounted
def note_drift(bodies, seen):
    """How fast the bodies move on the whole."""
    n = len(bodies.inverse_mass)
    for c in range(3):
        total = 0.0
        for b in range(n):
            total += bodies.velocity_now[b, c]
        seen.drift[c] = total / n


@uncounted
def search_near(world, skin, shift):
    """All pairs of bodies whose balls have a gap below the skin; False: there is no room."""
    near, counts, x = world.near, world.counts, world.bodies.position
    n_bodies, n_old = len(world.bodies.inverse_mass), counts[NEAR]
    fill_cells(world.cells, x, n_bodies, shift)
    copy(near.old_j, near.j, n_old)
    copy(near.old_first, near.first, n_bodies + 1)
    copy(near.old_free, near.free, n_old)
    for k in range(n_old):
        for c in range(4):
            near.old_direction[k, c] = near.direction[k, c]
    n = 0
    for i in range(n_bodies):
        near.first[i] = begin = n
        n = pairs_of(near, world.cells, x, skin, i, n)
        if n < 0:
            counts[NEAR] = 0  # the directions are found again
            return False
        inherit_directions(near, x, i, begin, n)
    near.first[n_bodies] = counts[NEAR] = n
    copy_rows(near.place, x)
    counts[NEAR_SEARCHES] += 1
    return True


@uncounted
def inherit_directions(near, x, i, begin, end):
    """Give the pairs of body i the directions and gaps that they had; both lists ascend.

    New ones start with the direction between the centroids.
    """
    old, old_end = near.old_first[i], near.old_first[i + 1]
    for n in range(begin, end):
        j = near.j[n]
        while old < old_end and near.old_j[old] < j:
            old += 1
        if old < old_end and near.old_j[old] == j:
            for c in range(3):
                near.direction[n, c] = near.old_direction[old, c]
            near.free[n] = near.old_free[old]
        else:
            set_direction(near, n, (x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]))
            near.free[n] = -np.inf


@uncounted
def set_direction(near, n, d):
    """Look at a pair of bodies along d, of any length."""
    size = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    if size > 0.0:
        near.direction[n, 0], near.direction[n, 1] = d[0] / size, d[1] / size
        near.direction[n, 2] = d[2] / size


@uncounted
def pairs_of_bodies(world, k, skin, n):
    """Append the pairs of spheres of body pair k with a gap below the skin; the new length.

    -1 if there is no room, -2 if two spheres overlap beyond belief.
    """
    near, scratch, x = world.near, world.scratch, world.bodies.position
    a, b = np.int64(near.i[k]), np.int64(near.j[k])
    apart = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    gap = find_direction(world, k, a, b, apart, skin)
    near.free[k] = gap
    if gap >= skin:
        return n
    d = near.direction[k, 0], near.direction[k, 1], near.direction[k, 2]
    between = apart[0] * d[0] + apart[1] * d[1] + apart[2] * d[2]
    high = reach(world, 0, a, d, 1.0)[0]
    low = between - reach(world, 1, b, d, -1.0)[0]
    n_a = those_beyond(world, 0, a, low - skin, (0.0, 0.0, 0.0))
    n_b = those_beyond(world, 1, b, between - high - skin, apart)
    return compare(world, k, a, b, n_a, n_b, skin, n)


@uncounted
def find_direction(world, k, a, b, apart, skin):
    """The largest gap of a pair of bodies across the directions tried [m]; it keeps that one."""
    near, offset, axes = world.near, world.shape.offset, world.bodies.axes
    d = near.direction[k, 0], near.direction[k, 1], near.direction[k, 2]
    widest = -np.inf
    for _ in range(_TRIES):
        high, top = reach(world, 0, a, d, 1.0)
        low, bottom = reach(world, 1, b, d, -1.0)
        gap = apart[0] * d[0] + apart[1] * d[1] + apart[2] * d[2] - high - low
        if not gap > widest:
            break
        widest = gap
        near.direction[k, 0], near.direction[k, 1], near.direction[k, 2] = d
        if gap >= skin:
            break
        r, s = arm_of(axes, offset, a, top), arm_of(axes, offset, b, bottom)
        way = apart[0] + s[0] - r[0], apart[1] + s[1] - r[1], apart[2] + s[2] - r[2]
        size = np.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
        if not size > 0.0:
            break
        d = way[0] / size, way[1] / size, way[2] / size
    return widest


@uncounted
def reach(world, which, b, d, sign):
    """How far body b reaches from its centroid along sign d [m], and with which sphere.

    Of each sphere it stands in row `which` of scratch.height then.
    """
    height, columns, axes = world.scratch.height, world.shape.columns, world.bodies.axes
    x = sign * (d[0] * axes[b, 0] + d[1] * axes[b, 1] + d[2] * axes[b, 2])
    y = sign * (d[0] * axes[b, 4] + d[1] * axes[b, 5] + d[2] * axes[b, 6])
    z = sign * (d[0] * axes[b, 8] + d[1] * axes[b, 9] + d[2] * axes[b, 10])
    n = columns.shape[1]
    for s in range(np.uintp(n)):
        height[which, s] = x * columns[0, s] + y * columns[1, s] + z * columns[2, s] + columns[3, s]
    highest, best = height[which, 0], 0
    for s in range(n):
        if height[which, s] > highest:
            highest, best = height[which, s], s
    return highest, best


@uncounted
def those_beyond(world, which, b, limit, shift):
    """Note the spheres of body b whose height is above a limit, and their centres; how many."""
    scratch, shape = world.scratch, world.shape
    found = 0
    for s in range(len(shape.offset)):
        if scratch.height[which, s] > limit:
            r = arm_of(world.bodies.axes, shape.offset, b, s)
            scratch.sphere[which, found] = s
            for c in range(3):
                scratch.centre[which, c, found] = r[c] + shift[c]
            scratch.centre[which, 3, found] = shape.offset[s, 3]
            found += 1
    return found


@uncounted
def compare(world, k, a, b, n_a, n_b, skin, n):
    """Append those of the noted spheres of two bodies whose gap is below the skin."""
    scratch, close = world.scratch, world.close
    centre, gap, size = scratch.centre, scratch.gap, len(world.shape.offset)
    for p in range(n_a):
        x, y, z = centre[0, 0, p], centre[0, 1, p], centre[0, 2, p]
        radius = centre[0, 3, p]
        for q in range(np.uintp(n_b)):
            dx, dy, dz = centre[1, 0, q] - x, centre[1, 1, q] - y, centre[1, 2, q] - z
            gap[q] = np.sqrt(dx * dx + dy * dy + dz * dz) - (radius + centre[1, 3, q])
        for q in range(n_b):
            if gap[q] < skin:
                if n + LANES >= len(close.i):
                    return -1
                if gap[q] < -DEEPEST * (radius + centre[1, 3, q]):
                    return -2
                i, j = a * size + scratch.sphere[0, p], b * size + scratch.sphere[1, q]
                close.i[n], close.j[n], close.near[n] = i, j, k
                note_constants(world, n, radius, centre[1, 3, q])
                n += 1
    return n


@uncounted
def note_constants(world, n, radius_i, radius_j):
    """What the law needs to know of a pair; the reduced mass is that of the bodies."""
    close, scratch, mass = world.close, world.scratch, world.bodies.inverse_mass
    close.reach[n] = radius_i + radius_j
    close.constants[n, RADIUS_I], close.constants[n, RADIUS_J] = radius_i, radius_j
    root = np.sqrt(radius_i * radius_j / (radius_i + radius_j))
    close.constants[n, HERTZ] = scratch.whole[n, 0] = world.pair_law.hertz * root
    close.constants[n, MASS] = scratch.whole[n, 1] = 0.5 / mass[0]


@uncounted
def keep_histories(world):
    """Remember the histories of the pairs in contact, as the list is given up."""
    close, kept, counts = world.close, world.kept, world.counts
    if counts[CLOSE] == 0:
        return  # there was no room, or a state was put back: they are remembered already
    n = 0
    for m in range(counts[CLOSE]):
        if close.history[m, DAMPING] >= 0.0:
            kept.key[n] = key_of(world, close.i[m], close.j[m])
            for h in range(N_HISTORY):
                kept.history[n, h] = close.history[m, h]
            n += 1
    kept.count[0] = n
    counts[CLOSE] = 0


@uncounted
def inherit_histories(world, n_pairs):
    """Give the pairs of the list the histories that are remembered; both ascend by their keys."""
    close, kept = world.close, world.kept
    old = 0
    for n in range(n_pairs):
        for h in range(N_HISTORY):
            close.history[n, h] = 0.0
        close.history[n, DAMPING] = NO_CONTACT
    for n in range(n_pairs):
        if old == kept.count[0]:
            break
        key = key_of(world, close.i[n], close.j[n])
        while old < kept.count[0] and kept.key[old] < key:
            old += 1
        if old < kept.count[0] and kept.key[old] == key:
            for h in range(N_HISTORY):
                close.history[n, h] = kept.history[old, h]
    kept.count[0] = 0
