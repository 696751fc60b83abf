"""Measured values into the contact-parameter file: what a person wrote there stays as it is.

A value that is replaced goes into the history of the new one. The file changes whole or not at
all, and one writer waits for another.
"""

import dataclasses
import datetime
import hashlib
import math
import re
import tomllib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from calibration.files.toml_edit import alone, inline, with_entry, write
from calibration.statistics.uncertainty import Estimate
from granulab.contact.files.datafile import read_toml
from granulab.contact.files.needs import lacking
from granulab.contact.files.schema import SCHEMA, LinearTable, MaterialTable, PairTable
from granulab.contact.files.table import toml_entry
from granulab.contact.files.units import located, to_si
from granulab.contact.material import PROPERTIES, Measured, check_range
from granulab.errors import InputError

_NEW = (
    "# Contact parameters, written by calibrate; each value with its method, source and date.\n"
    f"schema = {SCHEMA}\n"
)
_HOLDS = {
    "material": set(MaterialTable.model_fields),
    "pair": set(PairTable.model_fields) | set(LinearTable.model_fields),
}
_NAMES = {"material": r"\w+", "pair": r"\w+-\w+"}


@dataclasses.dataclass(frozen=True)
class Written:
    """Report on a value that was put into a file."""

    path: Path
    section: str  # such as pair.wood-steel
    key: str
    changed: bool  # no: this value, from this measurement, stood there already
    replaces: float | None  # the value before, in SI
    lacking: list[str]  # what simulators still need of the file, as "[pair.wood-steel] friction"

    def as_json(self) -> dict[str, Any]:
        """For the result of a command."""
        return dataclasses.asdict(self) | {"path": str(self.path)}


def into(
    path: str | Path,
    where: str,
    key: str,
    estimate: Estimate,
    *,
    method: str,
    source: str,
    digest: str | None = None,
    date: datetime.date | None = None,
) -> Written:
    """Add a value to a contact-parameter file, or replace the one there, which is kept as history.

    where is "material.NAME" or "pair.NAME-NAME", in either order; key is a property of
    contact.material.PROPERTIES, and the estimate in its SI unit, with 0 trials where their number
    is not known. It is written in the unit of the value that it replaces. source says in words
    what was measured, digest is the SHA-256 of that file; the date is today's unless given. A file
    that is not there is begun.

    Raises InputError, and leaves the file as it was, for a value out of range, for a section that
    cannot hold the key, and for a file that is wrong or cannot be written.
    """
    path = check_file(path)
    section = check_section(where, key)
    measured = Measured(
        estimate.value, estimate.sigma, source, method, estimate.trials or None,
        date or datetime.date.today(), estimate.scatter, digest,
    )  # fmt: skip
    with located(f"{path}: [{'.'.join(section)}]"):
        check_range(key, measured)
    with alone(path):
        return _put(path, section, key, _rounded(measured))


def check_file(path: str | Path) -> Path:
    """The path of a parameter file, there or to be begun; InputError where there can be none."""
    path = Path(path)
    if path.suffix.lower() != ".toml":
        raise InputError(f"{path}: no parameter file; give the name of a .toml file")
    if not path.resolve().parent.is_dir():
        raise InputError(f"{path}: cannot be written (no such folder)")
    return path


def check_section(where: str, key: str) -> list[str]:
    """The section "material.NAME" or "pair.NAME-NAME" in parts, with linear where the key stands.

    Raises InputError where no such section can hold the key.
    """
    kind, _, names = where.partition(".")
    if kind not in _NAMES or not re.fullmatch(_NAMES[kind], names, re.ASCII):
        raise InputError(
            f"{where!r}: no section of a parameter file; give material.NAME or pair.NAME-NAME, "
            "such as pair.wood-steel; a name takes letters, digits and _"
        )
    if key not in PROPERTIES or key not in _HOLDS[kind]:
        known = [name for name in PROPERTIES if name in _HOLDS[kind]]
        raise InputError(f"[{where}] holds no {key}; it holds {', '.join(known)}")
    return [kind, names] + (["linear"] if key in LinearTable.model_fields else [])


