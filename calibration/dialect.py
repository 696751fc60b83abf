"""What the lines of a table mean: separator, fields, numbers, and the head with its units."""

import csv
import re
from collections.abc import Sequence

from contact.quantity import InputError

Row = tuple[int, list[str]]  # number of the line, its fields

_UNIT = re.compile(r"\s*\[(?P<unit>[^\]]*)\]"), re.compile(r"\s*\((?P<unit>[^)]*)\)")
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+(?:[eE][-+]?[0-9]+)?")
_SPACED_FIELD = re.compile(r'"[^"]*"|\S+')
_LOOKED_AT = 50  # lines that tell the separator
_MISSING = ("", "nan", "na", "n/a", "null", "none")


def rows(text: str, where: str) -> list[Row]:
    """The fields of the lines that say something, split at what separates them.

    Raises InputError where there is no such line.
    """
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise InputError(f"{where}: empty")
    separator = _separator([line for _, line in lines[:_LOOKED_AT]])
    read = [(number, _fields(line, separator, where, number)) for number, line in lines]
    if not separator:
        read[0] = lines[0][0], _spaced_head(lines[0][1], len(read[-1][1]))
    return read


def number(field: str) -> float | None:
    """The number that a field holds, with a decimal point or comma; NaN where it is empty."""
    if "_" in field:  # which float takes for a thousand's mark
        return None
    try:
        return float(field)
    except ValueError:
        if field.lower() in _MISSING:
            return float("nan")
        return float(field.replace(",", ".")) if _DECIMAL_COMMA.fullmatch(field) else None


def name_and_unit(field: str) -> tuple[str, str]:
    """Both parts of a head such as "load [N]" or "r (m) (Cam 1)"; "" where one is missing."""
    for pattern in _UNIT:
        match = pattern.search(field)
        if match:
            return (field[: match.start()] + field[match.end() :]).strip(), match["unit"].strip()
    return field.strip(), ""


def head(rows: list[Row], where: str) -> tuple[list[str], dict[str, str], list[Row]]:
    """Names, unit of each, and the rows below; a table without a head has "column 1" and so on.

    A second line without a number, above numbers, holds units: "(mm)", "mm". Raises InputError
    where the head is missing above text, a name stands twice, or nothing stands below.
    """
    first = rows[0][1]
    if any(map(_is_number, first)) and all(number(field) is not None for field in first):
        rows = _without_surplus(rows, len(first))
        return [f"column {k + 1}" for k in range(len(first))], _no_units(len(first)), rows
    if len(rows) == 1:
        raise InputError(f"{where}: no line below the head {', '.join(first)!r}")
    body = _without_surplus(rows[1:], len(first))
    _refuse_data_as_head(first, body[0][1], where)
    below: list[str] = []
    if len(body) > 1 and _are_units(body[0][1], body[1][1]):
        below, body = body[0][1], body[1:]
    names, units = _named(first, below, where)
    return names, units, body


def _named(
    first: Sequence[str], below: Sequence[str], where: str
) -> tuple[list[str], dict[str, str]]:
    units: dict[str, str] = {}
    for k, field in enumerate(first):
        name, unit = name_and_unit(field)
        name = name or f"column {k + 1}"
        if name in units:
            raise InputError(f"{where}: two columns are called {name!r}")
        units[name] = unit or (below[k].strip("[]() ") if k < len(below) else "")
    return list(units), units


def _separator(lines: Sequence[str]) -> str:
    """Tab or semicolon where most lines have it, a comma that is no decimal one, else spaces.

    " " is one space, between fields of which some are empty; "" any number of them.
    """

    def most(separator: str) -> bool:
        share = sum(separator in line for line in lines) / len(lines)
        return separator in lines[0] and share > 0.5

    for separator in ("\t", ";"):  # text holds tabs least of all
        if most(separator):
            return separator
    fields = [line.replace('"', "").split() for line in lines]
    decimal = all(_DECIMAL_COMMA.fullmatch(f) for line in fields for f in line if "," in f)
    several = len(fields[-1]) > 1 or "," not in lines[0]
    if most(",") and not (decimal and several):
        return ","
    spaces = {line.count(" ") for line in lines}
    one_space_each = len(spaces) == 1 and any(len(line) - 1 not in spaces for line in fields)
    return " " if one_space_each else ""


def _fields(line: str, separator: str, where: str, number: int) -> list[str]:
    if not separator:
        return [field.strip('"').strip() for field in _SPACED_FIELD.findall(line)]
    if '"' not in line:
        return [part.strip() for part in line.split(separator)]
    return _quoted(line, separator, f"{where}: line {number}")


def _quoted(line: str, separator: str, where: str) -> list[str]:
    """The fields of a line in which quotes may hold separators."""
    try:
        parts = next(csv.reader([line], delimiter=separator, skipinitialspace=separator in ",;"))
    except csv.Error as error:
        raise InputError(f"{where}: {error}") from None
    parts = [part.strip() for part in parts]
    unclear = next((p for p in parts if separator == "," and _DECIMAL_COMMA.fullmatch(p)), None)
    if unclear is not None:
        raise InputError(
            f"{where}: {unclear!r}: a comma in quotes may be decimal or mark "
            "thousands; separate the fields by semicolons, or write decimal points"
        )
    return parts


def _spaced_head(line: str, width: int) -> list[str]:
    """A head above `width` fields between spaces, where names and units may hold spaces too."""
    choices = [
        [field.strip('"') for field in _SPACED_FIELD.findall(line)],
        re.split(r"\s{2,}|\t", line.strip()),
        re.split(r"\s+(?![\[(])", line.strip()),
    ]
    return next((choice for choice in choices if len(choice) == width), choices[0])


def _without_surplus(rows: list[Row], width: int) -> list[Row]:
    """Rows without the empty fields that separators at the end of a line make."""
    for _, fields in rows:
        while len(fields) > width and not fields[-1]:
            fields.pop()
    return rows


def _refuse_data_as_head(first: Sequence[str], second: Sequence[str], where: str) -> None:
    kinds = [_is_number(field) for field in first]
    if any(kinds) and kinds == [_is_number(field) for field in second]:
        raise InputError(
            f"{where}: a head is missing: the first line, {', '.join(first)!r}, holds data; write "
            "a line of names above it"
        )


def _are_units(fields: Sequence[str], below: Sequence[str]) -> bool:
    """Whether no field is a number, and one that says something stands above a number."""
    return not any(_is_number(field) for field in fields) and any(
        field and _is_number(under) for field, under in zip(fields, below, strict=False)
    )


def _is_number(field: str) -> bool:
    """Whether a field holds a number; an empty one does not."""
    return field.lower() not in _MISSING and number(field) is not None


def _no_units(width: int) -> dict[str, str]:
    return {f"column {k + 1}": "" for k in range(width)}
