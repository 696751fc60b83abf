"""Tables as people and other tools write them: CSV in any of its dialects, or a spreadsheet.

Separator comma, semicolon, tab or spaces; decimal point or decimal comma; a head of names, with
or without units ("load [N]", "load (N)", load_N, or a line of units below), or none; quotes, blank
lines and comments (#); words above the head and below the numbers. What a line is written in is
decided in calibration/files/dialect.py, what it is in calibration/files/layout.py.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from calibration.files import dialect
from calibration.files.layout import layout
from calibration.files.sheets import best_sheet, is_spreadsheet
from granulab.contact.files.units import nearest, to_si
from granulab.errors import InputError

_MOST_BYTES = 512 * 2**20


@dataclass(frozen=True)
class Table:
    """Columns of one length by name.

    path      where it was read
    columns   (n,) each, as written; an empty field is NaN; those that hold nothing but numbers
    units     of each column as written in its head; "" where there is none
    texts     of all columns, numbers too, each field as written
    lines     number of the line in the file of each row
    remarks   lines that were left out
    """

    path: Path
    columns: dict[str, NDArray[np.float64]]
    units: dict[str, str]
    texts: dict[str, tuple[str, ...]]
    lines: tuple[int, ...]
    remarks: tuple[str, ...] = ()

    def column(self, name: str, unit: str, written_in: str | None = None) -> NDArray[np.float64]:
        """A column in SI units `unit`; its head's unit, else `written_in`, says what it holds.

        Names are compared without case; "load" also finds load_N. Raises InputError with the
        names there are, or with the line of a field that is no number.
        """
        found, suffix = self._find(name, unit)
        written = self.units[found] or suffix or written_in
        if written is None and unit != "1":
            raise InputError(
                f"{self.path}: column {found!r}: the unit is missing; write it into the head, "
                f"such as '{found} [{unit}]'"
            )
        factor = 1.0 if written is None else to_si(f"1 {written}", unit, f"{self.path}: {found!r}")
        return self._numbers(found) * factor

    def has(self, name: str, unit: str = "1") -> bool:
        """True if there is a column of that name, or of that name with a unit behind it."""
        return self._search(name, unit) is not None

    def labels(self, name: str) -> tuple[str, ...]:
        """A column as text, which distinguishes groups; InputError with the names there are."""
        return self.texts[self._find(name, "1")[0]]

    def renamed(self, names: Mapping[str, str]) -> "Table":
        """The table with columns called otherwise: {"load": "Force"} or {"load": "Force [kN]"}."""
        table = self
        for name, wanted in names.items():
            head, unit = (wanted, "")
            if self._search(wanted, "1") is None:
                head, unit = dialect.name_and_unit(wanted)
            found = self._find(head, "1")[0]
            table = table._with_copy(found, name, unit or self.units[found])
        return table

    def with_units(self, units: Mapping[str, str]) -> "Table":
        """The table with units that its file lacks, or has wrong: {"time": "ms"}."""
        found = {self._find(name, "1")[0]: unit for name, unit in units.items()}
        return replace(self, units=self.units | found)

    def _with_copy(self, found: str, name: str, unit: str) -> "Table":
        taken = {key for key in self.texts if key.lower() == name.lower() and key != found}
        texts = {k: v for k, v in self.texts.items() if k not in taken}
        columns = {k: v for k, v in self.columns.items() if k not in taken}
        if found in columns:
            columns = columns | {name: columns[found]}
        units = self.units | {name: unit}
        texts |= {name: texts[found]}
        return replace(self, columns=columns, units=units, texts=texts)

    def _find(self, name: str, unit: str) -> tuple[str, str | None]:
        found = self._search(name, unit)
        if found is None:
            raise InputError(f"{self.path}: no column {name!r}; {nearest(name, self.texts)}")
        return found

    def _search(self, name: str, unit: str) -> tuple[str, str | None] | None:
        """The name as it is written, and the unit that is part of it, if any."""
        low = name.lower()
        exact = next((key for key in self.texts if key.lower() == low), None)
        if exact is not None:
            return exact, None
        for key in self.texts:
            if key.lower().startswith(low + "_"):
                suffix = key[len(low) + 1 :].replace("_per_", "/").replace("_", "/")
                if _is_unit(suffix, unit):
                    return key, suffix
        return None

    def _numbers(self, name: str) -> NDArray[np.float64]:
        if name in self.columns:
            return self.columns[name]
        line, field = next(
            (line, field)
            for line, field in zip(self.lines, self.texts[name], strict=True)
            if dialect.number(field) is None
        )
        raise InputError(f"{self.path}: line {line}: {name} = {field!r} is no number")


def _is_unit(text: str, unit: str) -> bool:
    try:
        to_si(f"1 {text}", unit, "unit")
    except InputError:
        return False
    return bool(text)


def rows_of(path: Path) -> tuple[list[dialect.Row], tuple[str, ...]]:
    """The lines of a table in any dialect or of a spreadsheet, cut into fields, and remarks.

    InputError for what is neither text nor a spreadsheet.
    """
    if is_spreadsheet(path):
        return best_sheet(path)
    return dialect.rows(text_of(path), str(path)), ()


def read_table(path: str | Path) -> Table:
    """The table of a file.

    Raises InputError, one line with file, line and value, for what is no table with numbers.
    """
    path = Path(path)
    rows, remarks = rows_of(path)
    found = layout(rows, str(path))
    width = len(found.names)
    for line, fields in found.rows:
        if len(fields) != width:
            raise InputError(f"{path}: line {line}: {len(fields)} fields and not {width}")
    texts = {name: tuple(f[k] for _, f in found.rows) for k, name in enumerate(found.names)}
    columns = {
        name: values
        for name, fields in texts.items()
        if (values := _all_numbers(fields, f"{path}: column {name!r}")) is not None
    }
    if not is_spreadsheet(path):  # whose numbers have the reader's points
        refuse_two_marks({name: texts[name] for name in columns}, str(path))
    lines = tuple(line for line, _ in found.rows)
    if not columns:
        raise InputError(f"{path}: no column of numbers{_slip(texts, lines)}")
    return Table(path, columns, found.units, texts, lines, (*remarks, *found.remarks))


def _slip(texts: Mapping[str, tuple[str, ...]], lines: tuple[int, ...]) -> str:
    """Return where a column holds something like a number that is none."""
    slips = (
        f"; line {line}: {name} = {field!r} is no number"
        for name, fields in texts.items()
        for line, field in zip(lines, fields, strict=True)
        if any(c.isdigit() for c in field) and dialect.number(field) is None
    )
    return next(slips, "")


def _all_numbers(fields: tuple[str, ...], where: str) -> NDArray[np.float64] | None:
    """The numbers of a column; None where a field is no number."""
    values = [dialect.number(field) for field in fields]
    if any(value is None for value in values):
        return None
    if any("," in field for field in fields) and any("." in field for field in fields):
        raise InputError(f"{where}: decimal commas and decimal points; write one of them")
    return np.array(values, dtype=float)


def refuse_two_marks(fields_of: Mapping[str, Sequence[str]], where: str) -> None:
    """InputError where a decimal comma stands in one column and a point in another: 1.250 is which?

    fields_of   numbers as they are written, by column or by line
    """
    marked = {
        mark: next(
            ((name, field) for name, fields in fields_of.items() for field in fields
             if mark in field and dialect.is_number(field)),
            None,
        )
        for mark in ",."
    }  # fmt: skip
    comma, point = marked.values()
    if comma is not None and point is not None:
        raise InputError(
            f"{where}: {comma[0]} = {comma[1]!r} has a decimal comma and {point[0]} = "
            f"{point[1]!r} a point, which may mark thousands; write one decimal mark and no "
            "thousands"
        )


def text_of(path: Path) -> str:
    """Text of a file, in UTF-8, UTF-16 with its mark, or the older code of Windows."""
    try:
        endless = path.is_char_device() or path.is_block_device()
        data = b"" if endless else _start(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except ValueError:  # a name that no file can have
        raise InputError(f"{str(path)!r}: cannot be read (no such name)") from None
    if endless:
        raise InputError(f"{path}: not a file")
    if len(data) > _MOST_BYTES:
        raise InputError(f"{path}: larger than {_MOST_BYTES >> 20} MiB")
    wide = data.startswith(dialect.UTF_16)
    for encoding in ("utf-16",) if wide else ("utf-8-sig", "cp1252"):
        try:
            text = data.decode(encoding)
        except UnicodeDecodeError:
            continue
        if not any(ord(c) < 32 and c not in "\t\n\r\f\v\x1c\x1d\x1e\x1f" for c in set(text)):
            return text
    raise InputError(f"{path}: not a text file")


def _start(path: Path) -> bytes:
    """As much of a file as a table may have, and one byte more."""
    with path.open("rb") as file:
        return file.read(_MOST_BYTES + 1)
