"""Scenes of the damper: spheres compared with other engines, and shapes, mixtures and numbers."""

import sys
import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.speed.liggghts import Liggghts
from benchmarks.speed.reference import bound_us
from benchmarks.speed.timing import BOUND, HERE, Contest, Scene, cost_of, user_s
from benchmarks.speed.yade import Yade
from damper3d.case.case import DamperCase
from damper3d.engine.simulation import Simulation
from damper3d.run.fill import fill, resting

# the deck for LAMMPS
sys.path.append(str(Path(__file__).resolve().parents[2] / "tests" / "helpers"))

BOUNCING = {"motion.frequency": 40.0, "motion.gamma": 20.0}
STRETCH = 2000  # steps at rest
_TILE = 0.04  # [m], the box that large beds are made of
_SETTLING = 10_000  # steps after the walls between the boxes have gone
SHAPES = ("prolate:1.5", "prolate:3", "toroid:0.2", "45 prolate:1.5 + 45 prolate:1.5",
          "60 sphere:5mm + 30 prolate:1.5")  # fmt: skip


def quiet(*_: object) -> None:
    """A report that says nothing."""


def particles_of(text: str) -> dict[str, Any]:
    """Changes to a case for "prolate:1.5", "30 prolate:1.5" or "60 sphere:5mm + 30 prolate:1.5"."""
    kinds = [part.split() for part in text.split("+")]
    if len(kinds) > 1:
        return {"particles.kind": [{"shape": shape, "count": int(n)} for n, shape in kinds]}
    *count, shape = kinds[0]
    return {"particles.shape": shape, **({"particles.count": int(count[0])} if count else {})}


@cache
def filled(particles: str) -> tuple[DamperCase, dict[str, np.ndarray]]:
    """The thesis's damper with such particles, and the state of its settled bed."""
    case = DamperCase.load("thesis", {**BOUNCING, **particles_of(particles)})
    return case, fill(case, quiet).state


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


