"""Many silos on many cores: each packing filled once, each run in its own folder, one row each."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from campaign.folder import FolderError
from campaign.protocol import packing_sources
from campaign.sweep import Labelled, Simulator, Task, as_outcome, run_labelled, silent
from campaign.task import SimulationError, Stop
from contact.jit import already_compiled
from contact.quantity import InputError
from silo2d import protocol
from silo2d.packing import load_packing, packing_folder
from silo2d.report import expected_cpu_s
from silo2d.result import Result
from silo2d.sources import SOURCES
from silo2d.warm import compile_kernels


def run_cases(
    cases: Sequence[Labelled],
    *,
    out: Path,
    engine: str = "processes",
    workers: int | None = None,
    scheduler: str | None = None,
    quiet: bool = False,
) -> list[dict[str, Any]]:
    """Run labelled SiloCases and return a row for each; see campaign.sweep.run_labelled."""
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
    compiled=partial(already_compiled, "silo2d"),
)
