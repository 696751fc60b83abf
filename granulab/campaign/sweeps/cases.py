"""From a study file to labelled cases, and from their runs to the study's table."""

import itertools
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from granulab.campaign.output.files import write_atomic, writing
from granulab.campaign.output.table import write_table
from granulab.campaign.output.terminal import in_notebook
from granulab.campaign.runs.folder import RunFolder, digest
from granulab.campaign.runs.provenance import provenance
from granulab.campaign.sweeps.report.axes import Varied
from granulab.campaign.sweeps.study import Study, read_study
from granulab.campaign.sweeps.sweep import (
    Labelled,
    Simulator,
    over_seeds,
    refuse_interrupted,
    run_labelled,
)

if TYPE_CHECKING:
    from pandas import DataFrame


class Keys(Protocol):
    """Keys of a simulator's case files, as granulab.contact.files.keys knows them."""

    def read(self, where: str, key: str, value: Any) -> Any:
        """A value as written for a key: a number in SI, or a word."""

    def written(self, key: str, value: Any) -> Any:
        """The value as it would stand in a case file."""

    def column(self, key: str) -> str:
        """The name of the key's column in a table, with the unit."""

    def shown(self, key: str) -> tuple[str, float]:
        """The unit in which people write a key, "" for none, and how much of SI it is."""


@dataclass(frozen=True)
class LabelledStudy:
    """A study and the labelled cases that it stands for, all checked."""

    study: Study
    cases: list[Labelled]
    varied: tuple[Varied, ...]  # columns of the labels, the seed left out

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of these columns."""
        return tuple(one.column for one in self.varied)


def label_study(
    path: str | Path, given: dict[str, Any] | None = None, *, keys: Keys,
    load: Callable[[str, dict[str, Any]], Any],
) -> LabelledStudy:  # fmt: skip
    """The cases of a study file, in the order: case, combination, seed.

    given: changes by key of all cases, which the study's own go before; `load` gives the case of a
    name, with changes by key. Raises StudyError or what `keys` and `load` raise, one line that
    names the file, the key and what would do.
    """
    path = Path(path)
    study = read_study(path, lambda key, value: keys.read(f"{path}: [vary]", key, value))
    stems = [Path(name).stem for name in study.cases]
    cases = []
    for (name, stem), combination in itertools.product(
        zip(study.cases, stems, strict=True), study.combinations
    ):
        own = {key: keys.written(key, value) for key, value in combination.items()}
        changes = (given or {}) | own
        labels = {"case": stem if stems.count(stem) == 1 else name}
        labels |= {keys.column(key): value for key, value in combination.items()}
        case = load(_base(name, path.parent), changes)
        cases += over_seeds(labels, case, study.seeds)
    varied = [
        Varied(keys.column(key), key, *keys.shown(key), drawn=key in study.drawn)
        for key in study.combinations[0]
    ]
    return LabelledStudy(study, cases, (Varied("case", "case"), *varied))


def run_study(
    simulator: Simulator, loaded: LabelledStudy, *, out: Path, **options: Any
) -> tuple[Path, list[dict[str, Any]]]:
    """Run a study and keep its table; the study's folder and the rows (see run_labelled).

    The folder, out/studies/<name>-<digest>, holds study.toml, provenance.json, runs.journal,
    table.csv and table.h5. Raises what run_labelled raises, and FolderError where the table cannot
    be written.
    """
    folder = study_folder(simulator, loaded, out)
    with writing(folder.path):
        folder.path.mkdir(parents=True, exist_ok=True)
    write_atomic(folder.path / "study.toml", loaded.study.text)
    folder.write_provenance(
        provenance(
            command=sys.argv,
            seed=loaded.study.draw_seed,
            packages=simulator.packages,
            sources=simulator.sources.folders,
        )
    )
    journal = folder.path / "runs.journal"
    rows = run_labelled(simulator, loaded.cases, out=out, journal=journal, **options)
    folder.seal("study.toml", *write_table(folder.path, rows))
    return folder.path, rows


def table_of_study(
    simulator: Simulator, loaded: LabelledStudy, *, out: Path, workers: int | None,
    quiet: bool | None,
) -> "DataFrame":  # fmt: skip
    """Run a study as Python calls it: its table, a row a run.

    quiet: None shows progress in a notebook and nothing in a script. After Ctrl-C, or a notebook's
    interrupt, KeyboardInterrupt: what ran has kept its state, and the same call goes on.
    """
    from pandas import DataFrame

    silent = not in_notebook() if quiet is None else quiet
    _, rows = run_study(simulator, loaded, out=out, workers=workers, quiet=silent)
    refuse_interrupted(rows)
    return DataFrame(rows)


def study_folder(simulator: Simulator, loaded: LabelledStudy, out: Path) -> RunFolder:
    """Named by the runs of the study and what they are called."""
    runs = [[labels, simulator.digest(case)] for labels, case in loaded.cases]
    return RunFolder(Path(out) / "studies" / f"{loaded.study.name}-{digest({'runs': runs})}")


def _base(name: str, folder: Path) -> str:
    """A case file in the study's folder, else a preset or what else `load` knows."""
    return str(folder / name) if (folder / name).is_file() else name
