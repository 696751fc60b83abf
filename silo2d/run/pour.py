"""Filling by rain: particles fall on a closed door until they lie still.

All at once and without friction, which would leave large voids (the paper pours without it); or
with friction, or layer by layer, where the case says so. The contacts are the filling's own
(silo2d/case/filling.py); the run lets the packing settle once more under its own law before
friction is switched on.
"""

import dataclasses
import math
import time
from collections.abc import Callable

import numpy as np

from granulab.campaign.runs.sharing import shared_by
from granulab.errors import SimulationError
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.filling import (
    LOOSE,
    PITCH,
    USUAL_FRACTION,
    Layer,
    layers_of,
    rows_of_rain,
    stiffened,
)
from silo2d.case.outline import Outline
from silo2d.case.plan import FALLING, collapse, cpu_of_step
from silo2d.case.shape import ShapeSet
from silo2d.engine.simulation import Simulation
from silo2d.engine.state import INV_MASS
from silo2d.engine.world import build_world
from silo2d.run.packing import Packing, in_rows, packing_fraction
from silo2d.run.rest import LOOKS

_FRAME = 5e-3  # [s] between looks at the kinetic energy
_SAMPLES = 5  # of the forces at the walls from look to look
_POURING = 0.95  # part of the cost of a layer that is poured and levelled
_SLOWED = 1.5  # over the mean, how slow the decay of the energy is once the rain is down
_ASIDE = 0.014  # of the largest bounding radius: within what the rain leaves free on each side
_PATIENCE = 6.0  # [s] of simulated time; a filling has settled long before

_ATTEMPTS = 4

Report = Callable[[str, float, str], None]  # phase, fraction done (0 to 1), words


def rain(
    case: SiloCase, rng: np.random.Generator, layer: Layer | None = None
) -> tuple[np.ndarray, np.ndarray, float]:
    """Kinds (n,) and poses (n, 3) of enough particles for a layer, none touching another.

    They stand in staggered rows from the door up, or above what lies there, in the silo and over
    it, each rotated at random; the lower they start, the sooner they lie still. Discs of one size,
    which no angle tells apart, stand off their places at random. Also returns how
    far [m] the side walls must be prolonged to hold them. Without a layer it is the whole filling.
    """
    positions, top = rows_of_rain(
        case.outline, case.shapes, layer or Layer(0.0, case.settings.fill.level, 0.0)
    )
    n = len(positions)
    kinds = kinds_of(case.shapes, n, rng)
    poses = np.column_stack([positions, rng.uniform(0, 2 * math.pi, n)])
    if len(case.shapes.shapes) == 1 and len(case.shapes.shapes[0].core) == 1:
        aside = _ASIDE * case.shapes.bounding_radius
        poses[:, :2] += rng.uniform(-aside, aside, (n, 2))
    return kinds, poses, max(top - case.outline.height, 0.0) + PITCH * case.shapes.bounding_radius


def kinds_of(shapes: ShapeSet, n: int, rng: np.random.Generator) -> np.ndarray:
    """Kinds (n,) of the rain: by chance, or each in its share, at random places.

    In its share where sizes differ so much that chance could leave too few large ones to reach the
    level: within three standard deviations of their summed area.
    """
    shares, areas = np.array(shapes.shares), np.array([shape.area for shape in shapes.shapes])
    scatter = math.sqrt(shares @ (areas / shapes.mean_area - 1) ** 2 / n)
    if 3 * scatter < 1 - USUAL_FRACTION / LOOSE:
        return rng.choice(len(areas), size=n, p=shapes.shares)
    # Systematic sampling, by size: the area is right within that of a largest one.
    by_size = np.argsort(areas)
    below = np.cumsum(shares[by_size])[:-1]
    return rng.permutation(by_size[np.searchsorted(below, (np.arange(n) + rng.uniform()) / n)])


def pour(case: SiloCase, seed: int, report: Report) -> Packing:
    """Fill the silo with the case's own engine: at once, or by layers of a height.

    What does not come to rest is poured again from the same seed, four times as stiff and in steps
    half as long, a few times; raises the last SimulationError.
    """
    for attempt in range(1, _ATTEMPTS):
        try:
            return _poured(case, seed, report, attempt)
        except SimulationError:
            case = dataclasses.replace(
                case,
                pour_laws=(stiffened(case.pour_laws[0]), stiffened(case.pour_laws[1])),
                pour_time_step=case.pour_time_step / 2,
            )
    return _poured(case, seed, report, _ATTEMPTS)


def _poured(case: SiloCase, seed: int, report: Report, attempt: int) -> Packing:
    """Fill the silo, layer by layer.

    Each layer falls on those below, settles, is levelled off at its height and settles again.
    """
    rng, layers = np.random.default_rng(seed), layers_of(case.settings.fill)
    kinds, poses = np.zeros(0, np.int64), np.zeros((0, 3))
    begun = 0.0
    for k, (begin, end) in enumerate(layers):
        top = (poses[:, 1].max() + case.shapes.bounding_radius) if len(poses) else 0.0
        more, positions, above = rain(case, rng, Layer(begin, end, top))
        kinds, poses = np.concatenate([kinds, more]), np.concatenate([poses, positions])
        sim = pouring(case, kinds, poses, case.outline.raised(above))
        if k == 0:
            sim.compile()
            begun = time.process_time()
        again = f" again ({attempt} of {_ATTEMPTS})" if attempt > 1 else ""
        which = f" layer {k + 1} of {len(layers)}" if len(layers) > 1 else ""
        own = _of_layer(report, k, len(layers))
        settle(sim, case, own, f"pouring{which}{again}", down_at(positions, end))
        kinds, poses = level_off(case, kinds, sim.poses(), end)
        sim = pouring(case, kinds, poses, case.outline)
        settle(sim, case, own, f"levelling{which}{again}")
        poses = sim.poses()
    made = packed(case, sim, kinds, "dem", time.process_time() - begun)
    return dataclasses.replace(made, attempts=attempt)


