"""The page of a sweep: its pictures, the ranking, and every run with a link to its folder."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from granulab.campaign.output.page.tables import Cell, Table, link, number, tables_page, text
from granulab.campaign.output.table import seen_from
from granulab.campaign.sweeps.report.axes import Varied
from granulab.campaign.sweeps.report.comparison import Comparison
from granulab.campaign.sweeps.report.quantities import heading, name_of
from granulab.campaign.sweeps.report.words import (
    in_words,
    lacking,
    notes_on,
    order_in_words,
    rank_in_words,
)

_DIGITS = 5  # of a number of one run


def sweep_page(
    comparison: Comparison, pictures: Mapping[str, bytes], folder: Path, outcome: str,
    facts: Sequence[tuple[str, str, str]],
) -> str:  # fmt: skip
    """The HTML of a page that lies in a folder; pictures: PNGs by what they show.

    outcome: a line under the title; facts: as tables_page has them.
    """
    tables = [_ranking(comparison), _runs(comparison, folder)]
    return tables_page(comparison.name, outcome, pictures, [t for t in tables if t.rows], facts)


def _ranking(comparison: Comparison) -> Table:
    """The combinations, the best first."""
    columns, measured = comparison.columns, list(comparison.quantities.named.values())
    heads = [
        ("rank", "number"),
        *_heads(comparison),
        *((heading(what), "number") for what in measured),
        ("CPU time of a run [s]", "number"),
        ("not done", ""),
    ]
    rows = []
    for one in comparison.ranking:
        own = one.combination
        found = [(what, own.estimates[name_of(what)]) for what in measured]
        rows.append(
            [
                number(rank_in_words(one), one.rank),
                *_labels(columns, own.labels),
                *(number(in_words(what, estimate), estimate.mean) for what, estimate in found),
                number("-" if own.cpu_s is None else f"{own.cpu_s:.3g}", own.cpu_s),
                text(lacking(one)),
            ]
        )
    order = order_in_words(comparison.quantities)
    marked = [k for k, one in enumerate(comparison.ranking) if one.rank is None]
    notes = [*([f"Ranked by {order}."] if order else []), *notes_on(comparison)]
    return _without_empty(Table("Combinations, the best first", heads, rows, marked, notes))


def _runs(comparison: Comparison, folder: Path) -> Table:
    """Every run, in the order of the study."""
    columns, quantities = comparison.columns, comparison.quantities
    heads = [
        *_heads(comparison),
        ("seed", "number"),
        ("ended", ""),
        *((heading(one), "number") for one in quantities.numbers),
        ("CPU time [s]", "number"),
        ("folder", ""),
        ("reason", "words"),
    ]
    rows, marked = [], []
    for k, row in enumerate(comparison.rows):
        is_done = row["state"] == "done"
        values = [one.of(row) if is_done else None for one in quantities.numbers]
        place = seen_from(folder.resolve(), Path(row["run_folder"]).resolve())
        rows.append(
            [
                *_labels(columns, row),
                number(str(row["seed"]), row["seed"]),
                text(quantities.ended(row) or str(row.get("outcome", "done")).replace("_", " ")),
                *map(_value, [*values, row.get("cpu_s")]),
                link(Path(row["run_folder"]).name, place),
                text(row["reason"]),
            ]
        )
        if not is_done:
            marked.append(k)
    return _without_empty(Table("Runs", heads, rows, marked))


def _without_empty(table: Table) -> Table:
    """The table without the columns that say nothing in any row."""
    kept = [k for k in range(len(table.columns)) if any(row[k][0] for row in table.rows)]
    return table._replace(
        columns=[table.columns[k] for k in kept],
        rows=[[row[k] for k in kept] for row in table.rows],
    )


def _heads(comparison: Comparison) -> list[tuple[str, str]]:
    words = {axis.varied for axis in comparison.axes if axis.kind == "word"}
    return [(one.heading, "" if one in words else "number") for one in comparison.columns]


def _labels(columns: Sequence[Varied], labels: Mapping[str, Any]) -> list[Cell]:
    return [_label(one, labels[one.column]) for one in columns]


def _label(column: Varied, value: Any) -> Cell:
    is_number = isinstance(value, float | int) and not isinstance(value, bool)
    return number(column.shown(value), value) if is_number else text(str(value))


def _value(value: float | None) -> Cell:
    return number("-" if value is None else f"{value:.{_DIGITS}g}", value)
