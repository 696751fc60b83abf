"""Layout of a table: lines that hold names, units and numbers, and words around them.

Spreadsheets write a title and remarks above the head, means and notes below the numbers. Some
columns hold numbers in most lines; the table reaches from the first line with numbers in most of
these columns to the last one. What is left out is reported.
"""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from calibration.files.dialect import Row, is_missing, is_number, name_and_unit, number
from granulab.contact.files.units import is_unit
from granulab.errors import InputError

_LIKE_A_NUMBER = re.compile(r"[-+.,]?\d")
_LOOKED_AT = 200  # lines among which the numbers begin
_MEANS = {  # what spreadsheets call the lines that they make of others,
    "mean", "average", "mittelwert", "mittel", "durchschnitt", "moyenne", "media", "ø", "median",
    "sd", "std", "stdev", "std dev", "std. dev", "stdabw", "standardabweichung", "sum", "summe",
    "total", "cv", "rsd",
}  # fmt: skip
_WITH_MEANS = {"min", "max", "minimum", "maximum", "n", "count", "anzahl"}  # and next to these


@dataclass(frozen=True)
class Layout:
    """Names of the columns, unit of each ("" where there is none), the rows, what was left out.

    headed is False for names that stand nowhere: "column 1".
    """

    names: list[str]
    units: dict[str, str]
    rows: list[Row]
    remarks: tuple[str, ...] = ()
    headed: bool = True


def layout(rows: Sequence[Row], where: str) -> Layout:
    """The parts of a table; one without a head has "column 1" and so on.

    A line of units may stand between head and numbers: "(mm)", "mm". Raises InputError where the
    head is missing above text, a name stands twice, or nothing stands below.
    """
    counts = _counted(rows)
    begin = _begin(rows, counts)
    if begin is None:
        begin = 1  # no numbers at all: who reads the columns says so
        if len(rows) == 1:
            raise InputError(f"{where}: no line below the head {', '.join(rows[0][1])!r}")
    body, below = _parted(rows[begin:], counts)
    above = [fields for _, fields in rows[:begin]]
    head, units, spare = _head(above, len(counts))
    headed = bool(head)
    width = len(head) if head else len(body[0][1])
    body = _without_surplus(body, width)
    if not head:
        _refuse_data_as_head(body[0][1], where)
        _refuse_half_a_head(rows[:begin], len(counts), where)
        head = [f"column {k + 1}" for k in range(width)]
    names, units_of = _named(head, units, where)
    remarks = (
        [f"{where}: {len(spare)} lines above the head left out"] if any(map(any, spare)) else []
    )
    remarks += [
        f"{where}: line {line} left out, a note or made from other lines: "
        f"{' '.join(filter(None, fields))[:60]!r}"
        for line, fields in below
        if any(fields)
    ]
    return Layout(names, units_of, body, tuple(remarks), headed)


def _counted(rows: Sequence[Row]) -> list[int]:
    """The columns that hold numbers in most of the longest run of lines with a number."""
    longest: list[list[str]] = []
    run: list[list[str]] = []
    for _, fields in rows[:_LOOKED_AT]:
        run = [*run, fields] if any(map(is_number, fields)) else []
        longest = max(longest, run, key=len)
    held = Counter(k for fields in longest for k, field in enumerate(fields) if is_number(field))
    return [k for k, times in sorted(held.items()) if 2 * times > len(longest)]


def _begin(rows: Sequence[Row], counted: Sequence[int]) -> int | None:
    """The first line of numbers; lines above it in which they are missing or slips belong to it."""

    def slip(field: str) -> bool:
        return is_missing(field) or _LIKE_A_NUMBER.match(field) is not None

    begin = next((k for k, (_, fields) in enumerate(rows) if _is_data(fields, counted)), None)
    while begin and all(map(slip, _at(rows[begin - 1][1], counted))):
        begin -= 1
    return begin


def _at(fields: Sequence[str], counted: Sequence[int]) -> list[str]:
    return [fields[k] if k < len(fields) else "" for k in counted]


def _is_data(fields: Sequence[str], counted: Sequence[int]) -> bool:
    """True if most of the counted columns hold numbers; some may be missing, or be words."""
    held = _at(fields, counted)
    words = sum(number(field) is None for field in held)
    return 2 * words < len(held) and any(map(is_number, held))


