"""Schema of a contact-parameter file: its tables and keys; units and ranges are checked later."""

import datetime
import reprlib
from pathlib import Path
from typing import Any

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


class LinearTable(Table):
    """[pair.NAME-NAME.linear]"""

    kn: Entry
    kt: Entry
    gamma_n: Entry
    gamma_t: Entry


class PairTable(Table):
    """[pair.NAME-NAME]"""

    friction: Entry
    restitution: Entry | None = None
    linear: LinearTable | None = None


class File(Table):
    """All but the schema number, which is read first."""

    material: dict[str, MaterialTable]
    pair: dict[str, PairTable] = {}


def read_file(path: Path) -> File:
    """The tables of a TOML file as they are written; InputError for a wrong key or structure."""
    try:
        return File.model_validate(read_toml(path, "materials", SCHEMA))
    except ValidationError as error:
        raise InputError(f"{path}: {_one_line(error.errors()[0])}") from None


def lacking(path: Path, tables: dict[str, Any]) -> list[str]:
    """Keys that simulators need and the tables of an unfinished file do not have yet.

    As in "[pair.wood-steel] friction". Raises InputError for a wrong key or structure.
    """
    try:
        File.model_validate(tables)
    except ValidationError as error:
        problems = error.errors()
    else:
        problems = []
    absent = [p["loc"] for p in problems if p["type"] == "missing" and p["loc"][-1] != "value"]
    for problem in problems:
        if problem["loc"] not in absent:
            raise InputError(f"{path}: {_one_line(problem)}")
    materials = tables.get("material", {})
    named = dict.fromkeys(name for pair in tables.get("pair", {}) for name in pair.split("-"))
    unknown = [f"{section('material', name)} density" for name in named if name not in materials]
    return unknown + [_place(loc) for loc in absent if loc != ("material",)]


def _place(loc: tuple[int | str, ...]) -> str:
    """Position in the file, such as [pair.wood-wood] friction."""
    path = [str(part) for part in loc]
    depth = 3 if path[2:3] == ["linear"] else 2
    return " ".join(filter(None, [section(*path[:depth]), ".".join(path[depth:])]))


def _one_line(problem: Any) -> str:
    """One error in the structure of a file, as pydantic reports it, in one line."""
    where = _place(problem["loc"])
    if problem["type"] == "value_error":  # raised by Table
        return f"{where}: {problem['ctx']['error']}".removeprefix(": ")
    if problem["type"] == "missing":
        known = PROPERTIES.get(str(problem["loc"][-1]))
        unit = known.unit_in_files if known else "1"
        return f"{where} is missing" + ("" if unit == "1" else f"; give it in {unit}")
    return f"{where} = {reprlib.repr(problem['input'])}: {problem['msg'].lower()}"


def section(*keys: str) -> str:
    """The head of a TOML table, such as [pair.wood-wood], for an error line."""
    shown = [key if key.isprintable() else repr(key) for key in keys]
    return f"[{'.'.join(shown)}]" if keys else ""
