"""What a step costs: door closed, over a discharge, filling, and against number and size.

Run as `make bench`, on a machine with nothing else to do. Every figure stands next to the
reference kernel, timed in the same run, so that machines (and their moods) can be compared.
"""

import argparse
import dataclasses
import platform
import time
from collections.abc import Callable

import numpy as np
from reference import reference_ns

from granulab.campaign.runs.provenance import cpu_model
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.outline import hopper
from silo2d.engine.simulation import Simulation
from silo2d.engine.world import build_world
from silo2d.run.packing import Packing, in_rows
from silo2d.run.pour import pour
from silo2d.run.protocol import settle_under_own_law, world_behind_door

COARSE, SMALLER = 1.1, (1, 2, 3, 6)  # scale of the largest particles, and their parts
CLOSED, OPEN = 0.12, 0.05  # [s] before and after the opening, until the flow is timed


def quiet(*_: object) -> None:
    """A report that says nothing."""


def cpu_us(run: Callable[[], int]) -> float:
    """CPU time of a step [us]; `run` returns the steps that it took."""
    began = time.process_time()
    steps = run()
    return 1e6 * (time.process_time() - began) / steps


def row(what: str, us: float, reference: float, remark: str = "") -> None:
    """One line of the table."""
    print(f"{what:34} {us:9.2f} us {1e3 * us / reference:9.0f} x   {remark}", flush=True)


def opened(case: SiloCase, packing: Packing) -> Simulation:
    """The packing under its own law with friction, at t = 0, the door still closed."""
    sim = Simulation(world_behind_door(case, packing))
    settle_under_own_law(sim, case, quiet)
    sim.begin_phase(case.particle_law, case.wall_law, case.time_step)
    return sim


def closed(sim: Simulation) -> float:
    """A step with the door closed [us]; the best of ten stretches of 500."""

    def stretch() -> int:
        sim.run(500)
        return 500

    return min(cpu_us(stretch) for _ in range(10))


def emptied(sim: Simulation, case: SiloCase) -> float:
    """A step averaged over the whole discharge [us]."""
    sim.remove_wall(len(case.outline.walls().names) - 1)

    def discharge() -> int:
        while sim.n_out < sim.n_particles and sim.time < 3.0:
            sim.run(2000)
        return sim.steps

    return cpu_us(discharge)


def side_by_side(case: SiloCase, packing: Packing, copies: int) -> Simulation:
    """Copies of a packing of a flat-bottomed silo in one wide silo, door closed."""
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
    return Simulation(world)


def in_blocks(packing: Packing, small: SiloCase, k: int) -> Packing:
    """k x k scaled copies of a packing of a flat-bottomed silo, in the same silo."""
    width = small.outline.width / k
    height = packing.poses[:, 1].max() / k + small.shapes.bounding_radius
    scaled = packing.poses / [k, k, 1]
    poses = np.concatenate(
        [
            scaled + np.array([(column - (k - 1) / 2) * width, row * height, 0.0])
            for row in range(k)
            for column in range(k)
        ]
    )
    kinds = np.tile(packing.kinds, k * k)
    kinds, poses = in_rows(kinds, poses, 2 * small.shapes.bounding_radius)
    return dataclasses.replace(packing, kinds=kinds, poses=poses)


def flowing(case: SiloCase, packing: Packing) -> tuple[float, int]:
    """A step while the silo flows [us], the best of ten stretches, and the particles inside."""
    sim = Simulation(world_behind_door(case, packing))
    sim.run(round(CLOSED / sim.time_step))  # the gaps between the blocks close
    sim.begin_phase(case.particle_law, case.wall_law, case.time_step)
    sim.remove_wall(len(case.outline.walls().names) - 1)
    sim.run(round(OPEN / sim.time_step))

    def stretch() -> int:
        n_steps = max(1_000_000 // sim.n_particles, 1)
        sim.run(n_steps)
        return n_steps

    return min(cpu_us(stretch) for _ in range(10)), len(sim.live)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--largest", type=int, default=20_000, help="particles of the largest heap")
    largest = parser.parse_args().largest
    case = SiloCase.load("A4")
    Simulation(world_behind_door(case, pour_small(case))).run(1)  # compiles
    before = reference_ns()
    print(f"{cpu_model()}, Python {platform.python_version()}, one core")
    print(f"reference kernel {before:.2f} ns a pair; the last column is in pairs of it\n")

    packing = pour(case, 1, quiet)
    began = time.process_time()
    sim = opened(case, packing)
    settling = time.process_time() - began
    closed_us = closed(sim)
    sim = opened(case, packing)
    began = time.process_time()
    average_us = emptied(sim, case)
    discharging = time.process_time() - began
    reference = (before + reference_ns()) / 2
    n = sim.n_particles
    row(f"A4, {n} particles, door closed", closed_us, reference, "a step of 5 us")
    row("A4, averaged over the discharge", average_us, reference, f"{sim.steps:,} steps")
    total = packing.cpu_s + settling + discharging
    print(
        f"filling {packing.cpu_s:.2f} s, settling {settling:.2f} s, discharge {discharging:.2f} s "
        f"of CPU: {total:.2f} s in all, {1e-6 * 1e9 * total / reference:.0f} million pairs\n"
    )

    flat = SiloCase.load("D4")
    packing = pour(flat, 1, quiet)
    print(
        "cost against number of particles (a flat-bottomed heap, copied side by side, door closed)"
    )
    copies = 1
    while copies * len(packing.kinds) <= largest * 1.05:
        reference = reference_ns()
        sim = side_by_side(flat, packing, copies)
        sim.run(200)
        us = closed(sim)
        row(
            f"  {sim.n_particles} particles", us, (reference + reference_ns()) / 2,
            f"{1e3 * us / sim.n_particles:.1f} ns a particle and step",
        )  # fmt: skip
        copies *= 2

    against_size(largest)


def against_size(largest: int) -> None:
    """Table of the flow in one silo of ever smaller particles, and what they differ by."""
    print("\ncost against number of particles, the smaller the more, while the silo flows")
    packing, each = pour(SiloCase.load("D4", {"particles.scale": COARSE}), 1, quiet), []
    for k in SMALLER:
        small = SiloCase.load("D4", {"particles.scale": COARSE / k})
        blocks = in_blocks(packing, small, k)
        if len(blocks.kinds) > largest * 1.05:
            break
        reference = reference_ns()
        us, inside = flowing(small, blocks)
        each.append(1e3 * us / inside)
        row(
            f"  {inside} of {1e3 * np.sqrt(small.shapes.mean_area):.1f} mm", us,
            (reference + reference_ns()) / 2, f"{each[-1]:.1f} ns a particle and step",
        )  # fmt: skip
    print(f"  largest over least: {max(each) / min(each):.2f}")


def pour_small(case: SiloCase) -> Packing:
    """A few particles far apart: enough to compile the kernels."""
    poses = np.array([[0.0, 0.1, 0.0], [0.0, 0.15, 0.0]])
    return Packing(np.zeros(2, int), poses, 0.0, 0.0, "dem", 0.0)


if __name__ == "__main__":
    main()
