"""Tables cut into trials: the inputs of each, in SI, its group, and where it was written."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from calibration.files.tables import Table, read_table
from calibration.statistics.quantity import measured_quantity
from calibration.tracking.film.reader import is_film
from granulab.contact.files.datafile import data_root, read_toml
from granulab.contact.files.units import nearest, to_si
from granulab.errors import InputError

Series = NDArray[np.float64]
Columns = Mapping[str, Series]

_EXTREME = 1e60  # SI
_GROUPS = ("group", "pairing")  # columns that distinguish groups unless another is given


class Input(NamedTuple):
    """A column that a method reads, or a constant in its place."""

    name: str
    unit: str  # SI
    meaning: str


class Section(NamedTuple):
    """One trial: a row of a table, or the rows of one curve."""

    group: str
    name: str
    columns: dict[str, NDArray[np.float64]]  # (n,) each, SI; constants too


@dataclass(frozen=True)
class Request:
    """Inputs as the command line describes them; sigmas in SI.

    columns     {input: head in the file}, such as {"load": "Force [kN]"}
    constants   {input: value} for what is the same in all trials
    shared      {input: sigma} of what all trials share: an instrument, a constant
    single      {input: sigma} of what differs from trial to trial: a reading
    group       the column that holds the groups, None for "group" or "pairing" if there is one
    only        the one group to be evaluated, None for all
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    constants: Mapping[str, float] = field(default_factory=dict)
    shared: Mapping[str, float] = field(default_factory=dict)
    single: Mapping[str, float] = field(default_factory=dict)
    group: str | None = None
    only: str | None = None


def request_of(
    inputs: Sequence[Input],
    columns: Sequence[str] = (),
    constants: Sequence[str] = (),
    instruments: Sequence[str] = (),
    readings: Sequence[str] = (),
    group: str | None = None,
    only: str | None = None,
) -> Request:
    """The options "load=Force [kN]", "length=300 mm +- 1 mm", "angle=0.5 deg", read.

    Raises InputError for an unknown input, a wrong unit, or what has no value.
    """
    units = {one.name: one.unit for one in inputs}
    values, shared = {}, {}
    for name, text in _pairs(constants, units, "--constant"):
        known = measured_quantity(text, units[name], f"--constant {name}")
        values[name] = known.value
        if known.sigma is not None:
            shared[name] = known.sigma
    for name, text in _pairs(instruments, units, "--instrument"):
        shared[name] = _sigma(text, units[name], f"--instrument {name}")
    single = {
        name: _sigma(text, units[name], f"--reading {name}")
        for name, text in _pairs(readings, units, "--reading")
    }
    return Request(dict(_pairs(columns, units, "--column")), values, shared, single, group, only)


def _pairs(
    options: Sequence[str], units: Mapping[str, str], flag: str
) -> Iterator[tuple[str, str]]:
    for option in options:
        name, sign, value = (part.strip() for part in option.partition("="))
        if not sign or not value:
            raise InputError(f"{flag} {option!r}: write it as '{next(iter(units))}=...'")
        if name not in units:
            raise InputError(f"{flag} {option!r}: no input {name!r}; {nearest(name, units)}")
        yield name, value


def _sigma(text: str, unit: str, where: str) -> float:
    sigma = to_si(text, unit, where)
    if sigma < 0:
        raise InputError(f"{where} = {text!r}: an uncertainty is not negative")
    return sigma


def rows(
    files: Sequence[str | Path], inputs: Sequence[Input], what: Request,
    choices: Sequence[Sequence[str]] = (),
) -> tuple[list[Section], list[str]]:  # fmt: skip
    """Each row a trial; and remarks on rows that were left out.

    choices    the sets of inputs that suffice, as `need` takes them: a row without a field of the
               first set that any row has is left out [default: without any field]
    """
    sections: list[Section] = []
    remarks: list[str] = []
    for table, columns, kept in _tables(files, inputs, what, choices, remarks):
        groups = _labels(table, what.group, remarks)
        several = len(files) > 1
        for k in np.flatnonzero(kept):
            name = f"line {table.lines[k]}" + (f" of {table.path.name}" if several else "")
            one = {key: values[k : k + 1] for key, values in columns.items()}
            sections.append(Section(groups[k], name, one))
    return chosen(sections, what.only), remarks


