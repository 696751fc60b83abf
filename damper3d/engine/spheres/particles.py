"""Particles that are one sphere each: their arrays, and what is known of pairs of them."""

import math
from typing import Any, NamedTuple

import numpy as np

from damper3d.engine.state import World, zeros


class OneSphere(NamedTuple):
    """Constants and gaps of the pairs of spheres of the outer list."""

    cutoff: np.ndarray  # (capacity,) sum of the radii [m]
    hertz: np.ndarray  # (capacity,) (4/3) E sqrt(R) [N/m^1.5]
    mass: np.ndarray  # (capacity,) reduced mass [kg]
    gap: np.ndarray  # (capacity,) between the surfaces, when the inner list was made [m]


class SphereMotion(NamedTuple):
    """Motion of spheres, (n, 4) or (n,); velocities are half a step behind the positions."""

    velocity: np.ndarray  # [m/s]
    angular_velocity: np.ndarray  # [rad/s]
    inverse_mass: np.ndarray  # (n,) [1/kg]
    inverse_inertia: np.ndarray  # (n,) about any axis [1/(kg m2)]
    dissipated: np.ndarray  # (n + 1,) half of each contact's loss [J]; the enclosure's last


def known_pairs(capacity: int) -> OneSphere:
    """Capacity for what is known of pairs."""
    return OneSphere(*(zeros(capacity) for _ in OneSphere._fields))


def at_rest(radii: np.ndarray, density: float | np.ndarray) -> SphereMotion:
    """Solid spheres at rest; radii (n,) [m], density [kg/m3] of all, or of each."""
    n, mass = len(radii), density * 4.0 / 3.0 * math.pi * radii**3
    return SphereMotion(
        velocity=zeros(n, 4),
        angular_velocity=zeros(n, 4),
        inverse_mass=1.0 / mass,
        inverse_inertia=1.0 / (0.4 * mass * radii**2),
        dissipated=np.zeros(n + 1),
    )


def moving(world: World) -> dict[str, np.ndarray]:
    """Views of all arrays that say where the spheres are and how they move.

    Those that end in _now are extrapolated to the time of the positions.
    """
    spheres, n = world.spheres, len(world.outer.made_at)
    return {
        "position": spheres.position[:n],
        "velocity": world.particles.velocity,
        "spin": world.particles.angular_velocity,
        "velocity_now": spheres.velocity[:n],
        "spin_now": spheres.angular_velocity[:n],
    }


def angular_velocity_now(world: World) -> np.ndarray:
    """Angular velocities now (n, 4) [rad/s]."""
    return world.spheres.angular_velocity[: len(world.outer.made_at)]


def settle(world: World) -> None:
    """Bring up to date what follows from the arrays of `moving`: of spheres nothing."""


def set_angular_velocity(world: World, angular_velocity: np.ndarray) -> None:
    """Let the spheres rotate at (n, 3) [rad/s], now and half a step ago."""
    world.particles.angular_velocity[:, :3] = angular_velocity
    world.spheres.angular_velocity[: len(angular_velocity), :3] = angular_velocity


def first_sphere_of_each(world: World) -> np.ndarray:
    """Number of the first sphere of each particle, and of all spheres (n + 1,)."""
    return np.arange(len(world.outer.made_at) + 1)


def extents(world: World, up: np.ndarray) -> Any:
    """Extent of each sphere from its centre along a unit vector (n,) [m]."""
    halo = getattr(world.pair_law, "halo", 0.0)
    return world.spheres.position[: len(world.outer.made_at), 3] - halo