def _of_layer(report: Report, k: int, n_layers: int) -> Report:
    """Report of layer k alone, for its part of the whole: it costs the more, the more lie below."""

    def own(phase: str, fraction: float, words: str) -> None:
        levelling = phase.startswith("levelling")
        part = _POURING + (1 - _POURING) * fraction if levelling else _POURING * fraction
        report(phase, (k * (k + 3) + 2 * (k + 2) * part) / (n_layers * (n_layers + 3)), words)

    return own


def pouring(case: SiloCase, kinds: np.ndarray, poses: np.ndarray, outline: Outline) -> Simulation:
    """A simulation of the filling under its own laws, the door closed."""
    world = build_world(
        case.shapes.shapes,
        kinds,
        poses,
        outline.walls(),
        surface_density=case.surface_density,
        particle_law=case.pour_laws[0],
        wall_law=case.pour_laws[1],
        gravity=GRAVITY,
        time_step=case.pour_time_step,
    )
    sim = Simulation(world, "fill to a lower level, or with a stiffer materials file")
    sim.share(shared_by(cpu_of_step(case)))
    return sim


def level_off(
    case: SiloCase, kinds: np.ndarray, poses: np.ndarray, level: float | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """The particles up to a level [m], that of the filling if none is given, numbered in rows."""
    below = poses[:, 1] <= (case.settings.fill.level if level is None else level)
    return in_rows(kinds[below], poses[below], 2 * case.shapes.bounding_radius)


def packed(
    case: SiloCase, sim: Simulation, kinds: np.ndarray, poured_with: str, cpu_s: float
) -> Packing:
    """The packing that a simulation has come to."""
    poses = sim.poses()
    fraction = packing_fraction(
        case.outline, case.shapes, kinds, poses[:, 1], case.settings.fill.level
    )
    return Packing(
        kinds, poses, fraction, sim.coordination(), poured_with, cpu_s, at_walls=sim.wall_samples()
    )


def down_at(poses: np.ndarray, level: float) -> float:
    """Earliest time [s] at which the highest particle of the rain can be at a level [m]."""
    drop = max(poses[:, 1].max() - level, 0.0)
    return math.sqrt(2 * drop / GRAVITY)


def settle(
    sim: Simulation, case: SiloCase, report: Report, phase: str, soonest: float = 0.0
) -> None:
    """Run until the kinetic energy is a small part of what lifts every particle by its own size.

    Not before `soonest` [s]: rain that has just begun to fall is slow as well. Raises
    SimulationError if it does not come to rest in a long time.
    """
    steps = max(round(_FRAME / sim.world.time_step), 1)
    start = None
    while True:
        for part in np.diff(np.linspace(0, steps, _SAMPLES + 1).astype(int)):
            sim.run(int(part))
            sim.sample_walls(most=LOOKS)
        moving = normalised_kinetic_energy(sim, case.shapes)
        start = max(start or 0.0, moving)
        if moving < case.settings.fill.settled and sim.time >= soonest:
            return
        settled = part_settled(start, moving, case.settings.fill.settled)
        report(phase, part_done(case, sim.time, soonest, settled), f"t = {sim.time:.2f} s")
        if sim.time > _PATIENCE:
            raise SimulationError(
                f"the {phase} did not come to rest within {_PATIENCE:g} s; allow more motion with "
                f"[fill] settled (now {case.settings.fill.settled:g})"
            )


def part_settled(start: float, moving: float, enough: float) -> float:
    """Part (0 to 1) of the way from `start` to `enough` of a normalised kinetic energy.

    Once the rain is down it decays exponentially, more or less.
    """
    if start <= enough:
        return 0.0
    return min(math.log(start / moving) / math.log(start / enough), 1.0)


def part_done(case: SiloCase, time: float, soonest: float, settled: float) -> float:
    """Part (0 to 1) of the cost of a settling that is done, so many seconds after its beginning.

    soonest: when [s] all can be down; settled: part of the way to rest, see part_settled.
    """
    down = min(time, soonest)
    left = FALLING * (soonest - down) + collapse(case) * min(_SLOWED * (1.0 - settled), 1.0)
    done = FALLING * down + (time - down)
    return done / (done + left)


def normalised_kinetic_energy(sim: Simulation, shapes: ShapeSet) -> float:
    """Kinetic energy over what lifts each particle by its size (root of its area) [-]."""
    rows = sim.rows[sim.live]
    weight = GRAVITY * (1.0 / rows[:, INV_MASS]).sum()
    kinetic = sim.energies()["kinetic"]
    return kinetic / (weight * math.sqrt(shapes.mean_area)) if len(rows) else 0.0
