"""Many silos on many cores: each packing filled once, each run in its own folder, one row each."""

import tempfile
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granulab.campaign.runs.protocol import Stop, packing_sources
from granulab.campaign.runs.sharing import once
from granulab.campaign.sweeps import study_keys
from granulab.campaign.sweeps.cases import label_study, table_of_study
from granulab.campaign.sweeps.cases import run_study as run_labelled_study
from granulab.campaign.sweeps.report.quantities import Ending, Number, Quantities
from granulab.campaign.sweeps.sweep import Simulator, Task, run_labelled, run_or_pack, silent
from granulab.contact.files.keys import Keys
from granulab.contact.jit import already_compiled, cache_folder
from silo2d.case.case import SiloCase
from silo2d.case.plan import disk_at_most, expected_cpu_s
from silo2d.case.settings import Settings
from silo2d.engine import ENGINE
from silo2d.run import protocol
from silo2d.run.packing import load_packing, packing_folder
from silo2d.run.result import Result
from silo2d.run.sources import MEASURES, SOURCES

if TYPE_CHECKING:
    from pandas import DataFrame


def _flowed(row: dict[str, Any]) -> bool:
    """False of a run that clogged: of a few particles that fell at once no flow can be told."""
    return not _clogged(row)


def _clogged(row: dict[str, Any]) -> bool:
    return str(row["outcome"]).startswith("clogged")


# Less material or a wider silo does not make the flow: of quantities that are better where there is
# more or less of them, only the flow compares silos of different sizes.
QUANTITIES = Quantities(
    numbers=(
        Number("mean_mass_flow_kg_per_s", "mass flow", "kg/s", "more", counts=_flowed),
        Number("discharge_time_s", "discharge time", "s", "less"),
        Number("t90_s", "T90", "s", "less", charted=False),
        Number("mean_rate_per_s", "rate", "1/s", "more", charted=False),
    ),
    endings=(
        Ending("clogged", "clogged", _clogged, named=True),
        Ending("time_limit", "out of time", lambda row: row["outcome"] == "time_limit"),
    ),
    order=("clogged", "mean_mass_flow_kg_per_s"),
)

# Some forty particles that fall a centimetre: all kernels of a filling and a discharge.
_SMALL = {
    "silo.angle": "45 deg",
    "silo.outlet": "60 mm",
    "silo.width": "120 mm",
    "silo.height": "150 mm",
    "fill.level": "100 mm",
    "fill.settled": 1e-2,
    "run.max_time": "20 ms",
}


# Lines of [vary] in the study that `init` writes.
_VARIED = {
    "listed": [
        '"law.mu_particle, law.mu_wall" = [0.2, 0.4]',
    ],
    "range": [
        'silo.outlet = { start = "100 mm", stop = "150 mm", step = "25 mm" }',
        '# law.kn = { start = "1e3 N/mm", stop = "1e4 N/mm", number = 3, log = true }',
    ],
    "one": [
        '# law.damping = "restitution"',
    ],
    "drawn": [
        '# law.mu_wall = { distribution = "normal", mean = 0.44, sd = "7 %", min = 0, number = 8 }',
        '# law.gamma_n = { distribution = "lognormal", mean = "6085 1/s", sd = "600 1/s", '
        "number = 8 }",
        '# silo.angle = { distribution = "uniform", min = "30 deg", max = "60 deg", number = 8 }',
    ],
}


def compile_kernels(*, drawn: bool = False) -> None:
    """Compile what is not compiled yet, while other processes that need it wait.

    drawn: those for pairs that draw their constants, which are kernels of their own.
    """

    def run_a_small_silo() -> None:
        with tempfile.TemporaryDirectory() as folder:
            disorder = {"disorder.per": "pair"} if drawn else {}
            case = SiloCase.load("A4", _SMALL | disorder)
            protocol.run(case, out=folder, progress=lambda *_: None, stop=lambda: False)

    once(
        Path(cache_folder(ENGINE)),
        "silo-drawn-compiled" if drawn else "silo-compiled",
        run_a_small_silo,
    )


def run_task(task: Task, stop: Stop) -> Result | None:
    """Run a case, or fill its packing; in a worker."""
    compile_kernels(drawn=task.case.disorder is not None and not task.packing_only)
    return run_or_pack(task, stop, run=protocol.run, get_packing=protocol.get_packing)


SILO = Simulator(
    name="silo2d",
    digest=protocol.run_digest,
    packing_folder=packing_folder,
    packing_from=partial(packing_sources, load_packing),
    work=run_task,
    read=partial(protocol.read_finished, warn=silent),
    expected_cpu_s=expected_cpu_s,
    disk_at_most=disk_at_most,
    sources=SOURCES,
    measures=MEASURES,
    made_by=protocol.sources_of_both,
    packages=protocol.PACKAGES,
    quantities=QUANTITIES,
    compiled=partial(already_compiled, ENGINE),
)


# The cases of a study file.
load_study = partial(label_study, keys=Keys(Settings), load=SiloCase.load)
run_cases = partial(run_labelled, SILO)  # labelled SiloCases; a row for each
run_study = partial(run_labelled_study, SILO)


def sweep(
    study: str | Path, changes: dict[str, Any] | None = None, *, out: str | Path = "runs",
    workers: int | None = None, quiet: bool | None = None,
) -> "DataFrame":  # fmt: skip
    """Run a study file of silos; its table, a row a run with labels, state and results, in SI.

    changes: of all cases, by key, before the study's own. workers: runs at a time; None: all cores.
    quiet: False shows progress on stderr; None only in a notebook, as a line that changes in place.
    The script that calls it needs `if __name__ == "__main__"`, as the workers import it. Raises
    InputError, one line, where the study cannot be, and KeyboardInterrupt after Ctrl-C or the
    notebook's interrupt; runs keep their state, and the same call goes on.
    """
    loaded = load_study(study, changes)
    return table_of_study(SILO, loaded, out=Path(out), workers=workers, quiet=quiet)


def commented_study() -> str:
    """A study file with a comment on every key, which can be run as it stands."""
    values = {"name": "friction", "case": "A4", "seeds": 5}
    return study_keys.commented_study(values, _VARIED, package="silo2d")
