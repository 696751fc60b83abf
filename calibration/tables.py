"""Tables of numbers as people and other tools write them: CSV in any of its dialects.

Separator comma, semicolon, tab or spaces; decimal point or decimal comma; a head of names, with or
without units ("load [N]", "load (N)"), or none; blank lines and comments (#).
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from contact.quantity import InputError, nearest, to_si

_MOST_BYTES = 512 * 2**20
_NAME_AND_UNIT = re.compile(r"(?P<name>.*?)\s*(?:\[(?P<a>[^\]]*)\]|\((?P<b>[^)]*)\))?\s*")


@dataclass(frozen=True)
class Table:
    """Columns of one length by name; an empty field is NaN.

    path      where it was read
    columns   (n,) each, as written
    units     of each column as written in its head; "" where there is none
    """

    path: Path
    columns: dict[str, NDArray[np.float64]]
    units: dict[str, str]

    def column(self, name: str, unit: str, written_in: str | None = None) -> NDArray[np.float64]:
        """A column in SI units `unit`; its head's unit, else `written_in`, says what it holds.

        Names are compared without case. Raises InputError with the names there are.
        """
        found = next((key for key in self.columns if key.lower() == name.lower()), None)
        if found is None:
            raise InputError(f"{self.path}: no column {name!r}; {nearest(name, self.columns)}")
        written = self.units[found] or written_in
        if written is None and unit != "1":
            raise InputError(
                f"{self.path}: column {found!r}: the unit is missing; write it into the head, "
                f"such as '{found} [{unit}]'"
            )
        factor = 1.0 if written is None else to_si(f"1 {written}", unit, f"{self.path}: {found!r}")
        return self.columns[found] * factor


def read_table(path: str | Path) -> Table:
    """The table of a file.

    Raises InputError, one line with file, line and value, for what is no table of numbers.
    """
    path = Path(path)
    lines = _lines(path)
    separator = _separator([line for _, line in lines])
    rows = [(number, _fields(line, separator)) for number, line in lines]
    head = None if _numbers(rows[0][1], separator) is not None else rows.pop(0)[1]
    if not rows:
        raise InputError(f"{path}: no line of numbers")
    width = len(rows[0][1]) if head is None else len(head)
    names, units = _head(path, head or [f"column {k + 1}" for k in range(width)])
    values = np.empty((len(rows), width))
    for k, (number, fields) in enumerate(rows):
        found = _numbers(fields, separator)
        if found is None:
            raise InputError(
                f"{path}: line {number}: {_first_word(fields, separator)!r} is no number"
            )
        if len(found) != width:
            raise InputError(f"{path}: line {number}: {len(found)} fields and not {width}")
        values[k] = found
    columns = {name: values[:, k].copy() for k, name in enumerate(names)}
    return Table(path, columns, dict(zip(names, units, strict=True)))


def _lines(path: Path) -> list[tuple[int, str]]:
    """The lines that say something, with their numbers."""
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(f"{path}: larger than {_MOST_BYTES >> 20} MiB")
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file") from None
    kept = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not kept:
        raise InputError(f"{path}: empty")
    return kept


def _separator(lines: list[str]) -> str:
    """Semicolon or tab where lines have it, a comma between numbers, else spaces ("")."""
    last = lines[-1]
    for separator in (";", "\t"):
        if separator in last:
            return separator
    by_space = last.split()
    decimal_commas = all(
        re.fullmatch(r"[-+]?\d+,\d+(?:[eE][-+]?\d+)?", field) for field in by_space
    )
    if "," in last and not (len(by_space) > 1 and decimal_commas):
        return ","
    return ""


def _fields(line: str, separator: str) -> list[str]:
    parts = line.split(separator) if separator else line.split()
    return [part.strip().strip('"').strip() for part in parts]


def _numbers(fields: list[str], separator: str) -> list[float] | None:
    """The numbers of a line, NaN for an empty field; None where one is no number."""
    numbers = []
    for field in fields:
        try:
            numbers.append(_number(field, separator))
        except ValueError:
            return None
    return numbers


def _number(field: str, separator: str) -> float:
    if not field or field.lower() in ("nan", "na", "null", "none"):
        return np.nan
    if "_" in field:  # which float takes for a thousand's mark
        raise ValueError(field)
    return float(field if separator == "," else field.replace(",", "."))


def _first_word(fields: list[str], separator: str) -> str:
    return next(field for field in fields if _numbers([field], separator) is None)


def _head(path: Path, head: list[str]) -> tuple[list[str], list[str]]:
    """Names and units of a head; InputError where a name stands twice."""
    matches = [_NAME_AND_UNIT.fullmatch(field) for field in head]
    names = [match["name"] if match else field for match, field in zip(matches, head, strict=True)]
    names = [name or f"column {k + 1}" for k, name in enumerate(names)]
    twice = next((name for k, name in enumerate(names) if name in names[:k]), None)
    if twice is not None:
        raise InputError(f"{path}: two columns are called {twice!r}")
    return names, [(match["a"] or match["b"] or "") if match else "" for match in matches]
