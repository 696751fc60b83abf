"""Origin of each number of a parameter file."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from calibration.files.record import Record, records_of
from calibration.result import AsText
from calibration.statistics.quantity import plus_minus
from granulab.contact.files.datafile import data_file, read_toml
from granulab.contact.files.needs import lacking, lacking_words
from granulab.contact.files.schema import (
    SCHEMA,
    Entry,
    LinearTable,
    MaterialTable,
    PairTable,
    section,
)
from granulab.contact.files.table import measured
from granulab.contact.files.units import from_si, located
from granulab.contact.material import PROPERTIES, Measured, check_range

Records = Mapping[tuple[str, str], Record]


def read_values(
    name_or_path: str | Path,
) -> tuple[Path, dict[tuple[str, str], Measured], list[str]]:
    """The path of a file, its values by section and key, and what simulators still need of it.

    Sections are named as in "pair.wood-steel.linear"; values in SI. Also of a file in the making.
    Raises InputError, one line with file, section, key and value, for whatever is wrong in it.
    """
    path = data_file("materials", str(name_or_path)) or Path(name_or_path)
    tables = read_toml(path, "materials", SCHEMA)
    needs = lacking(path, tables)
    values: dict[tuple[str, str], Measured] = {}
    for kind, known in (("material", MaterialTable), ("pair", PairTable)):
        for name, table in tables.get(kind, {}).items():
            values |= _entries(path, [kind, name], table, known.model_fields)
            linear = table.get("linear", {}) if kind == "pair" else {}
            values |= _entries(path, [kind, name, "linear"], linear, LinearTable.model_fields)
    return path, values, needs


def _entries(
    path: Path, names: list[str], table: dict[str, Any], known: Any
) -> dict[tuple[str, str], Measured]:
    found = {}
    with located(f"{path}: {section(*names)}"):
        for key, written in table.items():
            if key in known and key in PROPERTIES:
                value = found[".".join(names), key] = measured(key, Entry.model_validate(written))
                check_range(key, value)
    return found


@dataclass(frozen=True, repr=False)
class Report(AsText):
    """Origin of each number of a parameter file.

    path     of the file
    values   by section and key, such as ("pair.wood-steel", "friction"), in SI
    lacking  what simulators still need of it
    records  of the values that have one: command, answers and raw data of their measurement
    """

    path: Path
    values: dict[tuple[str, str], Measured]
    lacking: list[str]
    records: Records

    def to_dict(self) -> dict[str, Any]:
        """Numbers in the SI unit that stands with them."""
        rows = [
            {"section": where, "key": key, "unit": PROPERTIES[key].unit, **_fields(value),
             "command": _command(self.records.get((where, key)))}
            for (where, key), value in self.values.items()
        ]  # fmt: skip
        return {"path": str(self.path), "values": rows, "lacking": self.lacking}

    def text(self) -> str:
        """A line for each value, its command and what it replaced below it."""
        lines, last = [str(self.path)], ""
        for (where, key), value in self.values.items():
            if where != last:
                lines += ["", f"[{where}]"]
                last = where
            lines.append(f"  {key:16}{_line(key, value)}")
            if command := _command(self.records.get((where, key))):
                lines.append(f"    {'command':14}{command}")
            lines += [f"    {'before':14}{_line(key, old)}" for old in reversed(value.history)]
        if self.lacking:
            lines += ["", f"a simulator still needs {lacking_words(self.lacking)}"]
        return "\n".join(lines)


def report(file: str | Path) -> Report:
    """The origin of each number of a parameter file, or of a shipped table, such as "wood".

    Raises InputError, one line, for what is wrong in it.
    """
    path, values, needs = read_values(file)
    return Report(path, values, needs, records_of(path, values))


def _fields(value: Measured) -> dict[str, Any]:
    return {
        "value": value.value,
        "sigma": value.sigma,
        "scatter": value.scatter,
        "trials": value.trials,
        "method": value.method,
        "source": value.source,
        "digest": value.digest,
        "date": value.date and value.date.isoformat(),
        "history": [_fields(old) for old in value.history],
    }


def _command(record: Record | None) -> str | None:
    """The command line that measured a value, where it is on record."""
    return None if record is None else " ".join(record.provenance.get("command", []))


def _line(key: str, value: Measured) -> str:
    unit = PROPERTIES[key].unit_in_files
    parts = [
        shown(value, unit),
        value.scatter and f"scatter {shown(Measured(value.scatter), unit)}",
        value.trials and f"{value.trials} trial{'s' if value.trials > 1 else ''}",
        value.method,
        value.source or "no source given",
        value.digest and f"sha256 {value.digest[:12]}",
        value.date and value.date.isoformat(),
    ]
    return "; ".join(str(part) for part in parts if part)


def shown(value: Measured, unit: str) -> str:
    """A value with its uncertainty, such as "650 +- 400 N/mm"."""
    if unit == "1":
        return plus_minus(value.value, value.sigma)
    known, sigma = (
        None if number is None else float(from_si(number, unit).split()[0])
        for number in (value.value, value.sigma)
    )
    assert known is not None
    return f"{plus_minus(known, sigma)} {unit}"