def _parted(rows: Sequence[Row], counted: Sequence[int]) -> tuple[list[Row], list[Row]]:
    """The lines of numbers, and those of words below, and of means that a spreadsheet made."""
    end = len(rows)
    while end > 1 and _is_note(rows[end - 1][1], counted):
        end -= 1
    labels = [_label(fields) for _, fields in rows[:end]]
    made = _MEANS | _WITH_MEANS if _MEANS.intersection(labels) else set()
    kept = [row for row, label in zip(rows[:end], labels, strict=True) if label not in made]
    spare = [row for row, label in zip(rows[:end], labels, strict=True) if label in made]
    return kept, spare + list(rows[end:])


def _label(fields: Sequence[str]) -> str:
    """The first word of a line."""
    return _plain(next((field for field in fields if field and number(field) is None), ""))


def _plain(word: str) -> str:
    return word.strip(" :.=").lower()


def is_made_of_others(label: str) -> bool:
    """True for the label of a line that spreadsheets make of those above: "SD [mm]", "max:"."""
    return _plain(name_and_unit(label)[0].rstrip("% ")) in _MEANS | _WITH_MEANS


def slip_in(fields: Sequence[str]) -> str | None:
    """The first field of a line of numbers that holds neither a number nor nothing; None of none.

    A line of words alone is a note.
    """
    held = [field for field in fields if not is_missing(field)]
    wrong = [field for field in held if number(field) is None]
    slips = wrong and (len(wrong) < len(held) or any(map(_LIKE_A_NUMBER.match, wrong)))
    return wrong[0] if slips else None


def _is_note(fields: Sequence[str], counted: Sequence[int]) -> bool:
    """True if words stand where the numbers stood; what begins like a number is a slip."""
    held = [field for field in _at(fields, counted) if not is_missing(field)]
    slips = any(map(_LIKE_A_NUMBER.match, held))
    return not any(fields) or (bool(held) and not slips and not _is_data(fields, counted))


def _head(
    above: Sequence[list[str]], counted: int
) -> tuple[list[str], list[str], Sequence[list[str]]]:
    """Names, units, and the other lines; [] for names where no line has enough words.

    Remarks of fewer words may stand between the names and the numbers.
    """

    def filled(fields: Sequence[str]) -> int:
        return sum(map(bool, fields))

    if len(above) > 1 and _are_units(above[-1], above[-2]):
        return above[-2], above[-1], above[:-2]
    enough = [k for k, fields in enumerate(above) if filled(fields) >= counted]
    if counted > 1 and not enough:  # pandas writes no name above its column of line numbers
        enough = [k for k, one in enumerate(above) if not one[0] and filled(one) + 1 >= counted]
    if not enough:
        return [], [], above
    k = enough[-1]
    return above[k], [], [*above[:k], *above[k + 1 :]]


def _are_units(fields: Sequence[str], names: Sequence[str]) -> bool:
    """True if most fields are units and stand below names (some of cells that were merged)."""
    said = [(field, names[k] if k < len(names) else "") for k, field in enumerate(fields) if field]
    known = sum(is_unit(field.strip("[]() ")) for field, _ in said)
    named = sum(bool(name) for _, name in said)
    without = not any(name_and_unit(name)[1] for _, name in said)  # which would be said twice
    return without and min(2 * known, 2 * named) >= len(said) > 0


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


def _without_surplus(rows: list[Row], width: int) -> list[Row]:
    """Rows without the empty fields that separators at the end of a line make."""
    for _, fields in rows:
        while len(fields) > width and not fields[-1]:
            fields.pop()
    return rows


def _refuse_data_as_head(first: Sequence[str], where: str) -> None:
    if not all(number(field) is not None for field in first):
        raise InputError(
            f"{where}: a head is missing: the first line, {', '.join(first)!r}, holds data; write "
            "a line of names above it"
        )


def _refuse_half_a_head(above: Sequence[Row], counted: int, where: str) -> None:
    """A head in another dialect than its numbers would be lost, and its units with it."""
    words = [(line, ", ".join(filter(None, fields))) for line, fields in above if any(fields)]
    if words:
        line, said = words[-1]
        raise InputError(
            f"{where}: line {line}, {said[:60]!r}, stands above {counted} columns of numbers and "
            "does not name them; write a line of names, or # before what is none"
        )
