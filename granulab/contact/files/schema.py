"""Schema of a contact-parameter file: its tables and keys; units and ranges are checked later."""

import datetime
import reprlib
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, ValidationError, model_validator

from granulab.contact.files.datafile import read_toml
from granulab.contact.files.units import nearest
from granulab.contact.material import PROPERTIES
from granulab.errors import InputError

SCHEMA = 1


class Table(BaseModel):
    """A TOML table that takes the keys of its class and no others."""

    model_config = ConfigDict(strict=True)

    @model_validator(mode="before")
    @classmethod
    def _only_known_keys(cls, table: object) -> object:
        if not isinstance(table, dict):
            raise ValueError("expected a table of keys")
        for key in table:
            if key not in cls.model_fields:
                raise ValueError(f"unknown key {key!r}; {nearest(key, cls.model_fields)}")
        return table


class Entry(Table):
    """A quantity as it is written: alone, or in a table with what is known of it."""

    value: Any  # a text with its unit, or a pure number: granulab.contact.files.units reads it
    sigma: Any = None  # likewise, or a text in % of the value
    source: str | None = None
    method: str | None = None
    trials: int | None = None
    date: datetime.date | None = None
    scatter: Any = None  # of a single trial, as sigma
    digest: str | None = None
    history: "list[Entry]" = []

    @model_validator(mode="before")
    @classmethod
    def _bare_value(cls, written: object) -> object:
        return written if isinstance(written, dict) else {"value": written}


class MaterialTable(Table):
    """[material.NAME]"""

    density: Entry
    length: Entry | None = None
    youngs_modulus: Entry | None = None
    poisson: Entry | None = None
    yield_strength: Entry | None = None
    loss_factor: Entry | None = None


class LinearTable(Table):
    """[pair.NAME-NAME.linear]"""

    kn: Entry | None = None
    kt: Entry | None = None
    gamma_n: Entry | None = None
    gamma_t: Entry | None = None


class PairTable(Table):
    """[pair.NAME-NAME]"""

    friction: Entry
    restitution: Entry | None = None
    restitution_model: Literal["constant"] | None = None  # whatever the speed
    linear: LinearTable | None = None


class File(Table):
    """All but the schema number, which is read first."""

    material: dict[str, MaterialTable]
    pair: dict[str, PairTable] = {}


def read_file(path: Path) -> File:
    """The tables of a TOML file as they are written; InputError for a wrong key or structure.

    All keys that are missing are named at once.
    """
    tables = read_toml(path, "materials", SCHEMA, lambda found: _lacks(path, found))
    absent = missing_keys(path, tables)
    if absent:
        raise InputError(f"{path}: {missing_words(absent)}")
    return File.model_validate(tables)


def missing_keys(path: Path, tables: dict[str, Any]) -> list[tuple[str, str]]:
    """Sections and keys that every file must have and these tables do not.

    Raises InputError for a wrong key or structure.
    """
    try:
        File.model_validate(tables)
    except ValidationError as error:
        problems = error.errors()
    else:
        return []
    for problem in problems:
        if problem["type"] != "missing" or problem["loc"][-1] == "value":
            raise InputError(f"{path}: {_one_line(problem)}")
    return [_section_and_key(problem["loc"]) for problem in problems]


def _lacks(path: Path, tables: dict[str, Any]) -> str:
    absent = missing_keys(path, tables)
    return missing_words(absent) if absent else ""


def missing_words(absent: list[tuple[str, str]]) -> str:
    """Keys that are missing, in words, with the units that files use: one phrase a section."""
    by_section: dict[str, list[str]] = {}
    for where, name in absent:
        known = PROPERTIES.get(name)
        unit = known.unit_in_files if known else "1"
        by_section.setdefault(where, []).append(name if unit == "1" else f"{name} [{unit}]")
    parts = [
        f"[{_shown(where)}] {', '.join(names)}".rstrip() for where, names in by_section.items()
    ]
    if len(absent) > 1:
        return f"missing: {'; '.join(parts)}"
    name, bracket, unit = parts[0].rpartition(" [")
    return f"{name} is missing; give it in {unit[:-1]}" if bracket else f"{parts[0]} is missing"


def _section_and_key(loc: tuple[int | str, ...]) -> tuple[str, str]:
    """The section, as in "pair.wood-wood.linear", and the key of a position in the file."""
    path = [str(part) for part in loc]
    depth = 3 if path[2:3] == ["linear"] else 2
    return ".".join(_shown(key) for key in path[:depth]), ".".join(path[depth:])


def _place(loc: tuple[int | str, ...]) -> str:
    """Position in the file, such as [pair.wood-wood] friction."""
    where, name = _section_and_key(loc)
    return " ".join(filter(None, [f"[{where}]" if where else "", name]))


def _one_line(problem: Any) -> str:
    """One error in the structure of a file, as pydantic reports it, in one line."""
    where = _place(problem["loc"])
    if problem["type"] == "value_error":  # raised by Table
        return f"{where}: {problem['ctx']['error']}".removeprefix(": ")
    if problem["type"] == "missing":
        return missing_words([_section_and_key(problem["loc"])])
    return f"{where} = {reprlib.repr(problem['input'])}: {problem['msg'].lower()}"


def section(*keys: str) -> str:
    """The head of a TOML table, such as [pair.wood-wood], for an error line."""
    return f"[{'.'.join(_shown(key) for key in keys)}]" if keys else ""


def _shown(key: str) -> str:
    return key if key.isprintable() else repr(key)
