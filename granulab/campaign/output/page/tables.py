"""The page of many runs: pictures, and tables that a click on a head sorts."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple
from urllib.parse import quote

from granulab.campaign.output.page.document import document, picture

Cell = tuple[str, float | None, str]  # words, number by which it is sorted, address or ""


class Table(NamedTuple):
    """A table of a page.

    columns     heads, and whether a column holds "number", "words" or "" (short texts)
    marked      numbers of rows that are set off
    notes       lines below it
    """

    title: str
    columns: Sequence[tuple[str, str]]
    rows: Sequence[Sequence[Cell]]
    marked: Sequence[int] = ()
    notes: Sequence[str] = ()


def text(words: str) -> Cell:
    """A cell that is sorted by its letters."""
    return words, None, ""


def number(words: str, value: float | None) -> Cell:
    """A cell that is sorted by its number; at the end where there is none."""
    return (words, value, "") if value is not None else (words, None, "")


def link(words: str, path: str) -> Cell:
    """A cell that leads to a path as seen from the page; nothing else than a path comes of it."""
    return words, None, quote(path)


def tables_page(
    title: str,
    outcome: str,
    pictures: Mapping[str, bytes],
    tables: Sequence[Table],
    facts: Sequence[tuple[str, str, str]],
) -> str:
    """The HTML of a page.

    pictures: PNGs by the words that stand for them; facts: what, words, address or "".
    """
    data: dict[str, Any] = {
        "title": title,
        "outcome": outcome,
        "pictures": [{"source": picture(png), "words": words} for words, png in pictures.items()],
        "tables": [
            {
                "title": table.title,
                "columns": [{"label": label, "kind": kind} for label, kind in table.columns],
                "rows": table.rows,
                "marked": table.marked,
                "notes": table.notes,
            }
            for table in tables
        ],
        "facts": facts,
    }
    return document("tables.html", ["tables.js"], title, data)
