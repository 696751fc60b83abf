"""Many dampers on many cores: each packing filled once, each run in its own folder, one row each.

The packing does not depend on frequency and acceleration, so all points of a map share one.
"""

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
from damper3d.packing import load_packing, packing_folder
from damper3d.plan import expected_cpu_s
from damper3d.protocol import PACKAGES, get_packing, run, run_digest
from damper3d.result import Result
from damper3d.sources import SOURCES
from damper3d.warm import compile_kernels


def run_cases(
    cases: Sequence[Labelled],
    *,
    out: Path,
    engine: str = "processes",
    workers: int | None = None,
    scheduler: str | None = None,
    quiet: bool = False,
) -> list[dict[str, Any]]:
    """Run labelled DamperCases and return a row for each; see campaign.sweep.run_labelled."""
    return run_labelled(
        DAMPER, cases, out=out, engine=engine, workers=workers, scheduler=scheduler, quiet=quiet
    )


def run_task(task: Task, stop: Stop) -> Result | None:
    """Run a case, or fill its packing; in a worker."""
    compile_kernels()
    with as_outcome(InputError, FolderError, SimulationError):
        if task.packing_only:
            get_packing(task.case, task.out, lambda fraction, text: None, stop, silent)
            return None
        return run(task.case, out=task.out, stop=stop, warn=silent)


DAMPER = Simulator(
    name="damper3d",
    digest=run_digest,
    packing_folder=packing_folder,
    packing_from=partial(packing_sources, load_packing),
    work=run_task,
    read=partial(Result.read, reused=True),
    expected_cpu_s=expected_cpu_s,
    sources=SOURCES,
    packages=PACKAGES,
    means=("efficiency", "dissipated_power_w", "peak_wall_force_n"),
    compiled=partial(already_compiled, "damper3d"),
)
