"""A run of avalanches in its folder: begun or found, computed or gone on with, read back."""

import csv
import dataclasses
import io
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from granulab.campaign.output.files import write_atomic
from granulab.campaign.runs.checkpoint import save_checkpoint
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.protocol import Runs, Stop
from granulab.campaign.runs.provenance import Warn
from granulab.campaign.runs.stages import Stages
from silo2d.avalanches.arches import Bed
from silo2d.avalanches.case import (
    AvalancheCase,
    expected_cpu_s,
    expected_flow_s,
    run_digest,
    summary_of,
)
from silo2d.avalanches.flow import Ledger, flow
from silo2d.avalanches.result import Avalanches
from silo2d.case.plan import compiling, expected_stages
from silo2d.engine.simulation import Simulation
from silo2d.run.protocol import (
    PACKAGES,
    get_packing,
    in_shorter_steps,
    sources_of_both,
    start_or_resume,
)

_ROOM = Path(__file__).parent
_MEASURES = _ROOM.parent / "measures"  # which find the arches that are broken


def _compute(
    folder: RunFolder, case: AvalancheCase, stages: Stages, stop: Stop, warn: Warn
) -> dict[str, Any]:
    """The results of avalanches."""
    filling, _ = expected_cpu_s(case)
    settling = expected_stages(case.silo)["settling"]
    stages.expect(filling=filling, settling=settling, flowing=expected_flow_s(case))
    bed = Bed.of(case, get_packing(case.silo, folder.path.resolve().parent, stages, stop, warn))

    def begin(halvings: int) -> tuple[Ledger, Callable[[], dict[str, Any]]]:
        sim, ledger = start_or_resume(
            folder, bed.silo, bed.packing, halvings, stages, stop, warn, Ledger
        )

        def go() -> dict[str, Any]:
            outcome = flow(sim, bed, ledger, partial(_keep, folder, sim, ledger), stages, stop)
            return _summary(case, sim, ledger, outcome)

        return ledger, go

    summary = in_shorter_steps(folder, case.silo, begin)
    stages.finish("flowing")
    _write_table(folder, summary)
    return summary


def _keep(folder: RunFolder, sim: Simulation, ledger: Ledger) -> None:
    save_checkpoint(folder.checkpoint, sim.save(), dataclasses.asdict(ledger))


def _summary(case: AvalancheCase, sim: Simulation, ledger: Ledger, outcome: str) -> dict[str, Any]:
    first = ledger.first or [ledger.size, 0]
    return {
        **summary_of(case),
        "outcome": outcome,
        "n_particles": sim.n_particles,
        "sizes": ledger.sizes,
        "cut": ledger.cut,
        "durations_s": ledger.durations,
        "first_size": first[0],
        "first_clogged": bool(first[1]),
        "arch_particles": ledger.arch_particles,
        "arch_span_m": ledger.arch_span,
        "arch_aspect": ledger.arch_aspect,
        "arches_not_found": ledger.arches_not_found,
        "breaks": ledger.breaks,
        "refilled": ledger.refilled,
        "waits": ledger.waits,
        "time_step_s": sim.time_step,
        "time_step_halvings": ledger.halvings,
        "steps": sim.steps,
        "simulated_s": sim.time,
        "cpu_s": ledger.cpu_s + ledger.filling_cpu_s,
        "state_digest": sim.state_digest(),
    }


def _write_table(folder: RunFolder, summary: Mapping[str, Any]) -> None:
    """avalanches.csv: a line an avalanche, in their order."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["size", "cut", "duration_s"])
    writer.writerows(zip(*(summary[k] for k in ("sizes", "cut", "durations_s")), strict=True))
    write_atomic(folder.path / "avalanches.csv", text.getvalue())


RUNS = Runs(
    result=Avalanches,
    digest=run_digest,
    compute=_compute,
    packages=PACKAGES,
    sources=lambda case: sources_of_both(case.silo)[0].plus(_ROOM, _MEASURES),
    compiling=lambda case: compiling(case.silo),
)
run, read_finished = RUNS.run, RUNS.read_finished