def curves(
    files: Sequence[str | Path], inputs: Sequence[Input], what: Request, trial: str | None = None,
    choices: Sequence[Sequence[str]] = (),
) -> tuple[list[Section], list[str]]:  # fmt: skip
    """Each file a trial, or each value of its column `trial` (None: "trial", if there is one).

    choices    as in `rows`
    """
    sections: list[Section] = []
    remarks: list[str] = []
    for table, columns, kept in _tables(files, inputs, what, choices, remarks):
        groups = _labels(table, what.group, remarks)
        if trial is not None or table.has("trial"):
            names = table.labels(trial or "trial")
        else:
            names = (table.path.stem,) * len(groups)
        labels = list(zip(groups, names, strict=True))
        for label in dict.fromkeys(labels):
            own = kept & np.array([one == label for one in labels])
            if own.any():
                one = {key: values[own] for key, values in columns.items()}
                sections.append(Section(*label, one))
    return chosen(sections, what.only), remarks


def filmed(
    files: Sequence[str | Path], measured: Callable[[Path], Mapping[str, float | Series]],
    what: Request,
) -> list[Section]:  # fmt: skip
    """Each film a trial; films in several folders are groups by the names of these.

    measured    of a film, its inputs in SI; constants stand in their place
    """
    _refuse_twice(files)
    folders = {Path(path).resolve().parent for path in files}
    sections = []
    for path in map(Path, files):
        group = path.resolve().parent.name if len(folders) > 1 else "all"
        if what.only in (None, group):
            columns = {key: np.atleast_1d(value) for key, value in measured(path).items()}
            constants = {key: np.array([value]) for key, value in what.constants.items()}
            sections.append(Section(group, path.name, columns | constants))
    return chosen(sections, what.only) if files else []


def refuse_without_films(files: Sequence[str | Path], options: Mapping[str, object]) -> None:
    """InputError for options of films that are given where every file is a table."""
    given = [name for name, value in options.items() if value is not None]
    if given and files and not any(map(is_film, files)):
        raise InputError(f"{files[0]}: a table; leave out what goes with films: {', '.join(given)}")


def chosen(sections: list[Section], only: str | None) -> list[Section]:
    """The trials of one group, None for all; InputError where there is no such group."""
    if only is None:
        return sections
    kept = [section for section in sections if section.group == only]
    if not kept:
        there = dict.fromkeys(section.group for section in sections)
        if len(there) == 1:
            raise InputError(
                f"--only {only}: the trials are not in groups; name the column that "
                "distinguishes them: --group surface"
            )
        raise InputError(f"--only {only}: no such group; {nearest(only, there)}")
    return kept


def _tables(
    files: Sequence[str | Path], inputs: Sequence[Input], what: Request,
    choices: Sequence[Sequence[str]], remarks: list[str],
) -> Iterator[tuple[Table, dict[str, NDArray[np.float64]], NDArray[np.bool_]]]:  # fmt: skip
    """Each file's inputs as far as they are there, and which rows have those that are needed."""
    _refuse_twice(files)
    for path in files:
        table = read_table(path).renamed(what.columns)
        remarks += table.remarks
        n = len(table.lines)
        columns = {}
        for one in inputs:
            if one.name in what.constants:
                columns[one.name] = np.full(n, what.constants[one.name])
            elif (head := head_of(one, table)) is not None:
                columns[one.name] = table.column(head, one.unit)
                if head != one.name:
                    remarks.append(f"{path}: {one.name} is read from {head!r}")
        if columns.keys() <= what.constants.keys():
            raise InputError(
                f"{path}: none of the columns {', '.join(one.name for one in inputs)}; it has "
                f"{', '.join(table.texts)}; say which is which: --column '{inputs[0].name}=HEAD'"
            )
        _refuse_extremes(table, columns)
        needed = _needed(columns, choices)
        kept = _whole(columns, needed)
        if not kept.any():
            raise InputError(f"{path}: no row in which {', '.join(needed)} is there")
        if not kept.all():
            remarks.append(
                f"{path}: {n - kept.sum()} of {n} rows left out: a field is empty or not finite"
            )
        gaps = [name for name, values in columns.items() if not np.isfinite(values[kept]).all()]
        remarks += [f"{path}: {name} is not used: it is empty in some rows" for name in gaps]
        yield table, {key: one for key, one in columns.items() if key not in gaps}, kept


