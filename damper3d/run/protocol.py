"""A damper run: fill, settle, shake; checkpoints, and going on from them."""

import dataclasses
import json
import shutil
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.case import GRAVITY, DamperCase
from damper3d.case.plan import compiling, expected_stages
from damper3d.engine.multisphere.form import Unlike, form_of
from damper3d.engine.simulation import Together
from damper3d.measures.phases.criteria import phase_of_run
from damper3d.run.device import joined, left
from damper3d.run.fill import fill, resting
from damper3d.run.folders import shaken
from damper3d.run.packing import REFILLED, Packing, load_packing, packing_folder, save_packing
from damper3d.run.result import Result, first_counted, summarise
from damper3d.run.several import beside, folder_beside
from damper3d.run.sources import MEASURES, SOURCES
from damper3d.run.vibration import BESIDE, Clock, Shaken, restore, vibrate
from granulab.campaign.runs.folder import RunFolder, digest
from granulab.campaign.runs.protocol import Progress, Runs, Stop, damaged, kept, restored
from granulab.campaign.runs.provenance import Warn, to_stderr
from granulab.campaign.runs.stages import Stages
from granulab.campaign.runs.trajectory import TrajectoryWriter, read_trajectory
from granulab.contact.attraction import Attraction
from granulab.errors import Stopped

__all__ = ["PACKAGES", "get_packing", "resume", "run", "run_digest"]

PACKAGES = ["numpy", "numba", "llvmlite", "h5py"]


def run_digest(case: DamperCase) -> str:
    """Names a run: its case and seed."""
    return digest(case.identity())


def _compute(
    folder: RunFolder, case: DamperCase, stages: Stages, stop: Stop, warn: Warn
) -> dict[str, Any]:
    """The results of a damper: filled, settled and shaken, or gone on with."""
    stages.expect(**expected_stages(case))
    root = folder.path.resolve().parent
    packings = [get_packing(one, root, stages, stop, warn) for one in case.dampers or (case,)]
    dampers = _start_or_resume(folder, case, packings, warn)
    lead = dampers[case.number]
    try:
        vibrate(lead, dampers, stages, stop)
    finally:
        devices = [left(one.sim) for one in dampers]
    if devices[case.number]:
        folder.write_provenance({**folder.read_provenance(), "device": devices[case.number]})
    stages.finish("shaking")
    stages.hedge = ""
    ended = [_end(one, packing) for one, packing in zip(dampers, packings, strict=True)]
    if case.dampers:
        beside(dampers, ended, lead)
    return ended[case.number]


def get_packing(
    case: DamperCase,
    root: Path,
    progress: Progress | Stages,
    stop: Stop = lambda: False,
    warn: Warn = to_stderr,
) -> Packing:
    """The packing of a case: kept under root/packings, or filled and kept now.

    A filling that is stopped is done again from its seed the next time (raises Stopped). Raises
    FolderError where a packing is damaged, or could not be written, and what `fill` raises.
    """
    folder, stages = packing_folder(case, root), Stages.of(progress)
    with stages.watching():
        packing = kept(
            folder,
            load=load_packing,
            make=lambda: _fill(case, folder, stages, stop),
            cure=f"delete it and {REFILLED}",
            sources=SOURCES,
            stop=stop,
            warn=warn,
        )
    for stage in ("filling", "settling"):
        stages.finish(stage)
    return packing


def _fill(case: DamperCase, folder: Path, stages: Stages, stop: Stop) -> Packing:
    def report(stage: str, done: float, text: str) -> None:
        stages.report(stage, done, 1.0 - done, text)
        if stop():
            raise Stopped("the same command fills the enclosure again, from its seed")

    packing = dataclasses.replace(fill(case, report), sources=SOURCES.digest)
    save_packing(packing, folder)
    return packing


