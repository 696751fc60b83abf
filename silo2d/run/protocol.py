"""A silo run: fill, settle, open, discharge; checkpoints, and going on from them."""

import dataclasses
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from granulab.campaign.runs.folder import RunFolder, digest
from granulab.campaign.runs.protocol import Progress, Runs, Stop, kept, restored
from granulab.campaign.runs.provenance import Sources, Warn, to_stderr
from granulab.campaign.runs.sharing import shared_by
from granulab.campaign.runs.stages import Stages
from granulab.campaign.runs.trajectory import TrajectoryWriter
from granulab.errors import SimulationError, Stopped
from silo2d.baseline.discharge import Baseline, discharge_by_impulses
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.disorder import with_friction
from silo2d.case.plan import compiling, cpu_of_step, expected_stages, hedge, settling
from silo2d.engine import state
from silo2d.engine.simulation import Simulation
from silo2d.engine.world import build_world
from silo2d.run.beds.acts import equip, with_store
from silo2d.run.discharge import discharge
from silo2d.run.ending import MOST_HALVINGS, Clock
from silo2d.run.packing import Packing, load_packing, packing_folder, save_packing
from silo2d.run.pour import normalised_kinetic_energy, pour
from silo2d.run.rest import Rest
from silo2d.run.result import Result
from silo2d.run.sources import BASELINE, MEASURES, SOURCES
from silo2d.run.summary import describe, measured, summarise, write_records

PACKAGES = ["numpy", "numba", "llvmlite", "h5py", "shapely", "pymunk"]
_SETTLE_FRAME = 1e-3  # [s] between looks at the kinetic energy before the opening
_SETTLE_PATIENCE = 2.0  # [s]
_QUIET_LOOKS = 5  # one may fall on a moment when the energy is elastic

Summary = dict[str, Any]
Ticking = TypeVar("Ticking", bound=Clock)


def run_digest(case: SiloCase) -> str:
    """Names a run: its case, seed and engine."""
    engine: dict[str, Any] = {"engine": case.settings.run.engine}
    if case.impulses:
        engine["impulses"] = dataclasses.asdict(case.impulses)
    return digest({**case.identity(), **engine})


def sources_of_both(case: SiloCase) -> tuple[Sources, Sources]:
    """The sources that decide what a run of a case computes, and what its packing is."""
    poured = BASELINE if case.settings.fill.pour_with == "pymunk" else SOURCES
    return BASELINE if case.impulses else poured, poured


def _compute(
    folder: RunFolder, case: SiloCase, stages: Stages, stop: Stop, warn: Warn
) -> dict[str, Any]:
    """The results of a silo: filled, settled, opened and discharged, or gone on with."""
    stages.expect(**expected_stages(case))
    stages.hedge = hedge(case)
    if case.impulses:
        return _by_pymunk(folder, case, stages, stop, warn)
    packing = get_packing(case, folder.path.resolve().parent, stages, stop, warn)
    packing = with_store(case, packing)

    def begin(halvings: int) -> tuple[Clock, Callable[[], Summary]]:
        rest = None if case.settings.output.wall_interval is None else Rest()
        sim, clock = start_or_resume(
            folder, case, packing, halvings, stages, stop, warn, Clock, rest
        )
        return clock, lambda: _discharged(folder, case, packing, sim, clock, stages, stop, rest)

    return in_shorter_steps(folder, case, begin)


def in_shorter_steps(
    folder: RunFolder, case: SiloCase, begin: Callable[[int], tuple[Clock, Callable[[], Summary]]]
) -> Summary:
    """Summary of a run, which is begun again in half the step where a chosen one was too long.

    begin: of a number of halvings, gives the clock of a run that starts so or is gone on with, and
    what computes the rest. Raises SimulationError after MOST_HALVINGS, or where the step was given.
    """
    halvings, most = 0, MOST_HALVINGS if case.step_source == "chosen" else 0
    while True:
        try:
            clock, go = begin(halvings)
            halvings = clock.halvings
            return go()
        except SimulationError:
            if halvings >= most:
                raise
            halvings += 1
            folder.drop_checkpoints()


