"""A damper's simulator that computes nothing: each run writes its folder with a kept summary.

All else is as of damper3d: cases, locks, provenance, packings, tables. Workers import it by name.
"""

import dataclasses
import json
import time
from pathlib import Path
from typing import Any

from damper3d.case.case import DamperCase
from damper3d.run import protocol
from damper3d.run.packing import load_packing, packing_folder, save_packing
from damper3d.run.result import Result
from damper3d.run.sources import SOURCES
from damper3d.run.sweep import DAMPER
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.protocol import Stop
from granulab.campaign.runs.provenance import Warn
from granulab.campaign.runs.stages import Stages
from granulab.campaign.sweeps.sweep import Task, run_or_pack

_KEPT = Path(__file__).parents[1] / "data" / "kept" / "damper"
_SUMMARY = json.loads((_KEPT / "spheres-seed1-1ef849efb55c" / "summary.json").read_text())
_PACKING = load_packing(_KEPT / "packings" / "9b5722d0493e")
STUDY = """schema = 1
name = "stand-in"
case = "thesis"
seeds = {seeds}
[vary]
motion.gamma = {{ start = 1, stop = 30, number = {number} }}
output.keep = "summary"
"""


def compute(
    folder: RunFolder, case: DamperCase, stages: Stages, stop: Stop, warn: Warn
) -> dict[str, Any]:
    """The kept results as those of a case; an efficiency that differs from run to run."""
    pack(case, folder.path.parent)
    gamma, seed = case.settings.motion.gamma, case.settings.run.seed
    results = {key: value for key, value in _SUMMARY.items() if key not in ("schema", "sha256")}
    return {**results, "gamma": gamma, "seed": seed, "efficiency": gamma / (gamma + seed)}


def pack(case: DamperCase, out: Path, *_: Any) -> None:
    """Keep a packing where that of a case is expected, unless there is one."""
    folder = packing_folder(case, out)
    if not (folder / "packing.h5").exists():
        folder.mkdir(parents=True, exist_ok=True)
        save_packing(dataclasses.replace(_PACKING, sources=SOURCES.digest), folder)


RUNS = dataclasses.replace(protocol.RUNS, compute=compute)


def work(task: Task, stop: Stop) -> Result | None:
    """Write the folder of a run, or a packing; cpu_s of the result is what that took."""
    begun = time.process_time()
    found = run_or_pack(task, stop, run=RUNS.run, get_packing=pack)
    return found and dataclasses.replace(found, cpu_s=time.process_time() - begun)


STAND_IN = dataclasses.replace(DAMPER, work=work)
