"""Builds the arrays of a world of clusters; makes its lists longer."""

from typing import Any

import numpy as np

from damper3d.engine import state, world
from damper3d.engine.enclosures import Enclosure
from damper3d.engine.multisphere.motion import note_axes, note_spin
from damper3d.engine.multisphere.state import (
    TREATMENTS,
    BodyPairs,
    ClusterWorld,
    Kept,
    Particle,
    Rigid,
    Scratch,
    Seen,
    Shape,
)
from damper3d.engine.state import Contacts
from granulab.contact.hertz import HertzLaw

_ROUNDING = 1e-9  # by which moments may differ that are meant to be equal


def build_cluster_world(
    positions: np.ndarray,
    particle: Particle,
    orientations: np.ndarray | None = None,
    *,
    density: float,
    enclosure: Enclosure,
    pair_law: HertzLaw,
    wall_law: HertzLaw,
    shaker: Any,
    direction: np.ndarray,
    gravity: np.ndarray,
    time_step: float,
    curved_wall: bool = False,
    treatment: str = "sum",
) -> ClusterWorld:
    """A world of n like clusters at rest in an enclosure that is about to move.

    positions (n, 3) of the centroids in the enclosure's frame [m]; orientations (n, 4), unit
    quaternions (w, x, y, z), of no turn if left out; treatment is one of TREATMENTS; the others as
    in build_world.
    """
    n, k = len(positions), len(particle.radii)
    capacity = 16 * n + 16 * k + 64
    radius, largest = particle.bounding_radius, float(particle.radii.max())
    mass = density * particle.volume
    built = ClusterWorld(
        shape=shape_of(particle, density),
        bodies=_bodies(positions, orientations, radius, mass, k),
        spheres=world.spheres_of(np.tile(particle.radii, n), np.full(n * k, mass)),
        active=np.zeros(n * k + 1, np.uint32),
        active_first=np.zeros(n + 1, np.int64),
        cells=world.cells_over(enclosure, n, radius)._replace(largest=largest),
        near=_near(n, 16 * n + 64),
        close=world.contacts_with_room(0, capacity),
        close_seen=_seen(n),
        wall=world.contacts_with_room(0, capacity),
        wall_seen=_seen(n),
        kept=_kept(capacity),
        scratch=_scratch(n, k, capacity),
        walls=world.walls_of(enclosure, n * k, curved_wall),
        block=world.block(),
        counts=world.first_counts(),
        books=np.zeros(state.N_BOOKS),
        fastest=np.zeros(2),
        lengths=world.first_skins(largest),
        pair_law=pair_law,
        wall_law=wall_law,
        shaker=shaker,
        direction=world.padded(direction),
        gravity=world.padded(gravity),
        time_step=time_step,
        treatment=TREATMENTS.index(treatment),
    )
    note_all_axes(built)
    return built


def shape_of(particle: Particle, density: float) -> Shape:
    """Return what the kernels know of a cluster."""
    inertia = density * np.asarray(particle.inertia, float)
    odd = _odd_axis(inertia)
    others = [(odd + 1) % 3, (odd + 2) % 3]
    if abs(inertia[others[0]] - inertia[others[1]]) <= _ROUNDING * inertia.max():
        inertia[others] = inertia[others].mean()  # then its free rotation is exact
    offset = world.zeros(len(particle.radii), 4)
    offset[:, :3], offset[:, 3] = particle.offsets, particle.radii
    return Shape(
        offset=offset,
        columns=columns_of(offset),
        arm=float(np.linalg.norm(particle.offsets, axis=1).max()),
        inverse_inertia=1.0 / inertia,
        odd=odd,
    )


def columns_of(offset: np.ndarray) -> np.ndarray:
    """Rows of spheres as columns, and more of them, which reach nowhere, to a whole of LANES."""
    columns = world.zeros(4, whole(len(offset)))
    columns[3] = -np.inf
    columns[:, : len(offset)] = offset.T
    return columns


def whole(k: int) -> int:
    """The next multiple of LANES."""
    return -(-k // state.LANES) * state.LANES


def _odd_axis(inertia: np.ndarray) -> int:
    """The axis whose two others have the most equal moments."""
    spread = [abs(inertia[(k + 1) % 3] - inertia[(k + 2) % 3]) for k in range(3)]
    return int(np.argmin(spread))


def _bodies(
    positions: np.ndarray, orientations: np.ndarray | None, radius: float, mass: float, k: int
) -> Rigid:
    n = len(positions)
    rows = ("position", "orientation", "velocity", "momentum", "velocity_now", "momentum_now",
            "spin_now", "force", "torque")  # fmt: skip
    bodies = Rigid(
        **{name: world.zeros(n, 4) for name in rows},
        axes=world.zeros(n, 12),
        inverse_mass=np.full(n, 1.0 / mass),
        heat=np.zeros(n * k + 1),
    )
    bodies.position[:, :3], bodies.position[:, 3] = positions, radius
    bodies.orientation[:] = [1.0, 0.0, 0.0, 0.0] if orientations is None else orientations
    return bodies


def note_all_axes(built: ClusterWorld) -> None:
    """The axes and spins of all bodies, from their orientations and momenta."""
    for b in range(len(built.bodies.inverse_mass)):
        note_axes(built.bodies, b)
        note_spin(built.bodies, built.shape, b)


def _near(n: int, capacity: int) -> BodyPairs:
    return BodyPairs(
        i=np.zeros(capacity, np.uint32),
        j=np.zeros(capacity, np.uint32),
        direction=world.zeros(capacity, 4),
        free=np.zeros(capacity),
        first=np.zeros(n + 1, np.int64),
        old_j=np.zeros(capacity, np.uint32),
        old_direction=world.zeros(capacity, 4),
        old_free=np.zeros(capacity),
        old_first=np.zeros(n + 1, np.int64),
        place=world.zeros(n, 4),
    )


def _seen(n: int) -> Seen:
    return Seen(
        place=world.zeros(n, 4), turn=world.zeros(n, 4), leeway=np.zeros(n), drift=np.zeros(4)
    )


def _kept(capacity: int) -> Kept:
    return Kept(
        number=np.zeros(1, np.int64),
        key=np.zeros(capacity, np.int64),
        history=world.zeros(capacity, state.N_HISTORY),
    )


def _scratch(n: int, k: int, capacity: int) -> Scratch:
    return Scratch(
        way=np.zeros(n),
        height=world.zeros(2, whole(k)),
        sphere=np.zeros((2, k), np.int64),
        centre=world.zeros(2, 4, k),
        gap=world.zeros(k),
        depth=np.zeros(capacity),
        whole=np.zeros((capacity, 2)),
        wall_whole=np.zeros((capacity, 2)),
        listed=np.zeros(n * k, np.uint8),
    )


def roomier(old: ClusterWorld, lists: str) -> ClusterWorld:
    """The world with a list, "near", "close" or "wall", of twice the capacity."""
    n, k = len(old.bodies.inverse_mass), len(old.shape.offset)
    if lists == "near":
        return old._replace(near=world.refilled(_near(n, 2 * len(old.near.i)), old.near))
    before: Contacts = getattr(old, lists)
    capacity = 2 * len(before.i)
    longer = world.refilled(world.contacts_with_room(0, capacity), before)
    other = len((old.wall if lists == "close" else old.close).i)
    room = max(capacity, other)
    return old._replace(
        **{lists: longer},
        kept=world.refilled(_kept(room), old.kept),
        scratch=world.refilled(_scratch(n, k, room), old.scratch),
    )
