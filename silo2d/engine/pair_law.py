"""Which law a pair of bodies obeys: one that its whole class shares, or one drawn for the pair.

A class of pairs, particle-particle or particle-wall, has a LinearLaw, which is the law of all its
pairs, or a DrawnLaw, which gives every pair of bodies a friction, a stiffness and a damping of its
own. The kernels ask `law_of` and its like; the type of the law decides when they are compiled, so
that a shared law costs nothing.

What a pair draws depends on the seed and on the two bodies alone, not on when they meet: all
vertex-edge contacts of two bodies share it, and it is the same after they have parted.
"""

import math
from typing import NamedTuple

import numpy as np
from numba.extending import overload

from granulab.contact.jit import njit  # before numba is used
from granulab.contact.laws import LinearLaw
from silo2d.engine.state import CLOSE, MAX_VERTICES, NEAR, WALL_KEY

# Rows of DrawnLaw.quantiles, .score and .key.
FRICTION, STIFFNESS, DAMPING = range(3)
LEVELS = 4096  # equally likely values of each quantity
_LEVEL_BITS = np.uint64(64 - 12)  # what is shifted out of 64 random bits to leave a level


class PairConstants(NamedTuple):
    """Constants of each pair of a list; all (capacity,)."""

    kn: np.ndarray  # [N/m]
    kt: np.ndarray  # [N/m]
    mu: np.ndarray  # [-]
    gamma_n: np.ndarray  # [1/s]


class DrawnLaw(NamedTuple):
    """A class of pairs, each with constants of its own.

    Per particle: a pair takes the level of (z_i + z_j)/sqrt 2, standard normal as the scores z of
    the two are, and a pair with a wall that of z_i. Per pair: a level from a hash of the bodies.
    """

    mean: LinearLaw  # what the quantiles scatter about; gamma_t and pulls are shared
    quantiles: np.ndarray  # (3, LEVELS) friction [-], kn [N/m], gamma_n/sqrt(kn) over the mean's
    score: np.ndarray  # (3, n_particles) standard normal; (3, 0): drawn per pair
    key: np.ndarray  # (3,) uint64, from the seed
    near: PairConstants  # of the near list
    close: PairConstants  # of the close list, as the force pass reads them


Law = LinearLaw | DrawnLaw  # of a class of pairs


@njit
def drawn_level(law, quantity, low, high, is_wall):
    """Which of the LEVELS equally likely values a pair of bodies, low < high, has."""
    if law.score.shape[1] == 0:
        return np.int64(hashed(law.key[quantity], low, high) >> _LEVEL_BITS)
    z = law.score[quantity, low]
    if not is_wall:
        z = (z + law.score[quantity, high]) / np.sqrt(2.0)
    share = 0.5 * (1.0 + math.erf(z / np.sqrt(2.0)))  # of the standard normal below z
    return min(np.int64(share * LEVELS), LEVELS - 1)


@njit
def hashed(key, low, high):
    """64 random bits: number (low, high) of the sequence splitmix64 that starts at `key`.

    Steele, Lea and Flood, OOPSLA 2014, doi 10.1145/2660193.2660195.
    """
    place = (np.uint64(low) << np.uint64(32)) | np.uint64(high)
    z = key + place * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@njit
def draw_pair(law, low, high, is_wall):
    """kn, kt [N/m], mu [-] and gamma_n [1/s] of a pair of bodies, low < high.

    kt/kn is held; so is gamma_n/sqrt(kn), and with it the restitution, but for its own draw.
    """
    mean = law.mean
    mu = law.quantiles[FRICTION, drawn_level(law, FRICTION, low, high, is_wall)]
    kn = law.quantiles[STIFFNESS, drawn_level(law, STIFFNESS, low, high, is_wall)]
    damping = law.quantiles[DAMPING, drawn_level(law, DAMPING, low, high, is_wall)]
    stiffer = kn / mean.kn
    return kn, mean.kt * stiffer, mu, mean.gamma_n * np.sqrt(stiffer) * damping


