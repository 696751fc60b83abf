"""Many dampers on many cores: each packing filled once, each run in its own folder, one row each.

The packing does not depend on frequency and acceleration, so all points of a map share one.
"""

import tempfile
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from damper3d.case.case import DamperCase
from damper3d.case.host.several import OWN
from damper3d.case.plan import disk_at_most, expected_cpu_s, stays
from damper3d.case.settings import Damper, Settings
from damper3d.engine import ENGINE
from damper3d.run.device import on_device
from damper3d.run.packing import load_packing, packing_folder
from damper3d.run.protocol import PACKAGES, get_packing, read_finished, run, run_digest
from damper3d.run.result import Result
from damper3d.run.sources import MEASURES, SOURCES
from granulab.campaign.runs.protocol import Stop, packing_sources
from granulab.campaign.runs.sharing import once
from granulab.campaign.sweeps import study_keys
from granulab.campaign.sweeps.cases import label_study, table_of_study
from granulab.campaign.sweeps.cases import run_study as run_labelled_study
from granulab.campaign.sweeps.report.quantities import Ending, Number, Quantities
from granulab.campaign.sweeps.sweep import Simulator, Task, run_labelled, run_or_pack, silent
from granulab.contact.files.keys import Keys
from granulab.contact.jit import already_compiled, cache_folder
from granulab.errors import InputError

if TYPE_CHECKING:
    from pandas import DataFrame

# On a host it counts how much of its motion is left; by itself a damper has its efficiency.
QUANTITIES = Quantities(
    numbers=(
        Number("host.reduction", "amplitude over bare", "", "less"),
        Number("host.added_damping_ratio", "added damping ratio", "", "more"),
        Number("efficiency", "efficiency", "", "more", interval="efficiency_interval"),
        Number("dissipated_power_w", "dissipated power", "W", "more"),
        Number("peak_wall_force_n", "peak wall force", "N", "less"),
    ),
    endings=(
        Ending("settling", "without efficiency", lambda row: row["efficiency"] is None),
        Ending("unsteady", "not steady at the last cycle", lambda row: row.get("steady") is False),
    ),
    order=("host.reduction", "host.added_damping_ratio", "efficiency"),
)

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


# Lines of [vary] in the study that `init` writes.
_VARIED = {
    "listed": [
        "motion.frequency = [20, 40]",
        '# "law.friction, law.friction_wall" = [0.2, 0.52]',
        "# particles.count = [180, 358]",
    ],
    "range": [
        "motion.gamma = { start = 5, stop = 25, step = 5 }",
        '# law.youngs_modulus = { start = "33 MPa", stop = "3.3 GPa", number = 3, log = true }',
    ],
    "one": [
        'output.keep = "summary"  # a sweep keeps the results of a run and not its frames',
    ],
    "drawn": [
        '# law.restitution = { distribution = "normal", mean = 0.86, sd = "3 %", max = 1, '
        "number = 8 }",
    ],
}


def run_task(task: Task, stop: Stop) -> Result | None:
    """Run a case, or fill its packing; in a worker."""
    compile_kernels()
    return run_or_pack(task, stop, run=run, get_packing=get_packing)


def compile_kernels() -> None:
    """Compile what is not compiled yet, while other processes that need it wait."""

    def shake_a_small_damper() -> None:
        with tempfile.TemporaryDirectory() as folder:
            case = DamperCase.load("thesis", _SMALL)
            run(case, out=folder, progress=lambda *_: None, stop=lambda: False)

    once(Path(cache_folder(ENGINE)), "damper-compiled", shake_a_small_damper)


DAMPER = Simulator(
    name="damper3d",
    digest=run_digest,
    packing_folder=packing_folder,
    packing_from=partial(packing_sources, load_packing),
    work=run_task,
    read=partial(read_finished, warn=silent),
    expected_cpu_s=expected_cpu_s,
    disk_at_most=disk_at_most,
    stays=stays,
    sources=SOURCES,
    measures=MEASURES,
    packages=PACKAGES,
    quantities=QUANTITIES,
    compiled=partial(already_compiled, ENGINE),
    device=on_device,
)


class DamperKeys(Keys):
    """Keys of a case, also those of one of several dampers: damper.<name or number>.<key>."""

    def _field(self, key: str) -> Any:
        section, _, rest = key.partition(".")
        own = rest.partition(".")[2]
        if section != "damper":
            return super()._field(key)
        if own in Damper.model_fields.keys() - OWN:
            return Damper.model_fields[own]
        if own.partition(".")[0] not in OWN:
            raise InputError(
                f"unknown key {key!r}; of one damper there are damper.<name or number>.seed, .at, "
                f"and keys of its {', '.join(OWN)}, such as damper.2.particles.count"
            )
        return super()._field(own)


# The cases of a study file.
load_study = partial(label_study, keys=DamperKeys(Settings), load=DamperCase.load)
run_cases = partial(run_labelled, DAMPER)  # labelled DamperCases; a row for each
run_study = partial(run_labelled_study, DAMPER)


def sweep(
    study: str | Path, changes: dict[str, Any] | None = None, *, out: str | Path = "runs",
    workers: int | None = None, quiet: bool | None = None,
) -> "DataFrame":  # fmt: skip
    """Run a study file of dampers; its table, a row a run with labels, state and results, in SI.

    changes: of all cases, by key, before the study's own. workers: runs at a time; None: all cores.
    quiet: False shows progress on stderr; None only in a notebook, as a line that changes in place.
    The script that calls it needs `if __name__ == "__main__"`, as the workers import it. Raises
    InputError, one line, where the study cannot be, and KeyboardInterrupt after Ctrl-C or the
    notebook's interrupt; runs keep their state, and the same call goes on.
    """
    loaded = load_study(study, changes)
    return table_of_study(DAMPER, loaded, out=Path(out), workers=workers, quiet=quiet)


def commented_study() -> str:
    """A study file with a comment on every key, which can be run as it stands."""
    values = {"name": "damper", "case": "thesis", "seeds": 3}
    return study_keys.commented_study(
        values, _VARIED, package="damper3d", note=", nor have frequency [Hz] and gamma [g]"
    )
