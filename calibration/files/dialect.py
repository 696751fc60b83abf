"""Dialect of a table's lines: separator, fields, numbers, names with their units."""

import csv
import re
from collections.abc import Sequence

from granulab.errors import InputError

Row = tuple[int, list[str]]  # number of the line, its fields

UTF_16 = (b"\xff\xfe", b"\xfe\xff")  # marks that such a text begins with

_UNIT = re.compile(r"\s*\[(?P<unit>[^\]]*)\]"), re.compile(r"\s*\((?P<unit>[^)]*)\)")
_DECIMAL_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+(?:[eE][-+]?[0-9]+)?")
_SPACED_FIELD = re.compile(r'"[^"]*"|\S+')
_SEPARATOR_LINE = re.compile(r'"?sep=(?P<separator>.)"?')  # what Excel reads and writes on top
_LOOKED_AT = 50  # lines at either end that show the separator
_MISSING = ("", "nan", "na", "n/a", "null", "none")
_NUMBER_HEAD = re.compile(r"#[;,\t]\s*[^;,\s]")  # a head whose first column is called #
_SHEET_ERROR = re.compile(r"#(?:N/A|NV|[A-ZÄÖÜ0/]+[!?])")  # #DIV/0!, #WERT!: no value there


def rows(text: str, where: str) -> list[Row]:
    """The fields of the lines that say something, split at what separates them.

    Raises InputError where there is no such line.
    """
    numbered = [one for one in enumerate(text.splitlines(), start=1) if one[1].strip()]
    lines = [one for one in numbered if not _is_remark(one[1])]
    above = numbered[: numbered.index(lines[0])] if lines else []
    lines = [one for one in above if _NUMBER_HEAD.match(one[1])][-1:] + lines
    said = _SEPARATOR_LINE.fullmatch(lines[0][1].strip()) if lines else None
    lines = lines[1:] if said else lines
    if not lines:
        raise InputError(f"{where}: empty")
    plain = [line for _, line in lines]
    ends = plain[:_LOOKED_AT] + plain[_LOOKED_AT:][-_LOOKED_AT:]
    separator = said["separator"] if said else _separator(ends)
    read = [(number, _fields(line, separator, where, number)) for number, line in lines]
    return read if separator else _spaced_words(read, plain)


def _is_remark(line: str) -> bool:
    """True for a line that begins with # and no error of a spreadsheet."""
    return line.lstrip()[0] == "#" and _SHEET_ERROR.match(line.lstrip()) is None


def number(field: str) -> float | None:
    """The number that a field holds, with a decimal point or comma; NaN where it is empty."""
    if "_" in field:  # which float takes for a thousand's mark
        return None
    try:
        return float(field)
    except ValueError:
        if is_missing(field):
            return float("nan")
        field = field.replace("\N{MINUS SIGN}", "-")
        return float(field.replace(",", ".")) if _DECIMAL_COMMA.fullmatch(field) else None


def is_missing(field: str) -> bool:
    """True if a field says that there is no number: empty, "n/a", an error of a spreadsheet."""
    return field.lower() in _MISSING or _SHEET_ERROR.fullmatch(field) is not None


def is_number(field: str) -> bool:
    """True if a field holds a number; an empty one does not."""
    return not is_missing(field) and number(field) is not None


def name_and_unit(field: str) -> tuple[str, str]:
    """Both parts of a head such as "load [N]" or "r (m) (Cam 1)"; "" where one is missing."""
    for pattern in _UNIT:
        match = pattern.search(field)
        if match:
            return (field[: match.start()] + field[match.end() :]).strip(), match["unit"].strip()
    return field.strip(), ""


def _separator(lines: Sequence[str]) -> str:
    """Tab or semicolon where most lines have it, a comma that is no decimal one, else spaces.

    " " is one space, between fields of which some are empty; "" any number of them.
    """

    def most(separator: str) -> bool:
        return sum(separator in line for line in lines) > 0.5 * len(lines)

    for separator in ("\t", ";"):  # text holds tabs least of all
        if most(separator):
            return separator
    fields = [line.replace('"', "").split() for line in lines]
    decimal = all(_DECIMAL_COMMA.fullmatch(f) for line in fields for f in line if "," in f)
    several = len(fields[-1]) > 1 or "," not in lines[0]
    if most(",") and not (decimal and several):
        return ","
    spaces = {line.count(" ") for line in lines}
    one_space_each = len(spaces) == 1 and len({len(words) for words in fields}) > 1
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


def _spaced_words(rows: list[Row], lines: Sequence[str]) -> list[Row]:
    """Rows between spaces, the words cut to as many fields as most lines have numbers."""
    widths = [len(fields) for _, fields in rows if any(map(is_number, fields))]
    if not widths:
        return rows
    width = max(set(widths), key=widths.count)
    return [
        row if any(map(is_number, row[1])) else (row[0], _spaced_head(line, width))
        for row, line in zip(rows, lines, strict=True)
    ]


def _spaced_head(line: str, width: int) -> list[str]:
    """A head above `width` fields between spaces, where names and units may hold spaces too."""
    choices = [
        [field.strip('"') for field in _SPACED_FIELD.findall(line)],
        re.split(r"\s{2,}|\t", line.strip()),
        re.split(r"\s+(?![\[(])", line.strip()),
    ]
    return next((choice for choice in choices if len(choice) == width), choices[0])
