"""Filling by rain: particles fall on a closed door until they lie still.

All at once and without friction, which would leave large voids (the paper pours without it); or
with friction, or layer by layer, where the case says so. The contacts are a quarter as
stiff as the materials file says, which allows twice the time step; the run lets the packing
settle once more under its own law before friction is switched on.
"""

import math
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from granulab.errors import InputError, SimulationError
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.outline import Outline
from silo2d.case.shape import ShapeSet
from silo2d.engine.simulation import Simulation
from silo2d.engine.state import INV_MASS
from silo2d.engine.world import build_world
from silo2d.run.packing import Packing, in_rows, packing_fraction

LOOSE = (
    0.93  # packing fraction that the number of poured particles is reckoned with; above any seen
)
_FRAME = 5e-3  # [s] between looks at the kinetic energy
_PATIENCE = 6.0  # [s] of simulated time; a filling has settled long before

Report = Callable[[str, float, str], None]  # phase, fraction done (0 to 1), words


class Layer(NamedTuple):
    """Layer that is poured at once: from a height to a height, over what lies there [m]."""

    begin: float
    end: float
    above: float  # how high what lies there reaches, bounding circles included; 0 for nothing


def rain(
    case: SiloCase, rng: np.random.Generator, layer: Layer | None = None
) -> tuple[np.ndarray, np.ndarray, float]:
    """Kinds (n,) and poses (n, 3) of enough particles for a layer, none touching another.

    They stand in staggered rows from the door up, or above what lies there, in the silo and over
    it, each rotated at random; the lower they start, the sooner they lie still. Also returns how
    far [m] the side walls must be prolonged to hold them. Without a layer it is the whole filling.
    """
    from shapely import LineString, Polygon

    radius = case.shapes.bounding_radius
    pitch = 2.05 * radius
    begin, end, above = layer or Layer(0.0, case.settings.fill.level, 0.0)
    area = case.outline.area_below(end) - (case.outline.area_below(begin) if begin else 0.0)
    n = math.ceil(area * LOOSE / case.shapes.mean_area)
    high = case.outline.raised(above + n * pitch)  # more than enough: one particle a row
    free = Polygon(high.polygon).buffer(-1.02 * radius)
    left, bottom, right, top = free.bounds if not free.is_empty else (0.0, 0.0, 0.0, 0.0)
    positions: list[tuple[float, float]] = []
    y = max(bottom, above + radius if above else bottom) + 1e-3 * pitch
    staggered = False
    while len(positions) < n and y < top:
        stretch = free.intersection(LineString([(left - 1, y), (right + 1, y)]))
        for line in getattr(stretch, "geoms", [stretch]):
            if line.is_empty:
                continue
            left_end, _, right_end, _ = line.bounds
            # Every second row stands over the gaps of the one below.
            first = left + (pitch / 2 if staggered else 0.0)
            columns = range(
                math.ceil((left_end - first) / pitch), math.floor((right_end - first) / pitch) + 1
            )
            positions += [(first + k * pitch, y) for k in columns]
        y += math.sqrt(0.75) * pitch
        staggered = not staggered
    n = len(positions)
    if not n:
        raise InputError(
            f"{case.name}: the silo is too small for its particles: it must be wider than "
            f"{2.04e3 * radius:.3g} mm somewhere, a largest particle and a little more"
        )
    kinds = rng.choice(len(case.shapes.shapes), size=n, p=case.shapes.shares)
    poses = np.column_stack([positions, rng.uniform(0, 2 * math.pi, n)])
    return kinds, poses, max(y - case.outline.height, 0.0) + pitch


def pour(case: SiloCase, seed: int, report: Report) -> Packing:
    """Fill the silo with the case's own engine: at once, or by layers of a height.

    Each layer falls on those below, settles, is levelled off at its height and settles again.
    """
    rng, level = np.random.default_rng(seed), case.settings.fill.level
    height = case.settings.fill.layer or level
    n_layers = max(math.ceil(level / height - 1e-9), 1)
    kinds, poses = np.zeros(0, np.int64), np.zeros((0, 3))
    begun = 0.0
    for k in range(n_layers):
        top = (poses[:, 1].max() + case.shapes.bounding_radius) if len(poses) else 0.0
        layer = Layer(k * height, min((k + 1) * height, level), top)
        more, positions, above = rain(case, rng, layer)
        kinds, poses = np.concatenate([kinds, more]), np.concatenate([poses, positions])
        sim = pouring(case, kinds, poses, case.outline.raised(above))
        if k == 0:
            sim.compile()
            begun = time.process_time()
        which = f" layer {k + 1} of {n_layers}" if n_layers > 1 else ""
        settle(sim, case, report, f"pouring{which}", down_at(positions, layer.end))
        kinds, poses = level_off(case, kinds, sim.poses(), layer.end)
        sim = pouring(case, kinds, poses, case.outline)
        settle(sim, case, report, f"levelling{which}")
        poses = sim.poses()
    return packed(case, sim, kinds, "dem", time.process_time() - begun)


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
    return Simulation(world, "fill to a lower level, or with a stiffer materials file")


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
    return Packing(kinds, poses, fraction, sim.coordination(), poured_with, cpu_s)


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
        sim.run(steps)
        moving = normalised_kinetic_energy(sim, case.shapes)
        start = max(start or 0.0, moving)
        if moving < case.settings.fill.settled and sim.time >= soonest:
            return
        done = part_settled(start, moving, case.settings.fill.settled)
        report(phase, done, f"t = {sim.time:.2f} s")
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


def normalised_kinetic_energy(sim: Simulation, shapes: ShapeSet) -> float:
    """Kinetic energy over what lifts each particle by its size (root of its area) [-]."""
    rows = sim.rows[sim.live]
    weight = GRAVITY * (1.0 / rows[:, INV_MASS]).sum()
    kinetic = sim.energies()["kinetic"]
    return kinetic / (weight * math.sqrt(shapes.mean_area)) if len(rows) else 0.0
