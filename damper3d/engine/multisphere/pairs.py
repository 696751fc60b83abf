"""The search for spheres of two particles that touch or nearly do.

Particles whose bounding spheres are near stand in the outer list. Across any direction d, particle
i extends up to the highest h_i of its spheres' centre . d + radius, and particle j down to the
lowest l_j: the gap between the particles is at least l_j - h_i, and only spheres that extend beyond
l_j - skin and h_i + skin can be as near as the skin. That holds for any shape; with the direction
in which the particles are nearest, few spheres are left, and these are compared one by one. The
nearest two give the direction for the next search.

Pairs that are apart rest until they may have come as near as the skin, and a particle far from all
others may go far before the list is made again: it must only know what touches.
"""

import numpy as np

from damper3d.engine.geometry import copy
from damper3d.engine.laws.table import hertz_of
from damper3d.engine.multisphere.form import (
    columns_of,
    farthest_centre,
    first_row,
    first_sphere,
    pair_mass,
)
from damper3d.engine.multisphere.motion import arm_of, ways_since
from damper3d.engine.state import (
    DEEPEST,
    HERTZ,
    INNER_MADE,
    LANES,
    MASS,
    OUTER,
    RADIUS_I,
    RADIUS_J,
    STEP,
)
from granulab.contact.jit import inlined_inner, inner

_OUTER_SHARE = 0.1  # outer skin over the bounding radius of a particle


@inner
def outer_skin(world):
    """Gap of bounding spheres that the outer list shall hold [m]."""
    return _OUTER_SHARE * largest_bounding(world.particles)


@inner
def largest_bounding(particles):
    """The largest radius of a sphere that holds a particle [m]."""
    largest = 0.0
    for b in range(len(particles.position)):
        largest = max(largest, particles.position[b, 3])
    return largest


@inner
def note_ways(world):
    """Take off the gaps of particles what they have moved; False if that is no number."""
    outer, free, way = world.outer, world.shape.pairs.free, world.shape.scratch.way
    since = (world.counts[STEP] - world.counts[INNER_MADE]) * world.time_step
    drift = world.inner_seen.drift
    carried = since * drift[0], since * drift[1], since * drift[2]
    finite = True
    for b in range(len(way)):
        straight, turned = ways_since(
            world.particles, world.inner_seen, farthest_centre(world.shape.form, b), b, carried
        )
        way[b] = np.sqrt(straight) + np.sqrt(turned)
        finite &= way[b] < np.inf
    for k in range(world.counts[OUTER]):
        free[k] -= way[outer.i[k]] + way[outer.j[k]]
    return finite


@inner
def list_pairs(world, skin, left):
    """Fill the list with the pairs of spheres nearer than the skin; how many there are.

    What is left of the gap of two particles, or of the skin where some of their spheres are listed,
    is the margin of both. -1: no room; -2: an overlap is too deep.
    """
    outer, free, margin = world.outer, world.shape.pairs.free, world.inner_seen.margin
    margin[:] = 0.5 * left
    n = np.int64(0)
    for k in range(world.counts[OUTER]):
        begin = n
        if free[k] < skin:
            n = pairs_of_spheres(world, k, skin, n)
            if n < 0:
                return n
        gap = skin if n > begin else max(free[k], skin)
        i, j = outer.i[k], outer.j[k]
        margin[i], margin[j] = min(margin[i], 0.5 * gap), min(margin[j], 0.5 * gap)
    note_constants(world, n)
    return n if deepest_share(world, n) <= DEEPEST else np.int64(-2)


@inner
def remember_pairs(world):
    """Remember directions and gaps of the pairs of the outer list."""
    outer, pairs, n = world.outer, world.shape.pairs, world.counts[OUTER]
    copy(pairs.old_i, outer.i, n)
    copy(pairs.old_j, outer.j, n)
    copy(pairs.old_free, pairs.free, n)
    for k in range(n):
        for c in range(4):
            pairs.old_direction[k, c] = pairs.direction[k, c]


@inner
def know_pairs(world, n_pairs):
    """Give the pairs of the outer list the directions and gaps that they had; both lists ascend.

    New ones start with the direction between the centroids.
    """
    outer, pairs, x = world.outer, world.shape.pairs, world.particles.position
    old, n_old = 0, world.counts[OUTER]
    for n in range(n_pairs):
        i, j = outer.i[n], outer.j[n]
        while old < n_old and (
            pairs.old_i[old] < i or (pairs.old_i[old] == i and pairs.old_j[old] < j)
        ):
            old += 1
        if old < n_old and pairs.old_i[old] == i and pairs.old_j[old] == j:
            for c in range(3):
                pairs.direction[n, c] = pairs.old_direction[old, c]
            pairs.free[n] = pairs.old_free[old]
        else:
            between = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
            set_direction(pairs.direction, n, between)
            pairs.free[n] = -np.inf


@inner
def set_direction(direction, n, d):
    """Let pair n of particles be looked at along d, of any length, the next time."""
    size = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
    if size > 0.0:
        direction[n, 0], direction[n, 1], direction[n, 2] = d[0] / size, d[1] / size, d[2] / size


