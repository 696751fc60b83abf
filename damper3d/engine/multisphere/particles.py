"""Particles that are rigid clusters of spheres, all alike, and rotate: their arrays.

Only the spheres that stand in a list are kept up to date ("active").
"""

from typing import NamedTuple, Protocol

import numpy as np

from damper3d.engine.multisphere.motion import note_angular_velocity, note_axes
from damper3d.engine.state import LANES, World, zeros

# What becomes of several contacts of one particle with another, or with a wall.
TREATMENTS = ("sum", "deepest", "scaled")
SUM, DEEPEST, SCALED = range(3)

_ROUNDING = 1e-9  # by which moments may differ that are meant to be equal


class Particle(Protocol):
    """A multi-sphere particle in its principal axes about its centroid, as the engine needs it."""

    @property
    def offsets(self) -> np.ndarray:
        """Centres of the spheres (k, 3) [m]."""

    @property
    def radii(self) -> np.ndarray:
        """Radii of the spheres (k,) [m]."""

    @property
    def volume(self) -> float:
        """Volume of the smooth shape [m3]."""

    @property
    def inertia(self) -> np.ndarray:
        """Principal moments over the density (3,) [m5]."""

    @property
    def bounding_radius(self) -> float:
        """Radius of the sphere about the centroid that holds the particle [m]."""

    @property
    def smallest_radius(self) -> float:
        """Radius of its smallest sphere [m]."""


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
    """The shape of all particles in principal axes about the centroid, and its search's arrays."""

    offset: np.ndarray  # (k, 4) centre of each sphere, its radius [m]
    columns: np.ndarray  # (4, K) transposed; with as many that extend nowhere as fill vectors
    arm: float  # distance of the farthest centre from the centroid [m]
    inverse_inertia: np.ndarray  # (3,) of the principal moments [1/(kg m2)]
    odd: int  # the axis about which it is, or may be, as round as about no other
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


def shape_of(particle: Particle, density: float, n: int, treatment: str) -> ManySpheres:
    """Return what the kernels know of n such particles; no list has a capacity yet."""
    inertia, k = density * np.asarray(particle.inertia, float), len(particle.radii)
    odd = _odd_axis(inertia)
    others = [(odd + 1) % 3, (odd + 2) % 3]
    if abs(inertia[others[0]] - inertia[others[1]]) <= _ROUNDING * inertia.max():
        inertia[others] = inertia[others].mean()  # then its free rotation is exact
    offset = zeros(k, 4)
    offset[:, :3], offset[:, 3] = particle.offsets, particle.radii
    return ManySpheres(
        offset=offset,
        columns=columns_of(offset),
        arm=float(np.linalg.norm(particle.offsets, axis=1).max()),
        inverse_inertia=1.0 / inertia,
        odd=odd,
        treatment=TREATMENTS.index(treatment),
        active=np.zeros(n * k + 1, np.uint32),
        active_first=np.zeros(n + 1, np.int64),
        pairs=known_pairs(0),
        scratch=_scratch(n, k),
    )


def columns_of(offset: np.ndarray) -> np.ndarray:
    """Rows of spheres as columns, and more of them, which extend nowhere, to a whole of LANES."""
    columns = zeros(4, _whole(len(offset)))
    columns[3] = -np.inf
    columns[:, : len(offset)] = offset.T
    return columns


def _whole(k: int) -> int:
    """The next multiple of LANES."""
    return -(-k // LANES) * LANES


def _odd_axis(inertia: np.ndarray) -> int:
    """The axis whose two others have the most equal moments."""
    spread = [abs(inertia[(k + 1) % 3] - inertia[(k + 2) % 3]) for k in range(3)]
    return int(np.argmin(spread))


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


def _scratch(n: int, k: int) -> Scratch:
    return Scratch(
        way=np.zeros(n),
        height=zeros(2, _whole(k)),
        sphere=np.zeros((2, k), np.int64),
        centre=zeros(2, 4, k),
        gap=zeros(k),
        depth=np.zeros(0),
        listed=np.zeros(n * k, np.uint8),
    )


def at_rest(
    positions: np.ndarray, orientations: np.ndarray | None, particle: Particle, density: float
) -> RigidMotion:
    """Particles at rest; positions (n, 3) [m], orientations (n, 4), of no rotation if left out."""
    n = len(positions)
    rows = ("position", "orientation", "velocity", "momentum", "velocity_now", "momentum_now",
            "angular_velocity_now", "force", "torque")  # fmt: skip
    made = RigidMotion(
        **{name: zeros(n, 4) for name in rows},
        axes=zeros(n, 12),
        inverse_mass=np.full(n, 1.0 / (density * particle.volume)),
        dissipated=np.zeros(n * len(particle.radii) + 1),
    )
    made.position[:, :3], made.position[:, 3] = positions, particle.bounding_radius
    made.orientation[:] = [1.0, 0.0, 0.0, 0.0] if orientations is None else orientations
    return made


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
        note_angular_velocity(world.particles, world.shape, b)


def set_angular_velocity(world: World, angular_velocity: np.ndarray) -> None:
    """Let the particles rotate at (n, 3) [rad/s], now and half a step ago."""
    now = world.particles
    axes = now.axes.reshape(-1, 3, 4)[:, :, :3]
    along = np.einsum("nkc,nc->nk", axes, angular_velocity) / world.shape.inverse_inertia
    now.momentum[:, :3] = np.einsum("nkc,nk->nc", axes, along)
    now.momentum_now[:] = now.momentum
    now.angular_velocity_now[:, :3] = angular_velocity


def extents(world: World, up: np.ndarray) -> np.ndarray:
    """Extent of each particle from its centroid along a unit vector (n,) [m]."""
    offset, axes = world.shape.offset, world.particles.axes.reshape(-1, 3, 4)[:, :, :3]
    spheres = np.einsum("nkc,c,sk->ns", axes, up, offset[:, :3]) + offset[:, 3]
    return spheres.max(axis=1)