def _start_or_resume(
    folder: RunFolder, case: DamperCase, packings: Sequence[Packing], warn: Warn
) -> list[Shaken]:
    """The settled beds in enclosures that begin to move, or the state of the checkpoint."""
    root, cases, sims = folder.path.resolve().parent, case.dampers or (case,), []
    for one, packing, shaker in zip(cases, packings, case.shakers, strict=True):
        sim = resting(one, packing.state["position"][:, :3])
        try:
            sim.restore(packing.state)
        except (IndexError, KeyError, ValueError):
            raise damaged(packing_folder(one, root), REFILLED) from None
        gravity = np.append(one.gravity, 0.0)
        sim.begin_phase(shaker=shaker, gravity=gravity, time_step=one.time_step)
        sims.append(sim)
    Together(sims).compile()
    places = [
        folder if k == case.number else folder_beside(folder, case, k) for k in range(len(cases))
    ]
    clock = None
    if folder.checkpoint.exists():
        put_back = partial(restore, sims, case.number)
        others = [place.path for place in places if place is not folder]
        clock = restored(folder, put_back, Clock, "its first cycle", warn, beside=others)
    clock = clock or Clock(filling_cpu_s=sum(packing.cpu_s for packing in packings))
    clocks, dampers = iter(clock.beside), []
    for one, packing, sim, place in zip(cases, packings, sims, places, strict=True):
        is_lead = place is folder
        own = clock if is_lead else Clock(**next(clocks, {}))
        writer = TrajectoryWriter(place.path, parts=own.parts)
        writer.write_static(*describe(one, packing))
        dampers.append(Shaken(case if is_lead else one, joined(sim), own, place, writer))
    return dampers


def describe(case: DamperCase, packing: Packing) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Constant arrays and attributes of a trajectory."""
    motion, output = case.settings.motion, case.settings.output
    static = {"radius": case.radii, "mass": case.masses}
    if case.bed is not None:
        static["kind"] = case.bed.kind
    if not case.of_spheres:  # about the centroid, in the axes that turn_... of the tables rotate
        form = form_of(case.solids(case.count), case.density)
        static |= {
            "sphere_offset": form.offset[:, :3].copy(),
            "sphere_radius": form.offset[:, 3].copy(),
        }
        if isinstance(form, Unlike):  # rows of these tables, of each particle
            static |= {"sphere_row": form.row, "sphere_count": np.diff(form.first)}
    attributes = {
        "wall_names": json.dumps(case.wall_names),
        "fill_ratio": case.fill_ratio,
        "frequency": motion.frequency,
        "gamma": motion.gamma,
        "period": case.period,
        "samples_per_cycle": output.samples,
        "frames_per_cycle": output.frames,
        "direction": case.direction,
        "gravity": case.gravity,
        "packing_fraction": packing.fraction,
    }
    return static, attributes


def _end(damper: Shaken, packing: Packing) -> dict[str, Any]:
    """Bring the trajectory into its last form, and the results of a run that has ended."""
    case, sim, clock, writer = damper.case, damper.sim, damper.clock, damper.writer
    if case.settings.output.keep == "all":
        writer.finish(*describe(case, packing))
    else:
        writer.flush()
    return {
        **_measured(damper.folder, case, len(clock.lost) - 1),
        "packing": {
            "fraction": packing.fraction,
            "height_m": packing.height,
            "coordination": packing.coordination,
            "rms_speed_m_s": packing.rms_speed,
        },
        "pulling": Attraction(*clock.attraction).numbers(GRAVITY * case.particle_mass),
        "steps": sim.steps,
        "cpu_us_per_step": 1e6 * clock.cpu_s / sim.steps,
        "cpu_s": clock.cpu_s + clock.filling_cpu_s,
        "state_digest": sim.state_digest(),
    }


def _measured(folder: RunFolder, case: DamperCase, n_cycles: int) -> dict[str, Any]:
    """The part of the results that measures make from what the run stored."""
    phase = (
        phase_of_run(folder.path, first_counted(case, n_cycles))
        if case.settings.output.frames
        else {"phase": None, "phase_next": None, "phase_measures": None}
    )
    return {**summarise(case, read_trajectory(folder.path)), **phase}


def _measured_again(
    folder: RunFolder, case: DamperCase, summary: Mapping[str, Any]
) -> dict[str, Any] | None:
    if case.settings.output.keep == "summary" or case.settings.run.steady or case.dampers:
        return None  # nothing is stored; or the measures decided when it ended; or others count too
    return {**summary, **_measured(folder, case, summary["cycles"])}


def _clear(folder: RunFolder, case: DamperCase) -> None:
    """Remove the frames of a run that keeps its results only; where they stay, they do no harm."""
    if case.settings.output.keep == "summary":
        for place in [folder.path, *folder.path.glob(f"{BESIDE}*")]:
            shutil.rmtree(place / "parts", ignore_errors=True)


RUNS = Runs(
    result=Result,
    digest=run_digest,
    load=DamperCase.load,
    compute=_compute,
    packages=PACKAGES,
    sources=lambda case: SOURCES,
    described="case.toml or materials.toml",
    measures=MEASURES,
    measured=_measured_again,
    clear=_clear,
    find=shaken,
    compiling=compiling,
)
run, resume, read_finished = RUNS.run, RUNS.resume, RUNS.read_finished
