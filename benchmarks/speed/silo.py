"""Scenes of the silo: a step at rest and flowing, compared with pymunk, and against the number."""

import dataclasses
from collections.abc import Callable
from functools import cache, partial

import numpy as np

from benchmarks.speed.reference import bound_us
from benchmarks.speed.timing import BOUND, HERE, Contest, Scene, cost_of, user_s
from silo2d.baseline.discharge import Baseline
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.outline import hopper
from silo2d.engine.simulation import Simulation
from silo2d.engine.world import build_world
from silo2d.run.packing import Packing, in_rows
from silo2d.run.pour import pour
from silo2d.run.protocol import settle_under_own_law, world_behind_door

COARSE = 1.1  # scale of the largest particles
CLOSED, OPEN = 0.12, 0.05  # [s] before and after the opening, until the flow is timed
STRETCH = 0.01  # [s] simulated of a discharge
PYMUNK = {"run.engine": "pymunk", "pymunk.iterations": 10, "pymunk.time_step": "0.25 ms"}
_WARM_UP = 0.02  # [s] until pymunk's impulses carry the heap; the default of its discharge


def quiet(*_: object) -> None:
    """A report that says nothing."""


@cache
def poured(silo: str, scale: float = 1.0) -> tuple[SiloCase, Packing]:
    """A silo's case and packing, its particles scaled."""
    case = SiloCase.load(silo, {"particles.scale": scale})
    return case, pour(case, 1, quiet)


def opened(case: SiloCase, packing: Packing) -> Simulation:
    """The packing under its own law with friction, at t = 0, the door still closed."""
    sim = Simulation(world_behind_door(case, packing))
    settle_under_own_law(sim, case, quiet)
    sim.begin_phase(case.particle_law, case.wall_law, case.time_step)
    return sim


def open_door(sim: Simulation, case: SiloCase) -> None:
    """Take the door away."""
    sim.remove_wall(len(case.outline.walls().names) - 1)


def against_bound(sim: Simulation, steps: int, per_step: float = 1.0) -> Contest:
    """Steps of a simulation and their bound, both over `per_step`, as us."""

    def here() -> float:
        return cost_of(lambda: sim.run(steps), 1e-6 * steps) / per_step

    return Contest(
        {HERE: here, BOUND: lambda: bound_us(len(sim.touching()), len(sim.live)) / per_step}
    )


def closed() -> Contest:
    """A4 at rest behind its door."""
    return against_bound(opened(*poured("A4")), 500)


def discharging() -> Contest:
    """The first of A4's discharge, here and by pymunk, as CPU time of the case's step."""
    case, packing = poured("A4")
    sim = opened(case, packing)
    open_door(sim, case)
    contest = against_bound(sim, round(STRETCH / sim.time_step))
    other = Baseline(SiloCase.load("A4", PYMUNK), packing)
    other.run(round(_WARM_UP / other.time_step))
    other.open_door()
    stretch = round(STRETCH / other.time_step)
    per = 1e6 * case.time_step / STRETCH
    return Contest({**contest.runs, "pymunk": lambda: cost_of(lambda: other.run(stretch), 1) * per})


def whole() -> Contest:
    """A4 from filling to empty."""

    def here() -> float:
        began = user_s()
        case = SiloCase.load("A4")
        sim = opened(case, pour(case, 1, quiet))
        open_door(sim, case)
        while sim.n_out < sim.n_particles and sim.time < 3.0:
            sim.run(2000)
        return user_s() - began

    return Contest({HERE: here})


def side_by_side(copies: int) -> Contest:
    """Copies of a packing of the flat-bottomed silo in one wide silo, door closed."""
    sim = in_one_silo(copies)
    return against_bound(sim, max(400_000 // sim.n_particles, 1), 1e-3 * sim.n_particles)


def in_one_silo(copies: int) -> Simulation:
    """Such copies, a moment after they were put there."""
    case, packing = poured("D4")
    width = case.outline.width
    shifts = (np.arange(copies) - (copies - 1) / 2) * width
    poses = np.concatenate([packing.poses + np.array([shift, 0.0, 0.0]) for shift in shifts])
    kinds = np.tile(packing.kinds, copies)
    kinds, poses = in_rows(kinds, poses, 2 * case.shapes.bounding_radius)
    wide = hopper(0.0, case.outline.outlet, width * copies, case.outline.height)
    world = build_world(
        case.shapes.shapes, kinds, poses, wide.walls(),
        surface_density=case.surface_density, particle_law=case.particle_law,
        wall_law=case.wall_law, gravity=GRAVITY, time_step=case.time_step,
    )  # fmt: skip
    sim = Simulation(world)
    sim.run(200)
    return sim


def in_blocks(packing: Packing, small: SiloCase, k: int) -> Packing:
    """k x k scaled copies of a packing of a flat-bottomed silo, in the same silo."""
    width = small.outline.width / k
    height = packing.poses[:, 1].max() / k + small.shapes.bounding_radius
    poses = np.concatenate(
        [
            packing.poses / [k, k, 1]
            + np.array([(column - (k - 1) / 2) * width, row * height, 0.0])
            for row in range(k)
            for column in range(k)
        ]
    )
    kinds = np.tile(packing.kinds, k * k)
    kinds, poses = in_rows(kinds, poses, 2 * small.shapes.bounding_radius)
    return dataclasses.replace(packing, kinds=kinds, poses=poses)


def flowing(k: int) -> Contest:
    """The flat silo of particles k times smaller, while it flows."""
    case = SiloCase.load("D4", {"particles.scale": COARSE / k})
    packing = in_blocks(poured("D4", COARSE)[1], case, k)
    sim = Simulation(world_behind_door(case, packing))
    sim.run(round(CLOSED / sim.time_step))  # the gaps between the blocks close
    sim.begin_phase(case.particle_law, case.wall_law, case.time_step)
    open_door(sim, case)
    sim.run(round(OPEN / sim.time_step))
    inside = len(sim.live)
    return against_bound(sim, max(400_000 // inside, 1), 1e-3 * inside)


def scenes(largest: int) -> list[Scene]:
    """Scenes of the silo, of up to about so many particles."""
    each = "ns a particle and step"
    wide: Callable[[int], str] = "D4, {} side by side, door closed".format
    small: Callable[[int], str] = "D4, particles of 1/{} the size, flowing".format
    return [
        Scene("A4, door closed", "us a step", closed),
        Scene("A4, first 0.2 s of the discharge", "us for 5 us", discharging, round(0.2 / STRETCH)),
        Scene("A4, from filling to empty", "s", whole, 1),
        *(Scene(wide(n), each, partial(side_by_side, n)) for n in (1, 8, 32) if 650 * n <= largest),
        *(Scene(small(k), each, partial(flowing, k)) for k in (1, 3, 6) if 530 * k * k <= largest),
    ]