def digest_of(files: Iterable[Path]) -> str:
    """SHA-256 of a file, in hexadecimal; of several, that of their digests, one a line.

    Raises InputError where one cannot be read.
    """
    digests = []
    for path in files:
        try:
            with path.open("rb") as file:
                digests.append(hashlib.file_digest(file, "sha256").hexdigest())
        except OSError as error:
            raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    if len(digests) == 1:
        return digests[0]
    return hashlib.sha256("\n".join(digests).encode()).hexdigest()


def _put(path: Path, section: list[str], key: str, measured: Measured) -> Written:
    """Read the file, change one entry, and write it; see into."""
    tables, text = {}, _NEW
    if path.exists():
        tables = read_toml(path, "materials", SCHEMA)
        lacking(path, tables)  # a wrong file is refused, not repaired
        text = path.read_bytes().decode()
    section = _as_in_file(tables, section)
    holder = tables
    for name in section:
        holder = holder.setdefault(name, {})
    old = holder.get(key)
    with located(f"{path}: [{'.'.join(section)}]"):
        replaces, unit = _value_and_unit(old, key)
        entry = tomllib.loads(f"x = {toml_entry(key, measured, unit)}")["x"]
        changed = not _same(old, entry)
        if changed:
            holder[key] = entry | _history(old)
            text = _edited(text, section, key, tables)
    if changed:
        write(path, text)
    return Written(path, ".".join(section), key, changed, replaces, lacking(path, tables))


def _as_in_file(tables: dict[str, Any], section: list[str]) -> list[str]:
    """The section with the names of a pair in the order that the file has."""
    kind, names, *rest = section
    first, _, second = names.partition("-")
    known = tables.get(kind, {})
    swapped = f"{second}-{first}"
    return [kind, swapped, *rest] if names not in known and swapped in known else section


def _value_and_unit(old: Any, key: str) -> tuple[float | None, str | None]:
    """A value in SI, and the unit it is written in; None where there is none."""
    if isinstance(old, dict):
        old = old["value"]
    if old is None:
        return None, None
    value, unit = to_si(old, PROPERTIES[key].unit, key), None
    if PROPERTIES[key].unit != "1":
        number = re.match(r"\s*[+-]?[0-9.]+(?:[eE][+-]?[0-9]+)?\s*", old)
        unit = old[number.end() :].strip() if number else None
    return value, unit


def _same(old: Any, new: dict[str, Any]) -> bool:
    """True if an entry says what the new one says, at whatever date."""
    apart = ("date", "history")
    return isinstance(old, dict) and all(
        old.get(key) == new.get(key) for key in {*old, *new}.difference(apart)
    )


def _history(old: Any) -> dict[str, list[dict[str, Any]]]:
    """The history of what replaces an entry: its own, and then what it was itself."""
    if old is None:
        return {}
    old = old if isinstance(old, dict) else {"value": old}
    return {"history": [*old.get("history", []), {k: v for k, v in old.items() if k != "history"}]}


def _edited(text: str, section: list[str], key: str, tables: dict[str, Any]) -> str:
    """The text with one entry as the tables have it; InputError where it says anything else."""
    ends = "\r\n" if "\r\n" in text else "\n"
    holder = tables
    for name in section:
        holder = holder[name]
    try:
        edited = with_entry(text.replace("\r\n", "\n"), section, key, holder[key])
        said = tomllib.loads(edited)
    except ValueError:
        said = {}
    if said != {"schema": SCHEMA, **tables}:
        raise InputError(
            f"{key}: the file is laid out in a way that this cannot edit; write by hand: "
            f"{key} = {' '.join(inline(holder[key]).split())}"
        )
    return edited.replace("\n", ends)


def _rounded(measured: Measured) -> Measured:
    """A value to a hundredth of what it is uncertain by, widths to three digits."""
    value, sigma, scatter = measured.value, measured.sigma, measured.scatter
    if sigma and value:  # one that is not known at all keeps three digits of its own
        value = round(value, 2 - math.floor(math.log10(min(sigma, abs(value)))))
    three = [None if width is None else float(f"{width:.3g}") for width in (sigma, scatter)]
    return dataclasses.replace(measured, value=value, sigma=three[0], scatter=three[1])
