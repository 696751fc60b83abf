"""What a step of the damper costs: at rest, bouncing, compared with LAMMPS, and against the number.

Run as `make bench`. User CPU time of one core, energy split on; stretches of this engine and of
LAMMPS (where it is installed) take turns, and medians are printed, so that a machine that others
use is unfair to both alike. The ratios hold elsewhere, the microseconds do not.
"""

import argparse
import resource
import statistics
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.engine.simulation import Simulation
from damper3d.run.fill import fill, resting
from granulab.campaign.runs.provenance import cpu_model

# the deck for LAMMPS
sys.path.append(str(Path(__file__).resolve().parent.parent / "tests" / "helpers"))

BOUNCING = {"motion.frequency": 40.0, "motion.gamma": 20.0}
TARGETS = {"bouncing": (10.0, 0.4), "at rest": (11.5, 0.2)}  # us a step, part of LAMMPS's
FREQUENCIES = (20, 40, 80, 125, 160, 200, 320, 625, 1024)  # of the thesis's map [Hz]
AMPLITUDES = 19  # of Gamma, at each of them
_STRETCH = 2000  # steps at rest
_TILE = 0.04  # [m], the box that large beds are made of
_SETTLING = 10_000  # steps after the walls between the boxes have gone

Run = Callable[[int], object]  # so many steps


def quiet(*_: object) -> None:
    """A report that says nothing."""


def user_us(go: Run, steps: int) -> float:
    """User CPU time of a step [us]."""
    began = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    go(steps)
    return 1e6 * (resource.getrusage(resource.RUSAGE_SELF).ru_utime - began) / steps


def taking_turns(runs: dict[str, Run], steps: int, repeats: int) -> dict[str, float]:
    """Medians over stretches [us a step], and of the ratios of neighbouring stretches."""
    times = [{name: user_us(go, steps) for name, go in runs.items()} for _ in range(repeats)]
    medians = {name: statistics.median(row[name] for row in times) for name in runs}
    if len(runs) == 2:
        first, second = runs
        medians["ratio"] = statistics.median(row[first] / row[second] for row in times)
    return medians


def bed(case: DamperCase, state: dict[str, np.ndarray], *, moves: bool) -> Simulation:
    """The settled bed of a case, in an enclosure that begins to move, or does not."""
    sim = resting(case, state["position"][:, :3])
    sim.restore(state)
    if moves:
        gravity = np.append(case.gravity, 0.0)
        sim.begin_phase(shaker=case.shaker, gravity=gravity, time_step=case.time_step)
    return sampled(case, sim)


def sampled(case: DamperCase, sim: Simulation) -> Simulation:
    """With as many samples as a run takes."""
    sim.steps_per_sample = case.steps_per_sample
    sim.compile()
    return sim