def _needed(columns: Columns, choices: Sequence[Sequence[str]]) -> Sequence[str]:
    """The first set of inputs that a row has whole; all columns where there is none."""
    return next(
        (
            names for names in choices
            if all(name in columns for name in names) and _whole(columns, names).any()
        ),
        list(columns),
    )  # fmt: skip


def _whole(columns: Columns, names: Sequence[str]) -> NDArray[np.bool_]:
    """(n,) marks of the rows in which these inputs are there."""
    return np.asarray(np.isfinite(np.stack([columns[name] for name in names])).all(axis=0))


def head_of(one: Input, table: Table) -> str | None:
    """The head under which an input stands in a table; None where it does not."""
    if table.has(one.name, one.unit):
        return one.name
    usual = {_plain(head) for head in (one.name, *_usual_heads().get(one.name, []))}
    return next((head for head in table.texts if _plain(head) in usual), None)


@cache
def _usual_heads() -> dict[str, list[str]]:
    """Other heads of the inputs, by their names: data/heads.toml."""
    return read_toml(data_root() / "heads.toml", "heads", 1)["heads"]


def _plain(head: str) -> str:
    return "".join(c for c in head.lower() if c.isalnum())


def _refuse_extremes(table: Table, columns: Columns) -> None:
    """InputError for a value whose square or cube no floating-point number can hold."""
    for name, values in columns.items():
        size = np.abs(values)
        extreme = np.isfinite(size) & (size > 0) & ((size < 1 / _EXTREME) | (size > _EXTREME))
        if extreme.any():
            k = int(extreme.argmax())
            raise InputError(
                f"{table.path}: line {table.lines[k]}: {name} = {values[k]:g} in SI: no "
                "measurement is as large or small; check the value and the unit in the head"
            )


def _refuse_twice(files: Sequence[str | Path]) -> None:
    """The same trials counted twice would look like ones that agree."""
    seen: set[Path] = set()
    for path in files:
        if (file := Path(path).resolve()) in seen:
            raise InputError(f"{path}: given twice; its trials count once")
        seen.add(file)


def _labels(table: Table, group: str | None, remarks: list[str]) -> tuple[str, ...]:
    """The group of each row; an empty field belongs to the label above it, as in merged cells."""
    found = group or next((name for name in _GROUPS if table.has(name)), None)
    if found is None:
        return ("all",) * len(table.lines)
    labels = list(table.labels(found))
    if not labels[0]:
        raise InputError(f"{table.path}: line {table.lines[0]}: {found} is empty; name the group")
    filled = labels.count("")
    for k in range(1, len(labels)):
        labels[k] = labels[k] or labels[k - 1]
    if filled:
        remarks.append(f"{table.path}: {filled} empty fields of {found} taken as the one above")
    return tuple(labels)


def need(section: Section, choices: Sequence[Sequence[str]], inputs: Sequence[Input]) -> int:
    """Number of the first set of inputs that is whole; InputError where none is."""
    for k, names in enumerate(choices):
        if all(name in section.columns for name in names):
            return k
    units = {one.name: one.unit for one in inputs}
    sets = " or ".join(
        ", ".join(f"{n} [{units[n]}]" if units[n] != "1" else n for n in names) for names in choices
    )
    there = ", ".join(section.columns) or "nothing"
    raise InputError(
        f"{section.name}: found {there}; this needs the columns {sets}; name others by "
        f"--column '{choices[0][0]}=HEAD [UNIT]', constants by --constant"
    )
