"""Many silos on many cores: each packing filled once, each run in its own folder, one row each."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from granulab.campaign.runs.folder import FolderError
from granulab.campaign.runs.protocol import packing_sources
from granulab.campaign.sweeps.sweep import (
    Labelled,
    Simulator,
    Task,
    as_outcome,
    run_labelled,
    silent,
)
from granulab.campaign.sweeps.task import Stop
from granulab.contact.jit import already_compiled
from granulab.errors import InputError, SimulationError
from silo2d.engine import ENGINE
from silo2d.run import protocol
from silo2d.run.packing import load_packing, packing_folder
from silo2d.run.result import Result
from silo2d.run.sources import SOURCES
from silo2d.run.warm import compile_kernels
from silo2d.view.report import expected_cpu_s


def run_cases(
    cases: Sequence[Labelled],
    *,
    out: Path,
    engine: str = "processes",
    workers: int | None = None,
    scheduler: str | None = None,
    quiet: bool = False,
) -> list[dict[str, Any]]:
    """Run labelled SiloCases and return a row for each; see sweeps.sweep.run_labelled."""
    return run_labelled(
        SILO, cases, out=out, engine=engine, workers=workers, scheduler=scheduler, quiet=quiet
    )


def run_task(task: Task, stop: Stop) -> Result | None:
    """Run a case, or fill its packing; in a worker."""
    compile_kernels(drawn=task.case.disorder is not None and not task.packing_only)
    with as_outcome(InputError, FolderError, SimulationError):
        if task.packing_only:
            protocol.get_packing(task.case, task.out, lambda fraction, text: None, stop, silent)
            return None
        return protocol.run(task.case, out=task.out, stop=stop, warn=silent)


SILO = Simulator(
    name="silo2d",
    digest=protocol.run_digest,
    packing_folder=packing_folder,
    packing_from=partial(packing_sources, load_packing),
    work=run_task,
    read=partial(Result.read, reused=True),
    expected_cpu_s=expected_cpu_s,
    sources=SOURCES,
    packages=protocol.PACKAGES,
    means=("discharge_time_s", "t90_s", "mean_rate_per_s"),
    counted={"clogged": lambda row: row["outcome"].startswith("clogged")},
    compiled=partial(already_compiled, ENGINE),
)
