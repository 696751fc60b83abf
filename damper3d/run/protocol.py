"""A damper run: fill, settle, shake; checkpoints, and going on from them."""

import dataclasses
import json
import shutil
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.engine.simulation import Simulation
from damper3d.measures.phases.criteria import phase_of_run
from damper3d.run.fill import fill, resting
from damper3d.run.folders import shaken
from damper3d.run.packing import Packing, damaged, load_packing, packing_folder, save_packing
from damper3d.run.result import Result, first_counted, summarise
from damper3d.run.sources import MEASURES, SOURCES
from damper3d.run.vibration import Clock, vibrate
from granulab.campaign.runs.checkpoint import load_checkpoint
from granulab.campaign.runs.folder import FolderError, RunFolder, digest, open_run
from granulab.campaign.runs.protocol import (
    Progress,
    Stop,
    begin_or_check,
    check_unchanged,
    end,
    is_measured_by,
    kept,
    measure_again,
)
from granulab.campaign.runs.provenance import Warn, to_stderr
from granulab.campaign.runs.trajectory import TrajectoryWriter, read_trajectory
from granulab.errors import Stopped

__all__ = ["PACKAGES", "get_packing", "resume", "run", "run_digest", "run_in"]

PACKAGES = ["numpy", "numba", "llvmlite", "h5py"]


def run(
    case: DamperCase,
    *,
    out: str | Path | None = None,
    progress: Progress | None = None,
    again: bool = False,
    stop: Stop = lambda: False,
    warn: Warn = to_stderr,
) -> Result:
    """Run a case in a folder below `out` ("runs"), or read the result that is there.

    An unfinished run goes on from its checkpoint. `stop` is asked some times a second; when it
    says yes, the state is kept and Stopped is raised. `warn` takes a line for what other sources
    made. Raises InputError where the particles do not fit, FolderError for folders that cannot
    be used and SimulationError where the simulation fails.
    """
    root = Path(out or "runs")
    folder = open_run(root, f"{case.name}-seed{case.settings.run.seed}", run_digest(case), again)
    return run_in(folder, case, progress or (lambda fraction, text: None), stop, warn)


def resume(
    path: str | Path,
    *,
    progress: Progress | None = None,
    stop: Stop = lambda: False,
) -> Result:
    """Go on with the run in a folder; see `run`."""
    folder = shaken(path)
    case = DamperCase.load(folder.path / "case.toml")
    check_unchanged(folder, run_digest(case), "case.toml or materials.toml")
    return run_in(folder, case, progress or (lambda fraction, text: None), stop)


def run_digest(case: DamperCase) -> str:
    """Names a run: its case and seed."""
    return digest(case.identity())


def run_in(
    folder: RunFolder,
    case: DamperCase,
    progress: Progress,
    stop: Stop,
    warn: Warn = to_stderr,
) -> Result:
    """Run a case in its folder; see `run`."""
    with folder.lock():
        begun = time.perf_counter()
        begin_or_check(
            folder,
            case=case.to_toml(),
            files=case.files,
            run_digest=run_digest(case),
            seed=case.settings.run.seed,
            packages=PACKAGES,
            sources=SOURCES,
            warn=warn,
        )
        if folder.state == "finished":
            _clear(folder, case)  # it may have been killed before it could
            return _read(folder, warn)
        packing = get_packing(case, folder.path.resolve().parent, progress, stop, warn)
        sim, clock = _start_or_resume(folder, case, packing)
        writer = TrajectoryWriter(folder.path, parts=clock.parts)
        writer.write_static(*describe(case, packing))
        vibrate(sim, case, folder, writer, clock, progress, stop)
        summary = _end(folder, case, packing, sim, clock, writer)
        end(folder, summary, begun, MEASURES)
        _clear(folder, case)
        return Result.read(folder, reused=False)


def get_packing(
    case: DamperCase,
    root: Path,
    progress: Progress,
    stop: Stop = lambda: False,
    warn: Warn = to_stderr,
) -> Packing:
    """The packing of a case: kept under root/packings, or filled and kept now.

    A filling that is stopped is done again from its seed the next time (raises Stopped). Raises
    FolderError where a packing is damaged, or could not be written, and what `fill` raises.
    """
    folder = packing_folder(case, root)
    return kept(
        folder,
        load=load_packing,
        make=lambda: _fill(case, folder, progress, stop),
        cure="delete it and the enclosure is filled again",
        sources=SOURCES,
        stop=stop,
        warn=warn,
    )


