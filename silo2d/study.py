"""From a study file to labelled cases: units of the keys, cases, columns of the table."""

import itertools
import sys
import typing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import BeforeValidator

from campaign.folder import RunFolder, digest, write_atomic, writing
from campaign.provenance import provenance
from campaign.study import Study, read_study
from campaign.sweep import over_seeds
from campaign.table import write_table
from contact.quantity import InputError, nearest, to_si
from silo2d.case import SiloCase
from silo2d.protocol import PACKAGES, run_digest
from silo2d.settings import Settings, known_keys, unit_of
from silo2d.sources import SOURCES
from silo2d.sweep import run_cases


@dataclass(frozen=True)
class SiloStudy:
    """A study and the labelled cases that it stands for, all checked."""

    study: Study
    cases: list[tuple[dict[str, Any], SiloCase]]
    columns: tuple[str, ...]  # of the labels, the seed left out


def load_study(path: str | Path) -> SiloStudy:
    """The cases of a study file, in the order: case, combination, seed.

    Raises InputError or StudyError, one line that names the file, the key and what would do.
    """
    path = Path(path)
    study = read_study(path, lambda key, value: _read(f"{path}: [vary]", key, value))
    stems = [Path(name).stem for name in study.cases]
    cases = []
    for (name, stem), combination in itertools.product(
        zip(study.cases, stems, strict=True), study.combinations
    ):
        changes = {key: _written(key, value) for key, value in combination.items()}
        labels = {"case": stem if stems.count(stem) == 1 else name}
        labels |= {_column(key): value for key, value in combination.items()}
        case = SiloCase.load(_base(name, path.parent), changes)
        cases += over_seeds(labels, case, study.seeds)
    columns = ("case", *(_column(key) for key in study.combinations[0]))
    return SiloStudy(study, cases, columns)


def run_study(loaded: SiloStudy, *, out: Path, **options: Any) -> tuple[Path, list[dict[str, Any]]]:
    """Run a study and keep its table; the study's folder and the rows (see run_cases).

    The folder, out/studies/<name>-<digest>, holds study.toml, provenance.json, table.csv and
    table.h5. Raises what run_cases raises, and FolderError where the table cannot be written.
    """
    folder = study_folder(loaded, out)
    with writing(folder.path):
        folder.path.mkdir(parents=True, exist_ok=True)
    write_atomic(folder.path / "study.toml", loaded.study.text)
    folder.write_provenance(
        provenance(
            command=sys.argv,
            seed=loaded.study.draw_seed,
            packages=PACKAGES,
            sources=SOURCES.folders,
        )
    )
    rows = run_cases(loaded.cases, out=out, **options)
    write_table(folder.path, rows)
    return folder.path, rows


def study_folder(loaded: SiloStudy, out: Path) -> RunFolder:
    """Named by the runs of the study and what they are called."""
    runs = [[labels, run_digest(case)] for labels, case in loaded.cases]
    return RunFolder(Path(out) / "studies" / f"{loaded.study.name}-{digest({'runs': runs})}")


def _base(name: str, folder: Path) -> str:
    """A case file beside the study, else a preset or what SiloCase.load makes of it."""
    return str(folder / name) if (folder / name).is_file() else name


def _field(key: str) -> Any:
    section, _, name = key.partition(".")
    known = known_keys()
    if name not in known.get(section, []):
        every = [f"{section}.{name}" for section, names in known.items() for name in names]
        close = [each for each in every if each.startswith(f"{section}.")] or every
        raise InputError(f"unknown key {key!r}; {nearest(key, close)}")
    section_class: Any = Settings.model_fields[section].annotation
    return section_class.model_fields[name]


def _read(where: str, key: str, value: Any) -> Any:
    """A value as written for a key: a number in SI where the key takes quantities."""
    try:
        field = _field(key)
    except InputError as error:
        raise InputError(f"{where} {error}") from None
    return to_si(value, unit_of(field), f"{where} {key}") if _is_quantity(field) else value


def _is_quantity(field: Any) -> bool:
    choices = typing.get_args(field.annotation)  # of "X | None"
    marks = [*field.metadata, *(m for c in choices for m in getattr(c, "__metadata__", ()))]
    return any(isinstance(mark, BeforeValidator) for mark in marks)


def _written(key: str, value: Any) -> Any:
    """A value of a key as it would stand in a case file."""
    field = _field(key)
    unit = unit_of(field)
    return f"{value!r} {unit}" if _is_quantity(field) and unit != "1" else value


def _column(key: str) -> str:
    """The name of a key's column in the table: "law.kn_n_per_m"."""
    unit = unit_of(_field(key)).lower()
    if unit == "1":
        return key
    above, _, below = unit.partition("/")
    parts = [key, *([above] if above != "1" else []), *(["per", below] if below else [])]
    return "_".join(parts)
