"""The contact-parameter file: materials and pairs from TOML, checked, and back to TOML."""

import contextlib
import dataclasses
import json
import os
from collections.abc import Container, Iterable
from pathlib import Path

from granulab.contact.files.datafile import data_file
from granulab.contact.files.schema import SCHEMA, Entry, PairTable, Table, read_file, section
from granulab.contact.files.units import from_si, located, nearest, to_si
from granulab.contact.material import PROPERTIES, LinearParameters, Material, Measured, Pair
from granulab.errors import InputError


@dataclasses.dataclass(frozen=True, slots=True)
class ContactTable:
    """Materials by name and pairs by their two names.

    Raises InputError for a pair that is given twice or is of a material that is not there.
    """

    materials: dict[str, Material]
    pairs: dict[tuple[str, str], Pair]
    path: Path | None = dataclasses.field(default=None, compare=False)  # where it was read

    def __post_init__(self) -> None:
        for first, second in self.pairs:
            with located(f"{self._name}[pair.{first}-{second}]"):
                for name in (first, second):
                    if name not in self.materials:
                        hint = nearest(name, self.materials)
                        raise InputError(f"material {name!r} is not in the table; {hint}")
                refuse_turned(first, second, self.pairs)

    @property
    def _name(self) -> str:
        return f"{self.path}: " if self.path else ""

    def material(self, name: str) -> Material:
        """The material of that name; InputError lists those there are."""
        if name not in self.materials:
            hint = nearest(name, self.materials)
            raise InputError(f"{self._name}no material {name!r}; {hint}")
        return self.materials[name]

    def namesake(self) -> Material:
        """The material that the table's file is called after, or its only one; else InputError."""
        return self.materials[namesake(self.path, self.materials)]

    def pair(self, first: str, second: str) -> Pair:
        """The pair of two materials, in either order; InputError lists those there are."""
        found = self.pairs.get((first, second)) or self.pairs.get((second, first))
        if found is None:
            hint = nearest(f"{first}-{second}", ["-".join(key) for key in self.pairs])
            raise InputError(f"{self._name}no pair {first}-{second}; {hint}")
        return found


def namesake(path: Path | None, names: Iterable[str]) -> str:
    """Of the materials of a file, the one that it is called after, or its only one.

    Raises InputError where there is none, or there are several.
    """
    known, where = list(names), f"{path}: " if path else ""
    if path and path.stem in known:
        return path.stem
    if not known:
        raise InputError(f"{where}holds no material; give one as [material.NAME]")
    if len(known) > 1:
        raise InputError(
            f"{where}holds several materials ({', '.join(known)}); name the file after one of "
            "them, or set materials and material in a case file"
        )
    return known[0]


def entry_of(table: ContactTable, where: str, key: str) -> Measured | None:
    """A value by its section, as in "pair.wood-wood.linear", and key; None where it is not known.

    Raises InputError where the table has no such material or pair.
    """
    kind, names, *linear = where.split(".")
    record: object
    if kind == "material":
        record = table.material(names)
    else:
        first, _, second = names.partition("-")
        pair = table.pair(first, second)
        record = pair.linear if linear else pair
    return getattr(record, key, None)


def load_pairs(name_or_path: str | Path) -> dict[tuple[str, str], Pair]:
    """The pairs of a materials table, by their two names; see load_table."""
    return load_table(name_or_path).pairs


def load_table(name_or_path: str | Path) -> ContactTable:
    """The materials table of a shipped name, such as "wood", or of a TOML file; all SI.

    Raises InputError, one line with file, section, key and value, for whatever is wrong in it.
    """
    path = data_file("materials", str(name_or_path)) or Path(name_or_path)
    file = read_file(path)
    materials = {}
    for name, written in file.material.items():
        with located(f"{path}: {section('material', name)}"):
            materials[name] = Material(name, **_quantities(written))
    pairs = [_pair(path, names, written) for names, written in file.pair.items()]
    return ContactTable(materials, {(p.first, p.second): p for p in pairs}, path)


def _pair(path: Path, names: str, written: PairTable) -> Pair:
    with located(f"{path}: {section('pair', names, 'linear')}"):
        linear = LinearParameters(**_quantities(written.linear)) if written.linear else None
    with located(f"{path}: {section('pair', names)}"):
        first, second = two_names(names)
        known = _quantities(written)
        model = written.restitution_model
        return Pair(first, second, known["friction"], known.get("restitution"), linear, model)