def _fill(case: DamperCase, folder: Path, progress: Progress, stop: Stop) -> Packing:
    def report(fraction: float, text: str) -> None:
        progress(fraction, text)
        if stop():
            raise Stopped("the same command fills the enclosure again, from its seed")

    packing = dataclasses.replace(fill(case, report), sources=SOURCES.digest)
    save_packing(packing, folder)
    return packing


def _start_or_resume(
    folder: RunFolder, case: DamperCase, packing: Packing
) -> tuple[Simulation, Clock]:
    """The settled bed in an enclosure that begins to move, or the state of the checkpoint."""
    sim = resting(case, packing.state["position"][:, :3])
    try:
        sim.restore(packing.state)
    except (IndexError, KeyError, ValueError):
        raise damaged(packing_folder(case, folder.path.resolve().parent)) from None
    sim.begin_phase(
        shaker=case.shaker,
        gravity=np.append(case.gravity, 0.0),
        time_step=case.time_step,
    )
    sim.compile()
    if not folder.checkpoint.exists():
        return sim, Clock(filling_cpu_s=packing.cpu_s)
    saved, meta = load_checkpoint(folder.checkpoint)
    try:
        sim.restore(saved)
        return sim, Clock(**meta)
    except (IndexError, KeyError, TypeError, ValueError) as error:
        raise FolderError(
            f"{folder.checkpoint}: does not fit this case ({error}); delete it and the run starts "
            "from its first cycle"
        ) from None


def describe(case: DamperCase, packing: Packing) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
    """Constant arrays and attributes of a trajectory."""
    motion, output, particle = case.settings.motion, case.settings.output, case.particle
    static = {
        "radius": np.full(case.count, case.particle.equal_volume_radius),
        "mass": np.full(case.count, case.particle_mass),
    }
    if not particle.is_sphere:  # about the centroid, in the axes that turn_... of the tables turn
        static |= {"sphere_offset": particle.offsets, "sphere_radius": particle.radii}
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


def _end(
    folder: RunFolder,
    case: DamperCase,
    packing: Packing,
    sim: Simulation,
    clock: Clock,
    writer: TrajectoryWriter,
) -> dict[str, Any]:
    """Bring the trajectory into its last form, and the results of a run that has ended."""
    if case.settings.output.keep == "all":
        writer.finish(*describe(case, packing))
    else:
        writer.flush()
    return {
        **_measured(folder, case, len(clock.lost) - 1),
        "packing": {
            "fraction": packing.fraction,
            "height_m": packing.height,
            "coordination": packing.coordination,
            "rms_speed_m_s": packing.rms_speed,
        },
        "steps": sim.steps,
        "cpu_us_per_step": 1e6 * clock.cpu_s / sim.steps,
        "cpu_s": clock.cpu_s + clock.filling_cpu_s,
        "state_digest": sim.state_digest(),
    }


def _measured(folder: RunFolder, case: DamperCase, n_cycles: int) -> dict[str, Any]:
    """The part of the results that measures make from what the run stored."""
    return {
        **summarise(case, read_trajectory(folder.path)),
        **phase_of_run(folder.path, first_counted(case, n_cycles)),
    }


def read_finished(folder: RunFolder, warn: Warn = to_stderr) -> Result:
    """The result of a finished run; measured again where the measures are others by now."""
    if is_measured_by(folder, MEASURES):  # without a lock: it may lie where nobody may write
        return Result.read(folder, reused=True)
    with folder.lock():
        return _read(folder, warn)


def _read(folder: RunFolder, warn: Warn) -> Result:
    def again(summary: Mapping[str, Any]) -> dict[str, Any] | None:
        case = DamperCase.load(folder.path / "case.toml")
        if case.settings.output.keep == "summary" or case.settings.run.steady:
            return None  # nothing is stored; or the measures decided when the run ended
        return {**summary, **_measured(folder, case, summary["cycles"])}

    measure_again(folder, MEASURES, again, warn)
    return Result.read(folder, reused=True)


def _clear(folder: RunFolder, case: DamperCase) -> None:
    """Remove what a finished run does not need; what cannot be removed does no harm."""
    folder.checkpoint.unlink(missing_ok=True)
    if case.settings.output.keep == "summary":
        shutil.rmtree(folder.path / "parts", ignore_errors=True)