def _discharged(
    folder: RunFolder, case: SiloCase, packing: Packing, sim: Simulation, clock: Clock,
    stages: Stages, stop: Stop, rest: Rest | None,
) -> dict[str, Any]:  # fmt: skip
    """The results of a silo that has settled or is gone on with."""
    static = describe(case, packing)
    writer = TrajectoryWriter(folder.path, parts=clock.parts)
    writer.write_static(*static)
    outcome = discharge(sim, case, packing, folder, writer, clock, stages, stop, rest)
    stages.finish("discharging")
    stages.hedge = ""
    writer.finish(*static)
    write_records(folder)
    return summarise(folder, case, sim, packing, clock, outcome)


def _measured(
    folder: RunFolder, case: SiloCase, summary: Mapping[str, Any]
) -> dict[str, Any] | None:
    return {**summary, **measured(folder, case, summary["outcome"])}


def _by_pymunk(
    folder: RunFolder, case: SiloCase, stages: Stages, stop: Stop, warn: Warn
) -> dict[str, Any]:
    """The summary of a discharge by pymunk; its frames are in the folder."""
    packing = get_packing(case, folder.path.resolve().parent, stages, stop, warn)
    static, attributes = describe(case, packing)
    attributes["engine"] = "pymunk"
    clock = Clock(filling_cpu_s=packing.cpu_s)
    writer = TrajectoryWriter(folder.path)
    writer.write_static(static, attributes)
    sim = Baseline(case, packing)
    outcome = discharge_by_impulses(sim, case, packing, writer, clock, stages, stop)
    stages.finish("discharging")
    stages.hedge = ""
    writer.finish(static, attributes)
    write_records(folder)
    return summarise(folder, case, sim, packing, clock, outcome)


def start_or_resume(
    folder: RunFolder, case: SiloCase, packing: Packing, halvings: int, stages: Stages, stop: Stop,
    warn: Warn, kind: type[Ticking], rest: Rest | None = None,
) -> tuple[Simulation, Ticking]:  # fmt: skip
    """The silo at rest behind its door in a step halved so often, or as its checkpoint has it.

    kind: of the clock that its checkpoints hold.
    """
    if folder.checkpoint.exists():
        sim = _behind_door(case, packing, case.time_step / 2**halvings)
        stages.finish("settling")
        sim.begin_phase(*case.laws(sim.n_particles), sim.time_step)
        equip(sim, case, packing)
        if found := restored(folder, sim.restore, kind, "its opening", warn):
            sim.time_step = case.time_step / 2**found.halvings
            return sim, found
    sim, cpu_s = at_opening(case, packing, halvings, stages, stop, rest)
    return sim, kind(filling_cpu_s=packing.cpu_s + cpu_s, halvings=halvings)


def at_opening(
    case: SiloCase, packing: Packing, halvings: int, stages: Stages, stop: Stop,
    rest: Rest | None = None,
) -> tuple[Simulation, float]:  # fmt: skip
    """The silo at rest behind its door, in a step halved so often, and the CPU time it took [s]."""
    sim = _behind_door(case, packing, case.time_step / 2**halvings)
    sim.compile()
    begun = time.process_time()
    settle_under_own_law(sim, case, stages, stop, rest)
    stages.finish("settling")
    return sim, time.process_time() - begun


def _behind_door(case: SiloCase, packing: Packing, step: float) -> Simulation:
    sim = Simulation(world_behind_door(case, packing, step))
    sim.share(shared_by(cpu_of_step(case)))
    if case.settings.flow.refill:
        sim.keep_back(case.settings.flow.refill)
    return sim