def refuse_turned(first: str, second: str, pairs: Container[tuple[str, ...]]) -> None:
    """Raise InputError for a pair that is among others also the other way round."""
    if first != second and (second, first) in pairs:
        raise InputError(f"is given again as {second}-{first}; leave one out")


def two_names(names: str) -> tuple[str, str]:
    """The materials of a pair by its name; InputError for what is none."""
    first, _, second = names.partition("-")
    if not first or not second or "-" in second:
        raise InputError("a pair is named by two materials and a hyphen, such as wood-steel")
    return first, second


def _quantities(table: Table) -> dict[str, Measured]:
    return {key: measured(key, entry) for key, entry in table if isinstance(entry, Entry)}


def measured(name: str, entry: Entry) -> Measured:
    """A quantity of that name in PROPERTIES as it is written, in SI; see Entry."""
    return _measured(name, entry, name)


def _measured(name: str, entry: Entry, field: str) -> Measured:
    unit = PROPERTIES[name].unit
    value = to_si(entry.value, unit, field)
    return Measured(
        value,
        _width(entry.sigma, value, unit, f"{field}.sigma"),
        entry.source,
        entry.method,
        entry.trials,
        entry.date,
        _width(entry.scatter, value, unit, f"{field}.scatter"),
        entry.digest,
        tuple(_measured(name, old, f"{field}.history") for old in entry.history),
    )


def _width(written: object, value: float, unit: str, field: str) -> float | None:
    """A standard deviation, given as a quantity or in % of the value."""
    if isinstance(written, str) and written.rstrip().endswith(("%", "percent")):
        return abs(value) * to_si(written, "1", field)
    return None if written is None else to_si(written, unit, field)


def write_table(table: ContactTable, path: str | Path) -> None:
    """Write a table as TOML in the units people use; load_table gives an equal one back.

    The file appears whole or not at all. Raises InputError where it cannot be written.
    """
    lines = [f"schema = {SCHEMA}"]
    for material in table.materials.values():
        lines += ["", f"[material.{material.name}]", *_toml_lines(material)]
    for pair in table.pairs.values():
        key = f"pair.{pair.first}-{pair.second}"
        lines += ["", f"[{key}]", *_toml_lines(pair)]
        if pair.linear is not None:
            lines += ["", f"[{key}.linear]", *_toml_lines(pair.linear)]
    path = Path(path)
    unfinished = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
        unfinished.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None
    finally:
        with contextlib.suppress(OSError):
            unfinished.unlink()


def _toml_lines(record: Material | LinearParameters | Pair) -> list[str]:
    lines = [
        f"{field.name} = {toml_entry(field.name, getattr(record, field.name))}"
        for field in dataclasses.fields(record)
        if isinstance(getattr(record, field.name), Measured)
    ]
    if isinstance(record, Pair) and record.restitution_model is not None:
        lines.append(f"restitution_model = {_toml_text(record.restitution_model)}")
    return lines


def toml_entry(name: str, measured: Measured, unit: str | None = None) -> str:
    """A quantity of that name in PROPERTIES as TOML, in `unit` or the usual one of files."""
    unit = unit or PROPERTIES[name].unit_in_files
    written = {}
    for key in ("value", "sigma", "scatter"):
        number = getattr(measured, key)
        if number is not None and unit == "1":
            written[key] = repr(float(number))
        elif number is not None:
            written[key] = _toml_text(from_si(number, unit))
    if measured.trials is not None:
        written["trials"] = str(measured.trials)
    for key in ("method", "source", "digest"):
        if (text := getattr(measured, key)) is not None:
            written[key] = _toml_text(text)
    if measured.date is not None:
        written["date"] = measured.date.isoformat()
    if measured.history:
        old = ", ".join(toml_entry(name, one, unit) for one in measured.history)
        written["history"] = f"[{old}]"
    if len(written) == 1:
        return written["value"]
    return "{ " + ", ".join(f"{key} = {text}" for key, text in written.items()) + " }"


def _toml_text(text: str) -> str:
    # JSON's escapes are TOML's, except that TOML wants DEL escaped too.
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
