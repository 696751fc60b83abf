"""Random start of multi-sphere particles: small ones at random positions that grow and yield.

They begin so small that the bounding spheres, packed by spheres.py, do not overlap: so no ring
holds another. Then they grow as spheres do, but rotate as well. Of several overlaps of one particle
with another (or a wall) the deepest says how hard they push, and each takes part by its depth: so
the push does not grow with the number of spheres. Rotations are weighed by the mean radius of
gyration of each particle.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numba import types

from damper3d.engine.enclosures import Enclosure, Round
from damper3d.engine.geometry import copy_rows
from damper3d.engine.growth.relaxation import (
    AT_REST,
    INNER_FULL,
    MARGIN,
    OUTER_FULL,
    PATIENCE,
    PUSHED,
    TOLERANCE,
    Grown,
    displace,
    first_size,
    grow_to_size,
    push_apart,
    relax,
)
from damper3d.engine.growth.spheres import grow
from damper3d.engine.multisphere.form import Particle, Particles, first_row, first_sphere
from damper3d.engine.multisphere.motion import arm_of, note_axes
from damper3d.engine.multisphere.pairs import largest_bounding, pairs_of_spheres
from damper3d.engine.multisphere.particles import of_each
from damper3d.engine.multisphere.rotation import half_turn, product
from damper3d.engine.neighbours import outer_cutoff_left, search_outer
from damper3d.engine.state import OUTER, OUTER_SKIN, World
from damper3d.engine.walls import gap_to_wall, nearest
from damper3d.engine.world import lengthened
from granulab.contact.jit import inlined_inner, inner, specialised, substituted
from granulab.contact.vectors import cross

_START = 0.3  # fill ratio of the bounding spheres to begin with; random insertion ends near 0.38
_OUTER_SHARE = 0.2  # outer skin over the bounding radius of a particle
_NOWHERE = 0.0, 0.0, 0.0


class Growing(NamedTuple):
    """The particles of a world while they grow."""

    world: World
    gyration: Any  # mean radius of gyration, of all, or of each (n,) [m]


def random_places(
    enclosure: Enclosure, particles: Particles, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, float]:
    """Centres (count, 3) [m] and orientations (count, 4) to start with, and at what size [-]."""
    radius = _number(particles, count, lambda one: one.bounding_radius)
    balls = count * 4.0 / 3.0 * np.pi * float(np.mean(radius**3)) / enclosure.volume
    first = first_size(balls, _START)
    centres, reached = grow(enclosure, count, first * radius, rng)
    turns = rng.normal(size=(count, 4))  # evenly over all orientations (Muller 1959)
    return centres, turns / np.linalg.norm(turns, axis=1)[:, None], first * reached


def _number(particles: Particles, n: int, number: Callable[[Particle], float]) -> Any:
    """A number of all particles, or of each of n (n,)."""
    return of_each(particles, n, number) if isinstance(particles, Sequence) else number(particles)


def grow_clusters(
    world: World, particles: Particles, first: float, grown: Grown | None = None
) -> float:
    """Let the particles of a world grow to their size, without overlaps; the part they reached.

    They stand where random_places put them, at their first size. Less than 1: they found no place,
    and the world is of no more use.
    """
    n, form = len(world.outer.made_at), world.shape.form
    gyration = _number(particles, n, lambda p: float(np.sqrt(np.mean(p.inertia) / p.volume)))
    allowed = TOLERANCE * float(form.offset[:, 3].min())
    velocity, force = np.zeros((n, 6)), np.zeros((n, 6))
    full = [array.copy() for array in (form.offset, form.columns, world.particles.position[:, 3])]

    def comes_to_rest(size: float) -> bool:
        nonlocal world
        larger = size * (1.0 + MARGIN)
        _resize(world, full, larger)
        outcome = OUTER_FULL
        while outcome in (OUTER_FULL, INNER_FULL):
            bed = Growing(world, larger * gyration)
            outcome, _, _ = relax(bed, velocity, force, allowed, PATIENCE, 0.0)
            if outcome in (OUTER_FULL, INNER_FULL):
                world = lengthened(world, "outer" if outcome == OUTER_FULL else "inner")
        return bool(outcome == AT_REST)

    return grow_to_size(first, comes_to_rest, grown)


def _resize(world: World, full: Sequence[np.ndarray], size: float) -> None:
    """Let the particles have a part of their sizes, `full`: of rows, columns, bounding radii."""
    world.shape.form.offset[:] = size * full[0]
    world.shape.form.columns[:] = size * full[1]
    world.particles.position[:, 3] = size * full[2]
    world.lengths[OUTER_SKIN] = -1.0  # its cutoff is used up


@substituted(push_apart)
def _push_growing(bed, force):
    if bed.instance_class is Growing:
        return lambda bed, force: push_growing(bed.world, bed.gyration, force)
    return None


@inner
def push_growing(world, gyration, force):
    """Set what pushes and turns each particle; see relaxation.push_apart."""
    copy_rows(world.outer.now, world.particles.position)
    left = outer_cutoff_left(world.outer.now, world.outer.made_at, world.lengths[OUTER_SKIN])
    if left < 0.0:
        world.lengths[OUTER_SKIN] = _OUTER_SHARE * largest_bounding(world.particles)
        if not search_outer(world, world.lengths[OUTER_SKIN], _NOWHERE):
            world.lengths[OUTER_SKIN] = -1.0
            return OUTER_FULL, 0.0, 0.0
    force[:] = 0.0
    deepest = push_pairs(world, gyration, force)
    if deepest < 0.0:
        return INNER_FULL, 0.0, 0.0
    return PUSHED, max(deepest, push_walls(world, gyration, force)), 0.0


@inner
def push_pairs(world, gyration, force):
    """Add what particles that overlap push each other with; deepest overlap [m], -1: list full."""
    deepest = 0.0
    for k in range(world.counts[OUTER]):
        n = pairs_of_spheres(world, k, 0.0, 0)
        if n < 0:
            return -1.0
        depth, largest, total = world.shape.scratch.depth, 0.0, 0.0
        for m in range(n):
            largest, total = max(largest, depth[m]), total + depth[m]
        deepest = max(deepest, largest)
        for m in range(n):
            push_pair(world, k, m, largest / total, gyration, force)
    return deepest


@inner
def push_pair(world, k, m, share, gyration, force):
    """Add a share of overlap m of particle pair k to what pushes and turns both."""
    x, axes, form = world.particles.position, world.particles.axes, world.shape.form
    a, b = np.int64(world.outer.i[k]), np.int64(world.outer.j[k])
    r = arm_of(axes, form, a, np.int64(world.inner.i[m]) - first_sphere(form, a))
    s = arm_of(axes, form, b, np.int64(world.inner.j[m]) - first_sphere(form, b))
    way = x[b, 0] + s[0] - x[a, 0] - r[0], x[b, 1] + s[1] - x[a, 1] - r[1], (
        x[b, 2] + s[2] - x[a, 2] - r[2])  # fmt: skip
    distance = np.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
    if distance > 0.0:
        scale = share * world.shape.scratch.depth[m] / distance
        push = scale * way[0], scale * way[1], scale * way[2]
        add_push(force, a, r, (-push[0], -push[1], -push[2]), gyration)
        add_push(force, b, s, push, gyration)


def gyration_of(gyration, b):
    """Mean radius of gyration of particle b [m]."""


@specialised(gyration_of)
def _gyration_of(gyration, b):
    if isinstance(gyration, types.Array):
        return lambda gyration, b: gyration[b]
    return lambda gyration, b: gyration


@inner
def add_push(force, b, arm, push, gyration):
    """Add a push at the end of an arm to what moves and turns a particle."""
    torque = cross(arm, push)
    for c in range(3):
        force[b, c] += push[c]
        force[b, 3 + c] += torque[c] / gyration_of(gyration, b)


@inner
def push_walls(world, gyration, force):
    """Add twice what walls push with, as they do not give way; the deepest overlap [m]."""
    deepest, gap, form = 0.0, world.shape.scratch.gap, world.shape.form
    for b in range(len(world.particles.inverse_mass)):
        size = first_sphere(form, b + 1) - first_sphere(form, b)
        for w in range(len(world.walls.force)):
            if gap_to_wall(world.walls, world.particles.position, w, b, _NOWHERE) >= 0.0:
                continue
            largest = total = 0.0
            for s in range(size):
                gap[s] = at_wall(world, w, b, s)[0]
                largest, total = max(largest, -gap[s]), total + max(-gap[s], 0.0)
            deepest = max(deepest, largest)
            for s in range(size):
                if gap[s] < 0.0:
                    _, normal, arm = at_wall(world, w, b, s)
                    share = -2.0 * gap[s] * largest / total
                    push = share * normal[0], share * normal[1], share * normal[2]
                    add_push(force, b, arm, push, gyration)
    return deepest


@inner
def at_wall(world, w, b, s):
    """Gap of sphere s of particle b to wall w [m], the inward normal, the sphere's arm [m]."""
    walls, x, form = world.walls, world.particles.position, world.shape.form
    r, radius = arm_of(world.particles.axes, form, b, s), form.offset[first_row(form, b) + s, 3]
    px, py, pz = x[b, 0] + r[0], x[b, 1] + r[1], x[b, 2] + r[2]
    if w < len(walls.planes):
        plane = walls.planes[w]
        distance = plane[0] * px + plane[1] * py + plane[2] * pz - plane[3]
        return distance - radius, (plane[0], plane[1], plane[2]), r
    distance, inwards = at_curved(walls.surface, w - len(walls.planes), px, py, pz)
    return distance - radius, inwards, r