def steps_of(sim: Simulation) -> Run:
    """Steps as a run takes them: with samples, and the rest without."""

    def go(steps: int) -> None:
        sim.run(steps // sim.steps_per_sample)
        sim.step(steps % sim.steps_per_sample)

    return go


def in_lammps(case: DamperCase, position: np.ndarray) -> object | None:
    """The same bed in LAMMPS, in one curved region, its fastest way; None: not installed."""
    try:
        from lammps_damper import Lammps, Scene

        return Lammps(
            Scene(
                position, float(case.particle.radii[0]), case.density, case.enclosure,
                case.pair_law, case.wall_law, case.time_step, gravity=tuple(case.gravity),
                amplitude=case.amplitude, omega=2 * np.pi / case.period, curved=True,
            )
        )  # fmt: skip
    except ImportError as error:
        print(f"no LAMMPS to compare with ({error}; pip install lammps mpich)")
        return None


def beside_lammps(case: DamperCase, state: dict[str, np.ndarray], repeats: int) -> float:
    """Print the costs at rest and bouncing; the latter of this engine [us]."""
    still, shaken = bed(case, state, moves=False), bed(case, state, moves=True)
    cycle = round(case.period / case.time_step)
    engine = in_lammps(case, still.frame()["x"])
    runs = {"at rest": {"here": steps_of(still)}, "bouncing": {"here": steps_of(shaken)}}
    if engine is not None:
        for each in runs.values():
            each["LAMMPS"] = engine.run
    us = 0.0
    for what, each in runs.items():
        if what == "bouncing" and engine is not None:
            engine.start(measured=False)
        warm_up = 2 * cycle if what == "bouncing" else _STRETCH
        for go in each.values():
            go(warm_up)
        found = taking_turns(each, cycle if what == "bouncing" else _STRETCH, repeats)
        us, target = found["here"], TARGETS[what]
        line = f"{case.count} spheres {what:9} {us:7.2f} us a step ({target[0]})"
        if engine is not None:
            other, ratio = found["LAMMPS"], found["ratio"]
            line += f"; LAMMPS {other:.1f} us, ratio {ratio:.2f} ({target[1]})"
        print(line, flush=True)
    if engine is not None:
        engine.engine.close()
    return us


def side_by_side(case: DamperCase, state: dict[str, np.ndarray], n: int, m: int) -> Simulation:
    """n x m copies of a bed in a box, without the walls between them, at rest."""
    wide = DamperCase.load("thesis", {
        **BOUNCING, "enclosure.shape": "box", "enclosure.width": f"{n * _TILE} m",
        "enclosure.depth": f"{m * _TILE} m", "particles.count": n * m * case.count,
    })  # fmt: skip
    shifts = [((i - (n - 1) / 2) * _TILE, (j - (m - 1) / 2) * _TILE, 0.0)
              for i in range(n) for j in range(m)]  # fmt: skip
    centres = np.concatenate([state["position"][:, :3] + shift for shift in shifts])
    return sampled(wide, resting(wide, centres)), wide


def against_number(largest: int, repeats: int) -> None:
    """Print the cost of a sphere and step, at rest and over the first cycle, up to so many."""
    case = DamperCase.load("thesis", {
        **BOUNCING, "enclosure.shape": "box", "enclosure.width": f"{_TILE} m",
        "particles.count": 358,
    })  # fmt: skip
    state = fill(case, quiet).state
    print("\ncost of a sphere and step, boxes of 40 mm side by side [ns]")
    for n, m in ((1, 1), (2, 1), (2, 2), (4, 2), (4, 4), (8, 4), (8, 7)):
        if n * m * case.count > largest * 1.05:
            break
        sim, wide = side_by_side(case, state, n, m)
        go = steps_of(sim)
        go(_SETTLING)
        rest = min(user_us(go, 200) for _ in range(repeats))
        contacts = len(sim.contacts()["overlap"]) / wide.count
        sim.begin_phase(shaker=wide.shaker, time_step=wide.time_step)
        bouncing = user_us(go, round(wide.period / wide.time_step))
        scale = 1e3 / wide.count
        print(f"  {wide.count:6} spheres   at rest {scale * rest:6.2f} ({contacts:.2f} contacts)"
              f"   first cycle at 40 Hz, Gamma 20 {scale * bouncing:6.2f}", flush=True)  # fmt: skip


def of_a_point(us: float) -> None:
    """Print what a point of a map costs on top of its steps, and what a whole map comes to."""
    from damper3d.run.protocol import run

    summary = {"output.keep": "summary", "output.frames": 0}
    with tempfile.TemporaryDirectory() as folder:
        first = DamperCase.load("thesis", {**BOUNCING, **summary})
        run(first, out=folder)  # fills
        began = resource.getrusage(resource.RUSAGE_SELF).ru_utime
        point = run(DamperCase.load("thesis", {**BOUNCING, **summary, "motion.gamma": 30.0}),
                    out=folder)  # fmt: skip
        seconds = resource.getrusage(resource.RUSAGE_SELF).ru_utime - began
    overhead = seconds - 1e-6 * point.cpu_us_per_step * point.steps
    steps = 8 * AMPLITUDES * sum(1 / f for f in FREQUENCIES) / point.time_step_s
    n_points = AMPLITUDES * len(FREQUENCIES)
    total = n_points * overhead + 1e-6 * us * steps
    print(f"\na point of a map, 40 Hz, Gamma 30: {seconds:.2f} s, {overhead:.2f} s on top of it")
    print(
        f"{n_points} points of 8 cycles, {steps / 1e6:.1f} million steps: about {total:.0f} s, "
        f"{total / 120:.1f} min on two cores (4 min)"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--largest", type=int, default=20_000, help="spheres of the largest bed")
    parser.add_argument("--repeats", type=int, default=5, help="stretches of which the median is")
    given = parser.parse_args()
    case = DamperCase.load("thesis", BOUNCING)
    print(f"damper: {cpu_model()}, one core, user CPU time; targets in brackets")
    state = fill(case, quiet).state
    us = beside_lammps(case, state, given.repeats)
    against_number(given.largest, given.repeats)
    of_a_point(us)


if __name__ == "__main__":
    main()
