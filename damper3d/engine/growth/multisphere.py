"""Random start of multi-sphere particles: small ones at random positions that grow and yield.

They begin so small that the bounding spheres, packed by spheres.py, do not overlap: so no ring
holds another. Then they grow as spheres do, but rotate as well. Of several overlaps of one particle
with another (or a wall) the deepest says how hard they push, and each takes part by its depth: so
the push does not grow with the number of spheres. Rotations are weighed by the mean radius of
gyration.
"""

from typing import NamedTuple

import numpy as np

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
from damper3d.engine.multisphere.motion import arm_of, note_axes
from damper3d.engine.multisphere.pairs import pairs_of_spheres
from damper3d.engine.multisphere.particles import Particle, columns_of
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
    gyration: float  # mean radius of gyration [m]


def random_places(
    enclosure: Enclosure, particle: Particle, count: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, float]:
    """Centres (count, 3) [m] and orientations (count, 4) to start with, and at what size [-]."""
    radius = particle.bounding_radius
    balls = count * 4.0 / 3.0 * np.pi * radius**3 / enclosure.volume
    first = first_size(balls, _START)
    centres, reached = grow(enclosure, count, first * radius, rng)
    turns = rng.normal(size=(count, 4))  # evenly over all orientations (Muller 1959)
    return centres, turns / np.linalg.norm(turns, axis=1)[:, None], first * reached


def grow_clusters(
    world: World, particle: Particle, first: float, grown: Grown | None = None
) -> float:
    """Let the particles of a world grow to their size, without overlaps; the part they reached.

    They stand where random_places put them, at their first size. Less than 1: they found no place,
    and the world is of no more use.
    """
    gyration = float(np.sqrt(np.mean(particle.inertia) / particle.volume))
    allowed = TOLERANCE * particle.smallest_radius
    n = len(world.outer.made_at)
    velocity, force = np.zeros((n, 6)), np.zeros((n, 6))

    def comes_to_rest(size: float) -> bool:
        nonlocal world
        larger = size * (1.0 + MARGIN)
        _resize(world, particle, larger)
        outcome = OUTER_FULL
        while outcome in (OUTER_FULL, INNER_FULL):
            bed = Growing(world, larger * gyration)
            outcome, _, _ = relax(bed, velocity, force, allowed, PATIENCE, 0.0)
            if outcome in (OUTER_FULL, INNER_FULL):
                world = lengthened(world, "outer" if outcome == OUTER_FULL else "inner")
        return bool(outcome == AT_REST)

    return grow_to_size(first, comes_to_rest, grown)


def _resize(world: World, particle: Particle, size: float) -> None:
    world.shape.offset[:, :3] = size * particle.offsets
    world.shape.offset[:, 3] = size * particle.radii
    world.shape.columns[:] = columns_of(world.shape.offset)
    world.particles.position[:, 3] = size * particle.bounding_radius
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
        world.lengths[OUTER_SKIN] = _OUTER_SHARE * world.particles.position[0, 3]
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
    x, axes, offset = world.particles.position, world.particles.axes, world.shape.offset
    a, b, size = np.int64(world.outer.i[k]), np.int64(world.outer.j[k]), len(offset)
    r = arm_of(axes, offset, a, np.int64(world.inner.i[m]) - a * size)
    s = arm_of(axes, offset, b, np.int64(world.inner.j[m]) - b * size)
    way = x[b, 0] + s[0] - x[a, 0] - r[0], x[b, 1] + s[1] - x[a, 1] - r[1], (
        x[b, 2] + s[2] - x[a, 2] - r[2])  # fmt: skip
    distance = np.sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2])
    if distance > 0.0:
        scale = share * world.shape.scratch.depth[m] / distance
        push = scale * way[0], scale * way[1], scale * way[2]
        add_push(force, a, r, (-push[0], -push[1], -push[2]), gyration)
        add_push(force, b, s, push, gyration)


@inner
def add_push(force, b, arm, push, gyration):
    """Add a push at the end of an arm to what moves and turns a particle."""
    torque = cross(arm, push)
    for c in range(3):
        force[b, c] += push[c]
        force[b, 3 + c] += torque[c] / gyration


@inner
def push_walls(world, gyration, force):
    """Add twice what walls push with, as they do not give way; the deepest overlap [m]."""
    deepest, gap = 0.0, world.shape.scratch.gap
    for b in range(len(world.particles.inverse_mass)):
        for w in range(len(world.walls.force)):
            if gap_to_wall(world.walls, world.particles.position, w, b, _NOWHERE) >= 0.0:
                continue
            largest = total = 0.0
            for s in range(len(world.shape.offset)):
                gap[s] = at_wall(world, w, b, s)[0]
                largest, total = max(largest, -gap[s]), total + max(-gap[s], 0.0)
            deepest = max(deepest, largest)
            for s in range(len(world.shape.offset)):
                if gap[s] < 0.0:
                    _, normal, arm = at_wall(world, w, b, s)
                    size = -2.0 * gap[s] * largest / total
                    push = size * normal[0], size * normal[1], size * normal[2]
                    add_push(force, b, arm, push, gyration)
    return deepest


@inner
def at_wall(world, w, b, s):
    """Gap of sphere s of particle b to wall w [m], the inward normal, the sphere's arm [m]."""
    walls, x, offset = world.walls, world.particles.position, world.shape.offset
    r = arm_of(world.particles.axes, offset, b, s)
    px, py, pz = x[b, 0] + r[0], x[b, 1] + r[1], x[b, 2] + r[2]
    if w < len(walls.planes):
        plane = walls.planes[w]
        distance = plane[0] * px + plane[1] * py + plane[2] * pz - plane[3]
        return distance - offset[s, 3], (plane[0], plane[1], plane[2]), r
    distance, inwards = at_curved(walls.surface, w - len(walls.planes), px, py, pz)
    return distance - offset[s, 3], inwards, r


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
    half = 0.5 * dt / gyration
    x, y, z = half * velocity[b, 3], half * velocity[b, 4], half * velocity[b, 5]
    cosine, sine = half_turn(x * x + y * y + z * z)
    old = particles.orientation
    q = old[b, 0], old[b, 1], old[b, 2], old[b, 3]
    q = product((cosine, sine * x, sine * y, sine * z), q)
    size = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for c in range(4):
        old[b, c] = q[c] / size
    note_axes(particles, b)