def at_curved(surface, wall, x, y, z):
    """Distance of a point from a curved wall [m], and the wall's inward normal."""


@specialised(at_curved)
def _at_curved(surface, wall, x, y, z):
    if surface.instance_class is Round:
        return lambda surface, wall, x, y, z: _at_round(surface.radius, x, y)
    return lambda surface, wall, x, y, z: _at_nearest(surface, wall, x, y, z)


@inlined_inner
def _at_round(radius, x, y):
    """The round wall by itself, as a packing must keep its bits."""
    away = max(np.sqrt(x * x + y * y), 1e-300)
    return radius - away, (-x / away, -y / away, 0.0)


@inlined_inner
def _at_nearest(surface, wall, x, y, z):
    distance, (nx, ny, nz), _ = nearest(surface, wall, x, y, z)
    return distance, (-nx, -ny, -nz)


@substituted(displace)
def _displace_growing(bed, velocity, dt):
    if bed.instance_class is Growing:
        return lambda bed, velocity, dt: displace_growing(bed.world, bed.gyration, velocity, dt)
    return None


@inner
def displace_growing(world, gyration, velocity, dt):
    """Move and rotate the particles."""
    for b in range(len(velocity)):
        displace_particle(world.particles, b, velocity, dt, gyration)


@inner
def displace_particle(particles, b, velocity, dt, gyration):
    """Move a particle, and rotate it."""
    for c in range(3):
        particles.position[b, c] += dt * velocity[b, c]
    half = 0.5 * dt / gyration_of(gyration, b)
    x, y, z = half * velocity[b, 3], half * velocity[b, 4], half * velocity[b, 5]
    cosine, sine = half_turn(x * x + y * y + z * z)
    old = particles.orientation
    q = old[b, 0], old[b, 1], old[b, 2], old[b, 3]
    q = product((cosine, sine * x, sine * y, sine * z), q)
    size = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for c in range(4):
        old[b, c] = q[c] / size
    note_axes(particles, b)