@njit
def draw_pairs(law, pairs, n_particles, constants):
    """Constants (n, 4) of pairs of bodies (n, 2), the lower number first; walls after particles."""
    for p in range(len(pairs)):
        low, high = pairs[p, 0], pairs[p, 1]
        kn, kt, mu, gamma_n = draw_pair(law, low, high, high >= n_particles)
        constants[p, 0], constants[p, 1], constants[p, 2], constants[p, 3] = kn, kt, mu, gamma_n


@njit
def draw_for_near(particle_law, wall_law, near, counts, n_bodies):
    """Constants of all near pairs, from their keys: one draw for each pair of bodies."""
    of = particle_law.near
    drawn = np.int64(-1)
    for c in range(counts[NEAR]):
        bodies = near.key[c] // (2 * MAX_VERTICES * MAX_VERTICES)
        if bodies == drawn:
            of.kn[c], of.kt[c] = of.kn[c - 1], of.kt[c - 1]
            of.mu[c], of.gamma_n[c] = of.mu[c - 1], of.gamma_n[c - 1]
            continue
        drawn = bodies
        if near.key[c] < WALL_KEY:
            values = draw_pair(particle_law, bodies // n_bodies, bodies % n_bodies, False)
        else:
            bodies -= WALL_KEY // (2 * MAX_VERTICES * MAX_VERTICES)
            values = draw_pair(wall_law, bodies // n_bodies, bodies % n_bodies, True)
        of.kn[c], of.kt[c], of.mu[c], of.gamma_n[c] = values


@njit
def hand_on_to_close(law, close, counts):
    """Constants of the close pairs, from the near list."""
    near, of = law.near, law.close
    for n in range(np.uintp(counts[CLOSE])):
        c = close.near[n]
        of.kn[n], of.kt[n] = near.kn[c], near.kt[c]
        of.mu[n], of.gamma_n[n] = near.mu[c], near.gamma_n[c]


# What the other kernels ask, by the type of the law: the plain functions run without numba, and
# their overloads are compiled.


def law_of(law, n):
    """The LinearLaw of pair n of the close list."""
    return _shared(law, n) if isinstance(law, LinearLaw) else _of_close(law, n)


@overload(law_of)
def _law_of(law, n):
    return _shared if law.instance_class is LinearLaw else _of_close


def _shared(law, n):
    return law


def _of_close(law, n):
    own, mean = law.close, law.mean
    return LinearLaw(own.kn[n], own.kt[n], own.mu[n], own.gamma_n[n], mean.gamma_t, mean.pulls)


def near_kt(law, c):
    """kt [N/m] of pair c of the near list."""
    return _shared_kt(law, c) if isinstance(law, LinearLaw) else _kt_of_near(law, c)


@overload(near_kt)
def _near_kt(law, c):
    return _shared_kt if law.instance_class is LinearLaw else _kt_of_near


def _shared_kt(law, c):
    return law.kt


def _kt_of_near(law, c):
    return law.near.kt[c]


def draw_near(particle_law, wall_law, near, counts, n_bodies):
    """Give each pair of the near list the constants that it draws, where it draws any."""
    if isinstance(particle_law, DrawnLaw):
        draw_for_near(particle_law, wall_law, near, counts, n_bodies)


@overload(draw_near)
def _draw_near(particle_law, wall_law, near, counts, n_bodies):
    if particle_law.instance_class is LinearLaw:
        return lambda particle_law, wall_law, near, counts, n_bodies: None
    return lambda particle_law, wall_law, near, counts, n_bodies: draw_for_near(
        particle_law, wall_law, near, counts, n_bodies
    )


def hand_on(law, close, counts):
    """Give each pair of the close list the constants of the near list, where it has its own."""
    if isinstance(law, DrawnLaw):
        hand_on_to_close(law, close, counts)


@overload(hand_on)
def _hand_on(law, close, counts):
    if law.instance_class is LinearLaw:
        return lambda law, close, counts: None
    return lambda law, close, counts: hand_on_to_close(law, close, counts)


@njit
def draw_lists(particle_law, wall_law, near, close, counts, n_bodies):
    """Constants for the lists as they stand; both classes keep them in the same arrays."""
    draw_near(particle_law, wall_law, near, counts, n_bodies)
    hand_on(particle_law, close, counts)