@inlined_inner
def pairs_of_spheres(world, k, skin, n):
    """Append the pairs of spheres of particle pair k with a gap below the skin; the new length.

    -1 if there is no room. How deep they overlap stands in scratch.depth.
    """
    outer, shape, x, axes = world.outer, world.shape, world.particles.position, world.particles.axes
    scratch, direction, form = shape.scratch, shape.pairs.direction, shape.form
    height = scratch.height
    a, b = np.int64(outer.i[k]), np.int64(outer.j[k])
    apart = x[b, 0] - x[a, 0], x[b, 1] - x[a, 1], x[b, 2] - x[a, 2]
    d = direction[k, 0], direction[k, 1], direction[k, 2]
    between = apart[0] * d[0] + apart[1] * d[1] + apart[2] * d[2]
    high = extent(height[0], form.columns, columns_of(form, a), axes[a], d, 1.0)
    low = between - extent(height[1], form.columns, columns_of(form, b), axes[b], d, -1.0)
    shape.pairs.free[k] = low - high
    if low - high >= skin:
        return n
    n_a = those_beyond(scratch, 0, form, axes, a, low - skin, (0.0, 0.0, 0.0))
    n_b = those_beyond(scratch, 1, form, axes, b, between - high - skin, apart)
    return compare(scratch, world.inner, direction, form, k, a, b, n_a, n_b, skin, n)


@inner
def extent(height, columns, where, axes, d, sign):
    """Return the extent of a particle from its centroid along sign d [m]; height: of each sphere.

    where: columns_of the particle.
    Four largest ones at once, so that none waits for the one before it.
    """
    x = sign * (d[0] * axes[0] + d[1] * axes[1] + d[2] * axes[2])
    y = sign * (d[0] * axes[4] + d[1] * axes[5] + d[2] * axes[6])
    z = sign * (d[0] * axes[8] + d[1] * axes[9] + d[2] * axes[10])
    begin, n = where
    for s in range(np.uintp(n)):
        t = begin + s
        height[s] = x * columns[0, t] + y * columns[1, t] + z * columns[2, t] + columns[3, t]
    a, b, c, e = height[0], height[1], height[2], height[3]
    for s in range(np.int64(4), n, 4):
        a, b = max(a, height[s]), max(b, height[s + 1])
        c, e = max(c, height[s + 2]), max(e, height[s + 3])
    return max(max(a, b), max(c, e))


@inner
def those_beyond(scratch, which, form, axes, b, limit, shift):
    """Note the spheres of particle b whose height is above a limit, and their centres; how many."""
    height, sphere, centre = scratch.height, scratch.sphere, scratch.centre
    found = 0
    for s in range(first_sphere(form, b + 1) - first_sphere(form, b)):
        if height[which, s] > limit:
            r = arm_of(axes, form, b, s)
            sphere[which, found] = s
            for c in range(3):
                centre[which, c, found] = r[c] + shift[c]
            centre[which, 3, found] = form.offset[first_row(form, b) + s, 3]
            found += 1
    return found


@inner
def compare(scratch, contacts, direction, form, k, a, b, n_a, n_b, skin, n):
    """Append those of the noted spheres of two particles whose gap is below the skin.

    The next time the particles are looked at along the line between the nearest two.
    """
    centre, gap, i, j, group = scratch.centre, scratch.gap, contacts.i, contacts.j, contacts.group
    first_a, first_b = first_sphere(form, a), first_sphere(form, b)
    least, best_p, best_q = np.inf, 0, 0
    for p in range(n_a):
        x, y, z = centre[0, 0, p], centre[0, 1, p], centre[0, 2, p]
        radius, first = centre[0, 3, p], first_a + scratch.sphere[0, p]
        if n + n_b + LANES > len(i):
            return np.int64(-1)
        for q in range(np.uintp(n_b)):
            dx, dy, dz = centre[1, 0, q] - x, centre[1, 1, q] - y, centre[1, 2, q] - z
            gap[q] = np.sqrt(dx * dx + dy * dy + dz * dz) - (radius + centre[1, 3, q])
        for q in range(n_b):
            if gap[q] < least:
                least, best_p, best_q = gap[q], p, q
            # Each is written, and only counted where it is one of them.
            i[n], j[n], group[n] = first, first_b + scratch.sphere[1, q], k
            scratch.depth[n] = -gap[q]
            n += np.int64(gap[q] < skin)
    if least < np.inf:
        way = (centre[1, 0, best_q] - centre[0, 0, best_p],
               centre[1, 1, best_q] - centre[0, 1, best_p],
               centre[1, 2, best_q] - centre[0, 2, best_p])  # fmt: skip
        set_direction(direction, k, way)
    return n


@inner
def deepest_share(world, n_pairs):
    """The largest overlap of two spheres of the list over the sum of their radii."""
    largest = 0.0
    for n in range(n_pairs):
        largest = max(largest, world.shape.scratch.depth[n] / world.inner.cutoff[n])
    return largest


@inlined_inner
def note_constants(world, n_pairs):
    """Note what the law needs to know of the pairs; the reduced mass is that of the particles."""
    contacts, whole, radius = world.inner, world.inner.whole, world.spheres.position
    for n in range(np.uintp(n_pairs)):
        i, j = contacts.i[n], contacts.j[n]
        first, second = radius[i, 3], radius[j, 3]
        hertz = hertz_of(world.pair_law, i, j) * np.sqrt(first * second / (first + second))
        mass = pair_mass(world.shape.form, world.spheres, i, j)
        contacts.cutoff[n] = first + second
        contacts.constants[n, RADIUS_I], contacts.constants[n, RADIUS_J] = first, second
        contacts.constants[n, HERTZ] = whole[n, 0] = hertz
        contacts.constants[n, MASS] = whole[n, 1] = mass