def get_packing(
    case: SiloCase,
    root: Path,
    progress: Progress | Stages,
    stop: Stop = lambda: False,
    warn: Warn = to_stderr,
) -> Packing:
    """The packing of a case: kept under root/packings, or poured and kept now.

    A filling that is stopped is poured again from its seed the next time (raises Stopped).
    Raises FolderError where a packing is damaged, or could not be written.
    """
    folder, stages = packing_folder(case, root), Stages.of(progress)
    with stages.watching():
        packing = kept(
            folder,
            load=load_packing,
            make=lambda: _fill(case, folder, stages, stop),
            cure="delete it and it is filled again",
            sources=sources_of_both(case)[1],
            stop=stop,
            warn=warn,
        )
    stages.finish("filling")
    level, top = case.settings.fill.level, packing.poses[:, 1].max(initial=0.0)
    if top < level - 2 * case.shapes.bounding_radius:
        warn(
            f"the bed ends at {top * 1e3:.3g} mm, more than a particle below [fill] level = "
            f"{level * 1e3:g} mm; give the level that it has, or another seed"
        )
    return packing


def _fill(case: SiloCase, folder: Path, stages: Stages, stop: Stop) -> Packing:
    stages.expect(filling=expected_stages(case)["filling"])

    def report(phase: str, fraction: float, text: str) -> None:
        stages.report("filling", fraction, 1.0 - fraction, f"{phase}, {text}")
        if stop():
            raise Stopped("the same command fills the silo again, from its seed")

    seed = case.settings.run.seed
    if case.settings.fill.pour_with == "pymunk":
        from silo2d.baseline.pouring import pour_with_pymunk

        packing = pour_with_pymunk(case, seed, report)
    else:
        packing = pour(case, seed, report)
    packing = dataclasses.replace(packing, sources=sources_of_both(case)[1].digest)
    save_packing(packing, folder)
    return packing


def world_behind_door(
    case: SiloCase, packing: Packing, time_step: float | None = None
) -> state.World:
    """The packing behind the closed door, with the friction that it was poured with."""
    particle_law, wall_law = case.laws(len(packing.kinds))
    if case.settings.fill.friction is not True:
        poured = case.pour_laws
        particle_law = with_friction(particle_law, poured[0].mu)
        wall_law = with_friction(wall_law, poured[1].mu)
    return build_world(
        case.shapes.shapes,
        packing.kinds,
        packing.poses,
        case.outline.walls(),
        surface_density=case.surface_density,
        particle_law=particle_law,
        wall_law=wall_law,
        gravity=GRAVITY,
        time_step=time_step or case.time_step,
    )


def settle_under_own_law(
    sim: Simulation,
    case: SiloCase,
    progress: Progress | Stages,
    stop: Stop = lambda: False,
    rest: Rest | None = None,
) -> None:
    """Let a packing that was poured softer come to rest, which several looks in a row must find.

    rest: keeps what is borne at each look.

    Raises Stopped, and SimulationError where it takes more than 2 s of simulated time.
    """
    steps, stages = max(round(_SETTLE_FRAME / sim.time_step), 1), Stages.of(progress)
    quiet_looks = 0
    while True:
        force = sim.wall_forces()
        sim.run(steps)
        if rest is not None:
            rest.force += [force] if rest.time else []
            rest.look(sim)
        moving = normalised_kinetic_energy(sim, case.shapes)
        quiet_looks = quiet_looks + 1 if moving < case.settings.fill.settled else 0
        if quiet_looks == _QUIET_LOOKS:
            return
        left = max(settling(case) - sim.time, _QUIET_LOOKS * _SETTLE_FRAME)
        stages.report("settling", sim.time, left, f"t = {sim.time:.3f} s")
        if stop():
            raise Stopped("the same command goes on from the packing")
        if sim.time > _SETTLE_PATIENCE:
            raise sim.failure(
                "the packing did not come to rest under its own law (normalised kinetic energy "
                f"{moving:.1e}, [fill] settled wants {case.settings.fill.settled:g})"
            )


RUNS = Runs(
    result=Result,
    digest=run_digest,
    load=SiloCase.load,
    compute=_compute,
    packages=PACKAGES,
    sources=lambda case: sources_of_both(case)[0],
    described="case.toml, shapes.toml or materials.toml",
    measures=MEASURES,
    measured=_measured,
    compiling=compiling,
)
run, resume, read_finished = RUNS.run, RUNS.resume, RUNS.read_finished