def go_on(sim: Simulation, steps: int) -> None:
    """Steps as a run takes them: with samples, and the rest without."""
    sim.run(steps // sim.steps_per_sample)
    sim.step(steps % sim.steps_per_sample)


def costs(sim: Simulation, steps: int, per_step: float = 1.0) -> dict[str, Callable[[], float]]:
    """Stretches of a simulation and their bound, both over `per_step`, as us."""

    def bound() -> float:
        return bound_us(len(sim.contacts()["overlap"]), sim.n_particles) / per_step

    return {HERE: lambda: cost_of(lambda: go_on(sim, steps), 1e-6 * steps) / per_step, BOUND: bound}


def in_others(case: DamperCase, position: np.ndarray) -> tuple[dict[str, Any], list[str]]:
    """The same bed in the engines that are installed, by name, and the names of the others.

    LAMMPS has the walls in one curved region, its fastest way.
    """
    from lammps_damper import Lammps
    from lammps_damper import Scene as Bed

    scene = Bed(
        position, float(case.particle.radii[0]), case.density, case.enclosure,
        case.pair_law, case.wall_law, case.time_step, gravity=tuple(case.gravity),
        amplitude=case.amplitude, omega=2 * np.pi / case.period, curved=True,
    )  # fmt: skip
    found: dict[str, Any] = {}
    missing = []
    for name, engine in (("LAMMPS", Lammps), ("LIGGGHTS", Liggghts), ("YADE", Yade)):
        try:
            found[name] = engine(scene)
        except ImportError:
            missing.append(name)
    return found, missing


def spheres(*, moves: bool) -> Contest:
    """The thesis's 358 spheres, at rest or bouncing after two cycles."""
    case, state = filled("sphere:5mm")
    sim = bed(case, state, moves=moves)
    cycle = round(case.period / case.time_step)
    steps, warm_up = (cycle, 2 * cycle) if moves else (STRETCH, STRETCH)
    others, missing = in_others(case, bed(case, state, moves=False).frame()["x"])
    go_on(sim, warm_up)
    runs = costs(sim, steps)
    for name, engine in others.items():
        engine.run(STRETCH)
        if moves:
            engine.start(measured=False)
            engine.run(warm_up)
        runs[name] = partial(timed, engine, steps)
    return Contest(runs, missing, lambda: [one.__exit__() for one in others.values()])


def timed(engine: Any, steps: int) -> float:
    """CPU time of a step of another engine [us]; of a process of its own, as this reports it."""
    if hasattr(engine, "cpu_s"):
        began = engine.cpu_s()
        engine.run(steps)
        return 1e6 * (engine.cpu_s() - began) / steps
    return cost_of(lambda: engine.run(steps), 1e-6 * steps)


def shape(particles: str, *, moves: bool) -> Contest:
    """Multi-sphere particles or a mixture, at rest or bouncing after two cycles, and spheres."""
    case, state = filled(particles)
    sim = bed(case, state, moves=moves)
    cycle = round(case.period / case.time_step)
    go_on(sim, 2 * cycle if moves else STRETCH)
    round_ones = bed(*filled("sphere:5mm"), moves=moves)
    go_on(round_ones, 2 * cycle if moves else STRETCH)
    own = costs(round_ones, 5000)[HERE]
    return Contest({**costs(sim, 5000), "358 spheres": own})


def side_by_side(n: int, m: int, *, moves: bool) -> Contest:
    """n x m beds in a box, without the walls between them: at rest, or their first cycle."""
    wide, centres = in_one_box(n, m)
    sim = sampled(wide, resting(wide, centres))
    sim.share(1)
    go_on(sim, _SETTLING)
    steps = max(400_000 // wide.count, 1)
    if moves:
        sim.begin_phase(shaker=wide.shaker, time_step=wide.time_step)
        steps = round(wide.period / wide.time_step)
    return Contest(costs(sim, steps, 1e-3 * wide.count))


def in_one_box(n: int, m: int) -> tuple[DamperCase, np.ndarray]:
    """The case of n x m beds in a box, and the centres of their spheres [m]."""
    case, state = tile()
    wide = DamperCase.load("thesis", {
        **BOUNCING, "enclosure.shape": "box", "enclosure.width": f"{n * _TILE} m",
        "enclosure.depth": f"{m * _TILE} m", "particles.count": n * m * case.count,
    })  # fmt: skip
    shifts = [((i - (n - 1) / 2) * _TILE, (j - (m - 1) / 2) * _TILE, 0.0)
              for i in range(n) for j in range(m)]  # fmt: skip
    return wide, np.concatenate([state["position"][:, :3] + shift for shift in shifts])


@cache
def tile() -> tuple[DamperCase, dict[str, np.ndarray]]:
    """The case that wide beds are made of, and the state of its settled bed."""
    case = DamperCase.load("thesis", {
        **BOUNCING, "enclosure.shape": "box", "enclosure.width": f"{_TILE} m",
        "particles.count": 358,
    })  # fmt: skip
    return case, fill(case, quiet).state


def point() -> Contest:
    """What a point of a map costs on top of its steps."""
    from damper3d.run.protocol import run

    def here() -> float:
        summary = {"output.keep": "summary", "output.frames": 0}
        with tempfile.TemporaryDirectory() as folder:
            run(DamperCase.load("thesis", {**BOUNCING, **summary}), out=folder)  # fills
            began = user_s()
            changes = {**BOUNCING, **summary, "motion.gamma": 30.0}
            result = run(DamperCase.load("thesis", changes), out=folder)
            return user_s() - began - 1e-6 * result.cpu_us_per_step * result.steps

    return Contest({HERE: here})


def scenes(largest: int) -> list[Scene]:
    """Scenes of the damper, of up to about so many spheres."""
    us, each = "us a step", "ns a sphere and step"
    tiles = [(n, m) for n, m in ((1, 1), (4, 2), (8, 7)) if 358 * n * m <= largest * 1.05]

    def wide(n: int, how: str) -> str:
        return f"{358 * n} spheres in a box, {how}"

    return [
        Scene("thesis, 358 spheres, at rest", us, partial(spheres, moves=False)),
        Scene("thesis, 358 spheres, bouncing", us, partial(spheres, moves=True)),
        *(Scene(wide(n * m, "at rest"), each, partial(side_by_side, n, m, moves=False))
          for n, m in tiles),
        *(Scene(wide(n * m, "first cycle"), each, partial(side_by_side, n, m, moves=True), 1)
          for n, m in tiles),
        *(Scene(f"{text}, at rest", us, partial(shape, text, moves=False)) for text in SHAPES),
        *(Scene(f"{text}, bouncing", us, partial(shape, text, moves=True)) for text in SHAPES),
        Scene("a point of a map, on top of its steps", "s", point, 1),
    ]  # fmt: skip
