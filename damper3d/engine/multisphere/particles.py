"""Particles that are rigid clusters of spheres and rotate: their arrays.

Only the spheres that stand in a list are kept up to date ("active").
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from damper3d.engine.multisphere.form import (
    Alike,
    Particle,
    Particles,
    Unlike,
    first_spheres,
    rows_of_spheres,
    whole,
)
from damper3d.engine.multisphere.motion import note_angular_velocity, note_axes
from damper3d.engine.state import World, zeros

# What becomes of several contacts of one particle with another, or with a wall.
TREATMENTS = ("sum", "deepest", "scaled")
SUM, DEEPEST, SCALED = range(3)


class Scratch(NamedTuple):
    """Capacity for the search within a pair of particles, and for the treatment of its contacts."""

    way: np.ndarray  # (n,) how far each particle has come since the list was made [m]
    height: np.ndarray  # (2, K) how far each sphere of either reaches along a direction [m]
    sphere: np.ndarray  # (2, k) those that may be near the other particle
    centre: np.ndarray  # (2, 4, k) their centres and radii [m], from the first's centroid
    gap: np.ndarray  # (k,) of one of them to all of the other particle [m]
    depth: np.ndarray  # (capacity,) overlap of each contact that touches [m]
    listed: np.ndarray  # (m,) whether a sphere stands in a list


class KnownPairs(NamedTuple):
    """Directions and gaps of the pairs of the outer list, and of the list before it."""

    direction: np.ndarray  # (capacity, 4) unit vector from i to j across which they were seen last
    free: np.ndarray  # (capacity,) a gap that they have at least [m]
    old_i: np.ndarray  # (capacity,) uint32
    old_j: np.ndarray  # (capacity,) uint32
    old_direction: np.ndarray
    old_free: np.ndarray


class ManySpheres(NamedTuple):
    """The shapes of all particles, and the arrays of their search."""

    form: Any  # form.Alike or form.Unlike
    treatment: int
    active: np.ndarray  # (m,) uint32 spheres that stand in a list, ascending
    active_first: np.ndarray  # (n + 1,) where those of each particle begin
    pairs: KnownPairs
    scratch: Scratch


class RigidMotion(NamedTuple):
    """Rigid particles, (n, 4) or (n,)."""

    position: np.ndarray  # of the centroid [m]; radius of the bounding sphere [m]
    orientation: np.ndarray  # unit quaternion (w, x, y, z), from own axes to the laboratory's
    axes: np.ndarray  # (n, 12) the own x, y and z in the laboratory, rows of four; from it
    velocity: np.ndarray  # half a step behind [m/s]
    momentum: np.ndarray  # angular, in the laboratory, half a step behind [kg m2/s]
    velocity_now: np.ndarray  # extrapolated to the time of the position [m/s]
    momentum_now: np.ndarray  # likewise [kg m2/s]
    angular_velocity_now: np.ndarray  # likewise [rad/s]
    force: np.ndarray  # on the particle in this step [N]
    torque: np.ndarray  # about the centroid [N m]
    inverse_mass: np.ndarray  # (n,) [1/kg]
    dissipated: np.ndarray  # (m + 1,) of each sphere, half of what its contacts dissipated [J]


def shape_of(form: Alike | Unlike, n: int, treatment: str) -> ManySpheres:
    """Return what the kernels know of n particles; no list has a capacity yet."""
    m = int(first_spheres(form, n)[-1])
    return ManySpheres(
        form=form,
        treatment=TREATMENTS.index(treatment),
        active=np.zeros(m + 1, np.uint32),
        active_first=np.zeros(n + 1, np.int64),
        pairs=known_pairs(0),
        scratch=_scratch(n, most_spheres(form), m),
    )


def most_spheres(form: Alike | Unlike) -> int:
    """Largest number of spheres of a particle."""
    return form.most if isinstance(form, Unlike) else len(form.offset)


def known_pairs(capacity: int) -> KnownPairs:
    """Capacity for what is known of pairs."""
    return KnownPairs(
        direction=zeros(capacity, 4),
        free=np.zeros(capacity),
        old_i=np.zeros(capacity, np.uint32),
        old_j=np.zeros(capacity, np.uint32),
        old_direction=zeros(capacity, 4),
        old_free=np.zeros(capacity),
    )


def _scratch(n: int, k: int, m: int) -> Scratch:
    """Capacity for n particles, of at most k spheres each and m together."""
    return Scratch(
        way=np.zeros(n),
        height=zeros(2, whole(k)),
        sphere=np.zeros((2, k), np.int64),
        centre=zeros(2, 4, k),
        gap=zeros(k),
        depth=np.zeros(0),
        listed=np.zeros(m, np.uint8),
    )


def at_rest(
    positions: np.ndarray, orientations: np.ndarray | None, particles: Particles, mass: np.ndarray,
    m: int,
) -> RigidMotion:  # fmt: skip
    """Particles at rest, of m spheres together.

    positions (n, 3) [m]; orientations (n, 4), of no rotation if left out; mass (n,) [kg].
    """
    n = len(positions)
    rows = ("position", "orientation", "velocity", "momentum", "velocity_now", "momentum_now",
            "angular_velocity_now", "force", "torque")  # fmt: skip
    made = RigidMotion(
        **{name: zeros(n, 4) for name in rows},
        axes=zeros(n, 12),
        inverse_mass=1.0 / mass,
        dissipated=np.zeros(m + 1),
    )
    made.position[:, :3] = positions
    made.position[:, 3] = of_each(particles, n, lambda one: one.bounding_radius)
    made.orientation[:] = [1.0, 0.0, 0.0, 0.0] if orientations is None else orientations
    return made


def of_each(particles: Particles, n: int, number: Callable[[Particle], float]) -> np.ndarray:
    """A number of each of n particles (n,)."""
    if isinstance(particles, Sequence):
        return np.array([number(one) for one in particles])
    return np.full(n, number(particles))


def moving(world: World) -> dict[str, np.ndarray]:
    """Views of all arrays that say where the particles are and how they move.

    Those that end in _now are extrapolated to the time of the positions.
    """
    names = ("position", "orientation", "velocity", "momentum", "velocity_now", "momentum_now")
    return {name: getattr(world.particles, name) for name in names}


def angular_velocity_now(world: World) -> np.ndarray:
    """Angular velocities now (n, 4) [rad/s]."""
    return np.asarray(world.particles.angular_velocity_now)


def settle(world: World) -> None:
    """Axes and angular velocities of all particles, from orientations and momenta."""
    for b in range(len(world.particles.inverse_mass)):
        note_axes(world.particles, b)
        note_angular_velocity(world.particles, world.shape.form, b)


def set_angular_velocity(world: World, angular_velocity: np.ndarray) -> None:
    """Let the particles rotate at (n, 3) [rad/s], now and half a step ago."""
    now = world.particles
    axes = now.axes.reshape(-1, 3, 4)[:, :, :3]
    along = np.einsum("nkc,nc->nk", axes, angular_velocity)
    along /= world.shape.form.inverse_inertia
    now.momentum[:, :3] = np.einsum("nkc,nk->nc", axes, along)
    now.momentum_now[:] = now.momentum
    now.angular_velocity_now[:, :3] = angular_velocity


def extents(world: World, up: np.ndarray) -> np.ndarray:
    """Extent of each particle from its centroid along a unit vector (n,) [m]."""
    form, axes = world.shape.form, world.particles.axes.reshape(-1, 3, 4)[:, :, :3]
    if isinstance(form, Unlike):
        rows = form.offset[rows_of_spheres(form, len(axes))]
        spheres = np.einsum("mkc,c,mk->m", axes[form.whose], up, rows[:, :3]) + rows[:, 3]
        return np.maximum.reduceat(spheres, form.first[:-1])
    spheres = np.einsum("nkc,c,sk->ns", axes, up, form.offset[:, :3]) + form.offset[:, 3]
    return spheres.max(axis=1)


def first_sphere_of_each(world: World) -> np.ndarray:
    """Number of the first sphere of each particle, and of all spheres (n + 1,)."""
    return first_spheres(world.shape.form, len(world.particles.inverse_mass))
