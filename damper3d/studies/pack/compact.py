"""Random close packing: frictionless particles in a periodic cube that shrinks until they jam.

The protocol of O'Hern et al. (2003), Phys. Rev. E 68, 011306: from positions drawn at random, the
cube shrinks in small steps, and in each the particles move down the energy of their overlaps, as
engine.growth.periodic says. Where overlaps stay, the cube grows again by half of the last step, and
so on to a resolution of 2e-4 of the fraction. No gravity, no friction, no walls: what is left is
the shape. It is the first jammed state that a random start is driven into, the densest that is not
ordered; friction or gravity would only stop it earlier. The volume is that of the smooth shape.
"""

import math
import time
from dataclasses import dataclass

import numpy as np

from damper3d.engine.growth.periodic import SIDE, Cell, relaxed, touching
from damper3d.engine.growth.relaxation import AT_REST, INNER_FULL
from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.multisphere import sphere as ball_of
from granulab.campaign.runs.protocol import Stop
from granulab.errors import InputError, Stopped

ALLOWED = 1e-4  # overlap over equal-volume radius that may be left: 2e-4 of the fraction at most
RESOLUTION = 2e-4  # of the fraction between the last state that is free and the first that jams
EXCESS = 3e-4  # of the fraction above jamming at which neighbours are counted
_STEP = 0.01  # of the fraction between relaxations, at first
_START = 0.3  # fraction of the bounding spheres to begin with, so that no ring holds one
_DENSEST = 0.75  # no random packing of like particles is known to be denser: capacity for images
_STEADY = 1e-4  # force that is left over the mean push where a state counts as balanced
_PATIENCE = 50_000  # steps of a relaxation; those about jamming take some thousands


@dataclass(frozen=True)
class Compaction:
    """A jammed packing in a periodic cube."""

    fraction: float  # volume of the smooth particles over that of the cube [-]
    coordination: float  # neighbours of those that are held, at EXCESS above jamming [-]
    rattlers: float  # share of the particles that nothing holds [-]
    overlap: float  # deepest, over the equal-volume radius [-]
    cpu_s: float


def compact(
    particle: MultiSphere, bodies: int, seed: int, stop: Stop = lambda: False
) -> Compaction:
    """Jam so many particles, from a seed.

    Raises InputError where the cube would be so small that a particle meets its own image, and
    Stopped where `stop` says so.
    """
    begun = time.process_time()
    least_bodies(particle, bodies)
    cell, fraction = _scattered(particle, bodies, np.random.default_rng(seed))
    step, jams_before, free = _STEP, False, (fraction, 0.0)
    while step > RESOLUTION:
        if stop():
            raise Stopped("the same command packs them again, from their seed")
        cell, outcome, overlap = _relaxed(cell, ALLOWED)
        jams = outcome != AT_REST
        free = free if jams else (fraction, overlap)
        if jams != jams_before:
            step /= 2.0
        jams_before = jams
        fraction += -step if jams else step
        squeeze(cell, fraction)
    fraction, overlap = free
    squeeze(cell, fraction + EXCESS)
    cell = _relaxed(cell, 0.0)[0]
    neighbours, held = coordination(touching(cell))
    return Compaction(fraction, neighbours, 1.0 - held, overlap, time.process_time() - begun)


def protocol() -> dict[str, float]:
    """The numbers that say how it is done."""
    return {"allowed": ALLOWED, "resolution": RESOLUTION, "excess": EXCESS, "step": _STEP,
            "start": _START, "steady": _STEADY, "patience": _PATIENCE}  # fmt: skip


def squeeze(cell: Cell, fraction: float) -> None:
    """Give the cube the size of a packing fraction; positions scale with it."""
    side = side_of(fraction, len(cell.position))
    cell.position[:] *= side / cell.measure[SIDE]
    cell.measure[SIDE] = side


def side_of(fraction: float, bodies: int) -> float:
    """Side of a cube in equal-volume radii, by the fraction of it that the particles take."""
    return (bodies * 4.0 / 3.0 * math.pi / fraction) ** (1 / 3)


def cell_of(
    particle: MultiSphere, positions: np.ndarray, orientations: np.ndarray, side: float
) -> Cell:
    """Particles at positions (n, 3) in a cube with unit quaternions (n, 4)."""
    radius, n, k = particle.equal_volume_radius, len(positions), len(particle.radii)
    gyration = math.sqrt(float(np.mean(particle.inertia)) / particle.volume) / radius
    return Cell(
        position=positions,
        turn=orientations,
        offset=np.column_stack([particle.offsets, particle.radii]) / radius,
        arm=np.zeros((n * k, 3)),
        **_list_of(16 * n + 16 * k),
        made_at=np.zeros((n, 3)),
        facing=np.zeros((n, 4)),
        measure=np.array([side, particle.bounding_radius / radius, gyration, 0.1]),
        tally=np.zeros(3, np.int64),
    )


def coordination(neighbours: np.ndarray) -> tuple[float, float]:
    """Mean neighbours of the particles that are held, and their share, from (n, n) bools.

    A particle is held by four neighbours or more that are held themselves (three cannot balance a
    sphere in space, but for one in their plane).
    """
    held = np.ones(len(neighbours), bool)
    while True:
        numbers = neighbours[:, held].sum(axis=1)
        still = held & (numbers >= 4)
        if (still == held).all():
            break
        held = still
    return (float(numbers[held].mean()) if held.any() else 0.0), float(held.mean())


def least_bodies(particle: MultiSphere, bodies: int) -> None:
    """Raise InputError where so few particles would meet their own images."""
    size = 2.0 * particle.bounding_radius / particle.equal_volume_radius
    least = math.ceil(_DENSEST * size**3 / (4.0 / 3.0 * math.pi))
    if bodies < max(least, 2):
        raise InputError(
            f"bodies = {bodies}: must be at least {max(least, 2)} of {particle.name}, or one would "
            "meet itself across the periodic cell; 100 is usual"
        )


def _scattered(particle: MultiSphere, bodies: int, rng: np.random.Generator) -> tuple[Cell, float]:
    """Particles at random positions and orientations whose bounding spheres are apart."""
    side = side_of(_START, bodies)
    orientations = rng.normal(size=(bodies, 4))  # evenly over all orientations (Muller 1959)
    orientations /= np.linalg.norm(orientations, axis=1)[:, None]
    positions = rng.uniform(0.0, side, size=(bodies, 3))
    spheres = _relaxed(cell_of(ball_of(1.0), positions, orientations.copy(), side), ALLOWED)[0]
    bounding = particle.bounding_radius / particle.equal_volume_radius
    cell = cell_of(particle, spheres.position * bounding, orientations, side * bounding)
    return cell, _START / bounding**3


def _relaxed(cell: Cell, allowed: float) -> tuple[Cell, int, float]:
    """The cell after a relaxation, with a longer list where it lacked capacity; how it ended."""
    while True:
        outcome, overlap = relaxed(cell, allowed, _PATIENCE, _STEADY)
        if outcome != INNER_FULL:
            return cell, outcome, overlap
        cell = cell._replace(**_list_of(2 * len(cell.first)))


def _list_of(capacity: int) -> dict[str, np.ndarray]:
    return {
        "first": np.zeros(capacity, np.int64),
        "second": np.zeros(capacity, np.int64),
        "image": np.zeros((capacity, 3)),
    }
