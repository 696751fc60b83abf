"""The inner list of spheres: pairs of the outer list whose gap is below the skin."""

import numpy as np

from damper3d.engine.state import (
    CLOSE_SKIN,
    DEEPEST,
    HERTZ,
    LANES,
    MASS,
    NEAR,
    RADIUS_I,
    RADIUS_J,
)
from granulab.contact.jit import inner

_NEAR_SHARE = 8.0  # outer skin over inner skin


@inner
def key_of(n, i, j):
    """Return the place of a pair of n spheres among all."""
    return np.int64(i) * n + np.int64(j)


@inner
def outer_skin(world):
    """Gap that the outer list shall hold: some of the inner list's [m]."""
    return _NEAR_SHARE * world.lengths[CLOSE_SKIN]


@inner
def know_pairs(world, n_pairs):
    """Note what the law needs to know of the pairs."""
    near, pairs, spheres = world.near, world.shape, world.spheres
    for n in range(n_pairs):
        i, j = near.i[n], near.j[n]
        first, second = spheres.position[i, 3], spheres.position[j, 3]
        pairs.reach[n] = first + second
        pairs.hertz[n] = world.pair_law.hertz * np.sqrt(first * second / pairs.reach[n])
        pairs.mass[n] = 1.0 / (spheres.inverse_mass[i] + spheres.inverse_mass[j])


@inner
def list_pairs(world, skin):
    """Fill the inner list with the pairs nearer than the skin; how many, -1 no room, -2 too deep.

    Each sphere may leave the mean motion by half of the skin.
    """
    near, pairs, close, x = world.near, world.shape, world.close, world.spheres.position
    gaps(near, pairs, x, world.counts[NEAR])
    n = np.int64(0)
    for k in range(np.uintp(world.counts[NEAR])):
        if pairs.gap[k] < skin:
            if n + LANES >= len(close.i):
                return np.int64(-1)
            if pairs.gap[k] < -DEEPEST * pairs.reach[k]:
                return np.int64(-2)
            close.i[n], close.j[n], close.group[n] = near.i[k], near.j[k], k
            close.reach[n] = pairs.reach[k]
            close.constants[n, RADIUS_I] = x[near.i[k], 3]
            close.constants[n, RADIUS_J] = x[near.j[k], 3]
            close.constants[n, HERTZ], close.constants[n, MASS] = pairs.hertz[k], pairs.mass[k]
            n += 1
    world.close_seen.leeway[:] = 0.5 * skin
    return n


@inner
def gaps(near, pairs, x, n_near):
    """The gaps of all pairs of the outer list; without a branch, so that it is vectorised."""
    for k in range(np.uintp(n_near)):
        i, j = near.i[k], near.j[k]
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        pairs.gap[k] = np.sqrt(dx * dx + dy * dy + dz * dz) - pairs.reach[k]
