"""Many silos on many cores: each packing filled once, each run in its own folder, one row each."""

import tempfile
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

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
from silo2d.case.case import SiloCase
from silo2d.case.plan import expected_cpu_s
from silo2d.case.settings import Settings
from silo2d.engine import ENGINE
from silo2d.run import protocol
from silo2d.run.packing import load_packing, packing_folder
from silo2d.run.result import Result
from silo2d.run.sources import MEASURES, SOURCES

# Some forty grains that fall a centimetre: all kernels of a filling and a discharge.
_SMALL = {
    "silo.angle": "45 deg",
    "silo.outlet": "60 mm",
    "silo.width": "120 mm",
    "silo.height": "150 mm",
    "fill.level": "100 mm",
    "fill.settled": 1e-2,
    "run.max_time": "20 ms",
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
    """Run labelled SiloCases and return a row for each; see sweeps.sweep.run_labelled."""
    return run_labelled(
        SILO, cases, out=out, engine=engine, workers=workers, scheduler=scheduler, quiet=quiet
    )


def compile_kernels(*, drawn: bool = False) -> None:
    """Compile what is not compiled yet, while other processes that need it wait.

    drawn: those for pairs that draw their constants, which are kernels of their own.
    """

    def run_a_small_silo() -> None:
        with tempfile.TemporaryDirectory() as place:
            disorder = {"disorder.per": "pair"} if drawn else {}
            protocol.run(SiloCase.load("A4", _SMALL | disorder), out=place)

    once(
        Path(cache_folder(ENGINE)),
        "silo-drawn-compiled" if drawn else "silo-compiled",
        run_a_small_silo,
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
    read=partial(protocol.read_finished, warn=silent),
    expected_cpu_s=expected_cpu_s,
    sources=SOURCES,
    measures=MEASURES,
    made_by=protocol.sources_of_both,
    packages=protocol.PACKAGES,
    means=("discharge_time_s", "t90_s", "mean_rate_per_s"),
    counted={"clogged": lambda row: row["outcome"].startswith("clogged")},
    compiled=partial(already_compiled, ENGINE),
)


def load_study(path: str | Path) -> LabelledStudy:
    """The cases of a study file; see granulab.campaign.sweeps.cases.label_study.

    Raises InputError or StudyError, one line that names the file, the key and what would do.
    """
    return label_study(path, Keys(Settings), SiloCase.load)


def run_study(
    loaded: LabelledStudy, *, out: Path, **options: Any
) -> tuple[Path, list[dict[str, Any]]]:
    """Run a study and keep its table; see granulab.campaign.sweeps.cases.run_study."""
    return run_labelled_study(SILO, loaded, out=out, **options)
