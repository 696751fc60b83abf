"""The inner list of spheres: pairs of the outer list whose gap is below the skin."""

import numpy as np

from damper3d.engine.laws.table import halo, hertz_of
from damper3d.engine.state import (
    DEEPEST,
    HERTZ,
    INNER_SKIN,
    LANES,
    MASS,
    OUTER,
    RADIUS_I,
    RADIUS_J,
)
from granulab.contact.jit import inner

_OUTER_SHARE = 8.0  # outer skin over inner skin


@inner
def key_of(n, i, j):
    """Return the place of a pair of n spheres among all."""
    return np.int64(i) * n + np.int64(j)


@inner
def outer_skin(world):
    """Gap that the outer list shall hold: some of the inner list's [m]."""
    return _OUTER_SHARE * world.lengths[INNER_SKIN]


@inner
def know_pairs(world, n_pairs):
    """Note what the law needs to know of the pairs."""
    outer, pairs, spheres = world.outer, world.shape, world.spheres
    for n in range(n_pairs):
        i, j = outer.i[n], outer.j[n]
        first, second = spheres.position[i, 3], spheres.position[j, 3]
        pairs.cutoff[n] = first + second
        a, b = first - halo(world.pair_law), second - halo(world.pair_law)
        pairs.hertz[n] = hertz_of(world.pair_law, i, j) * np.sqrt(a * b / (a + b))
        pairs.mass[n] = 1.0 / (spheres.inverse_mass[i] + spheres.inverse_mass[j])


@inner
def list_pairs(world, skin):
    """Fill the inner list with the pairs nearer than the skin; how many, -1 no room, -2 too deep.

    Each sphere may leave the mean motion by half of the skin.
    """
    outer, pairs, contacts, x = world.outer, world.shape, world.inner, world.spheres.position
    n = np.int64(0)
    for k in range(np.uintp(world.counts[OUTER])):
        if pairs.gap[k] < skin:
            if n + LANES >= len(contacts.i):
                return np.int64(-1)
            if pairs.gap[k] < -DEEPEST * pairs.cutoff[k]:
                return np.int64(-2)
            contacts.i[n], contacts.j[n], contacts.group[n] = outer.i[k], outer.j[k], k
            contacts.cutoff[n] = pairs.cutoff[k]
            contacts.constants[n, RADIUS_I] = x[outer.i[k], 3]
            contacts.constants[n, RADIUS_J] = x[outer.j[k], 3]
            contacts.constants[n, HERTZ], contacts.constants[n, MASS] = (
                pairs.hertz[k],
                pairs.mass[k],
            )
            n += 1
    world.inner_seen.margin[:] = 0.5 * skin
    return n


@inner
def measure_gaps(world, first, last):
    """Note the gaps of pairs of the outer list; without a branch, so that it is vectorised."""
    outer, pairs, x = world.outer, world.shape, world.spheres.position
    for k in range(np.uintp(first), np.uintp(last)):
        i, j = outer.i[k], outer.j[k]
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        pairs.gap[k] = np.sqrt(dx * dx + dy * dy + dz * dz) - pairs.cutoff[k]
