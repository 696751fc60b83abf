"""The law that a pair of bodies obeys: one that its whole class shares, or one drawn for the pair.

A class of pairs, particle-particle or particle-wall, has one law for all its pairs (LinearLaw, or a
type of its own, see register_law), or a DrawnLaw, which gives every pair of bodies a friction, a
stiffness and a damping of its own. The kernels call `law_of` and its like; the type of the law
decides when they are compiled, so that a shared law costs nothing.

What a pair draws depends on the seed and on the two bodies alone, not on when they meet: all
vertex-edge contacts of two bodies share it, and it is the same after they have parted.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from granulab.contact.jit import extend, inner, specialised, uncounted  # before numba is used
from granulab.contact.laws import LinearLaw, register
from silo2d.engine import ENGINE
from silo2d.engine.state import INNER, MAX_VERTICES, OUTER, WALL_KEY

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
    outer: PairConstants  # of the outer list
    inner: PairConstants  # of the inner list, as the force pass reads them


Law = Any  # of a class of pairs: LinearLaw, DrawnLaw, or a type of register_law


@inner
def drawn_level(law, quantity, low, high, is_wall):
    """Return which of the LEVELS equally likely values a pair of bodies, low < high, has."""
    if law.score.shape[1] == 0:
        return np.int64(hashed(law.key[quantity], low, high) >> _LEVEL_BITS)
    z = law.score[quantity, low]
    if not is_wall:
        z = (z + law.score[quantity, high]) / np.sqrt(2.0)
    share = 0.5 * (1.0 + math.erf(z / np.sqrt(2.0)))  # of the standard normal below z
    return min(np.int64(share * LEVELS), LEVELS - 1)


@inner
def hashed(key, low, high):
    """64 random bits: number (low, high) of the sequence splitmix64 that starts at `key`.

    Steele, Lea and Flood, OOPSLA 2014, doi 10.1145/2660193.2660195.
    """
    number = (np.uint64(low) << np.uint64(32)) | np.uint64(high)
    z = key + number * np.uint64(0x9E3779B97F4A7C15)
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return z ^ (z >> np.uint64(31))


@inner
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


@uncounted
def draw_pairs(law, pairs, n_particles, constants):
    """Constants (n, 4) of pairs of bodies (n, 2), the lower number first; walls after particles."""
    for p in range(len(pairs)):
        low, high = pairs[p, 0], pairs[p, 1]
        kn, kt, mu, gamma_n = draw_pair(law, low, high, high >= n_particles)
        constants[p, 0], constants[p, 1], constants[p, 2], constants[p, 3] = kn, kt, mu, gamma_n


@uncounted
def draw_for_outer(particle_law, wall_law, outer, counts, n_bodies):
    """Constants of all outer pairs, from their keys: one draw for each pair of bodies."""
    of = particle_law.outer
    drawn = np.int64(-1)
    for c in range(counts[OUTER]):
        bodies = outer.key[c] // (2 * MAX_VERTICES * MAX_VERTICES)
        if bodies == drawn:
            of.kn[c], of.kt[c] = of.kn[c - 1], of.kt[c - 1]
            of.mu[c], of.gamma_n[c] = of.mu[c - 1], of.gamma_n[c - 1]
            continue
        drawn = bodies
        if outer.key[c] < WALL_KEY:
            values = draw_pair(particle_law, bodies // n_bodies, bodies % n_bodies, False)
        else:
            bodies -= WALL_KEY // (2 * MAX_VERTICES * MAX_VERTICES)
            values = draw_pair(wall_law, bodies // n_bodies, bodies % n_bodies, True)
        of.kn[c], of.kt[c], of.mu[c], of.gamma_n[c] = values


@uncounted
def copy_to_inner(law, inner, counts):
    """Constants of the inner pairs, from the outer list."""
    outer, of = law.outer, law.inner
    for n in range(np.uintp(counts[INNER])):
        c = inner.outer[n]
        of.kn[n], of.kt[n] = outer.kn[c], outer.kt[c]
        of.mu[n], of.gamma_n[n] = outer.mu[c], outer.gamma_n[c]


# Choices of the other kernels by the type of the law: the plain functions run without numba, and
# their overloads are compiled.


def law_of(law, n):
    """Return the law of pair n of the inner list."""
    return _of_inner(law, n) if isinstance(law, DrawnLaw) else _shared(law, n)


@specialised(law_of)
def _law_of(law, n):
    return _of_inner if law.instance_class is DrawnLaw else _shared


def outer_law(law, c):
    """Return the law of pair c of the outer list."""
    return _of_outer(law, c) if isinstance(law, DrawnLaw) else _shared(law, c)


@specialised(outer_law)
def _outer_law(law, c):
    return _of_outer if law.instance_class is DrawnLaw else _also_shared


def _shared(law, n):
    return law


def _also_shared(law, c):
    return law


def _of_inner(law, n):
    own, mean = law.inner, law.mean
    return LinearLaw(own.kn[n], own.kt[n], own.mu[n], own.gamma_n[n], mean.gamma_t, mean.pulls)


def _of_outer(law, c):
    own, mean = law.outer, law.mean
    return LinearLaw(own.kn[c], own.kt[c], own.mu[c], own.gamma_n[c], mean.gamma_t, mean.pulls)


def draw_outer(particle_law, wall_law, outer, counts, n_bodies):
    """Give each pair of the outer list the constants that it draws, where it draws any."""
    if isinstance(particle_law, DrawnLaw):
        draw_for_outer(particle_law, wall_law, outer, counts, n_bodies)


@specialised(draw_outer)
def _draw_outer(particle_law, wall_law, outer, counts, n_bodies):
    if particle_law.instance_class is not DrawnLaw:
        return lambda particle_law, wall_law, outer, counts, n_bodies: None
    return lambda particle_law, wall_law, outer, counts, n_bodies: draw_for_outer(
        particle_law, wall_law, outer, counts, n_bodies
    )


def copy_constants(law, inner, counts):
    """Give each pair of the inner list the constants of the outer list, where it has its own."""
    if isinstance(law, DrawnLaw):
        copy_to_inner(law, inner, counts)


@specialised(copy_constants)
def _copy_constants(law, inner, counts):
    if law.instance_class is not DrawnLaw:
        return lambda law, inner, counts: None
    return lambda law, inner, counts: copy_to_inner(law, inner, counts)


@uncounted
def draw_lists(particle_law, wall_law, outer, inner, counts, n_bodies):
    """Draw constants for the lists as they stand; both classes keep them in the same arrays."""
    draw_outer(particle_law, wall_law, outer, counts, n_bodies)
    copy_constants(particle_law, inner, counts)


def register_law(law: type, **functions: Callable[..., Any]) -> None:
    """Let the pairs of a silo obey a law of a type of its own, see granulab.contact.laws.register.

    The kernels that call it are compiled again after an edit of the files that the functions stand
    in, and are kept apart from those of processes that do not know the law.
    """
    extend(ENGINE, law.__module__, *register(law, **functions))
