"""Many dampers on many cores: each packing filled once, each run in its own folder, one row each.

The packing does not depend on frequency and acceleration, so all points of a map share one.
"""

import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from damper3d.case.case import DamperCase
from damper3d.case.plan import expected_cpu_s
from damper3d.case.settings import Settings
from damper3d.engine import ENGINE
from damper3d.run.packing import load_packing, packing_folder
from damper3d.run.protocol import PACKAGES, get_packing, read_finished, run, run_digest
from damper3d.run.result import Result
from damper3d.run.sources import MEASURES, SOURCES
from granulab.campaign.runs.folder import FolderError
from granulab.campaign.runs.lock import once
from granulab.campaign.runs.protocol import packing_sources
from granulab.campaign.sweeps.cases import LabelledStudy, label_study
from granulab.campaign.sweeps.cases import run_study as run_labelled_study
from granulab.campaign.sweeps.sweep import (
    Labelled,
    Simulator,
    Task,
    as_outcome,
    run_labelled,
    silent,
)
from granulab.campaign.sweeps.task import Stop
from granulab.contact.files.keys import Keys
from granulab.contact.jit import already_compiled, cache_folder
from granulab.errors import InputError, SimulationError

# A few spheres in a small enclosure: all kernels of a filling and of a cycle.
_SMALL = {
    "enclosure.diameter": "20 mm",
    "enclosure.height": "20 mm",
    "particles.count": 10,
    "fill.settle_time": "1 ms",
    "run.cycles": 1,
    "run.discard": 0,
    "output.keep": "summary",
}


def run_cases(
    cases: Sequence[Labelled],
    *,
    out: Path,
    engine: str = "processes",
    workers: int | None = None,
    scheduler: str | None = None,
    quiet: bool = False,
) -> list[dict[str, Any]]:
    """Run labelled DamperCases and return a row for each; see sweeps.sweep.run_labelled."""
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


def compile_kernels() -> None:
    """Compile what is not compiled yet, while other processes that need it wait."""

    def shake_a_small_damper() -> None:
        with tempfile.TemporaryDirectory() as place:
            run(DamperCase.load("thesis", _SMALL), out=place)

    once(Path(cache_folder(ENGINE)), "damper-compiled", shake_a_small_damper)


DAMPER = Simulator(
    name="damper3d",
    digest=run_digest,
    packing_folder=packing_folder,
    packing_from=partial(packing_sources, load_packing),
    work=run_task,
    read=partial(read_finished, warn=silent),
    expected_cpu_s=expected_cpu_s,
    sources=SOURCES,
    measures=MEASURES,
    packages=PACKAGES,
    means=("efficiency", "dissipated_power_w", "peak_wall_force_n"),
    compiled=partial(already_compiled, ENGINE),
)


def load_study(path: str | Path) -> LabelledStudy:
    """The cases of a study file; see granulab.campaign.sweeps.cases.label_study.

    Raises InputError or StudyError, one line that names the file, the key and what would do.
    """
    return label_study(path, Keys(Settings), DamperCase.load)


def run_study(
    loaded: LabelledStudy, *, out: Path, **options: Any
) -> tuple[Path, list[dict[str, Any]]]:
    """Run a study and keep its table; see granulab.campaign.sweeps.cases.run_study."""
    return run_labelled_study(DAMPER, loaded, out=out, **options)
