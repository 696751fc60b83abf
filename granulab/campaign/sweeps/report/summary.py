"""Summary of a study after its runs: counts and estimates, in words and as files."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granulab.campaign.output.figure import as_png
from granulab.campaign.output.files import write_atomic
from granulab.campaign.output.layout import paragraphs, wrapped
from granulab.campaign.output.page.study import study_page
from granulab.campaign.output.table import as_csv, as_parquet
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.sweeps.report.chart import draw_sweep
from granulab.campaign.sweeps.report.comparison import Comparison
from granulab.campaign.sweeps.report.quantities import Quantities, Rows
from granulab.campaign.sweeps.report.words import (
    notes_on,
    order_in_words,
    ranking_as_text,
    ranking_rows,
    row_of,
)
from granulab.contact.files.units import nearest
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STATES = ("failed", "interrupted")
_MOST_FAILURES = 10  # that are listed


def ranked_by(quantities: Quantities, name: str | None) -> Quantities:
    """The quantities with one of them before all others, or as they are.

    Raises InputError where there is none of the name.
    """
    if name is None:
        return quantities
    if name not in quantities.named:
        raise InputError(f"--rank-by {name!r}: {nearest(name, quantities.named)}")
    return replace(quantities, order=(name,))


def summary(comparison: Comparison, folder: Path) -> dict[str, Any]:
    """Return the results of a study: counts, estimates by combination, ranking."""
    rows = comparison.rows
    states = Counter(row["state"] for row in rows)
    failures = [f"{_labels(comparison, row)}: {row['reason']}" for row in _of(rows, "failed")]
    lost = (r["reason"] for r in _of(rows, "interrupted") if r["reason"].endswith("went away"))
    return {
        "study": comparison.name,
        "folder": str(folder),
        "table": str(folder / "table.csv"),
        "runs": len(rows),
        "done": states["done"],
        "reused": sum(row.get("reused", False) for row in rows),
        "failed": states["failed"],
        "interrupted": states["interrupted"],
        "why_interrupted": next(lost, "stopped"),
        "failures": failures,
        "endings": comparison.endings,
        "combinations": [row_of(comparison, one) for one in comparison.combinations],
        "ranked_by": list(comparison.quantities.order),
        "ranking": ranking_rows(comparison),
    }


def as_text(comparison: Comparison, table: dict[str, Any]) -> str:
    """A summary in words: the best combinations, what failed, how the runs ended, files."""
    more = len(table["failures"]) - _MOST_FAILURES
    lines = [
        *(f"failed: {line}" for line in table["failures"][:_MOST_FAILURES]),
        *([f"failed: {more} more; the table has their reasons"] if more > 0 else []),
        f"{table['study']}: {counts(table)}",
        *(f"{name:11} {table[name]}" for name in ("table", "picture", "page") if table.get(name)),
    ]
    return paragraphs(ranking_as_text(comparison), "\n".join(wrapped(line, 8) for line in lines))


def counts(table: dict[str, Any]) -> str:
    """Numbers of runs in words: what became of them, and how they ended."""
    runs = f"{table['runs']} run{'' if table['runs'] == 1 else 's'}"
    states = ", ".join(f"{table[name]} {name}" for name in ("done", *_STATES))
    ends = ", ".join(f"{n} {word}" for word, n in table["endings"].items() if word not in _STATES)
    return f"{runs}: {states} ({table['reused']} were there before){f'; {ends}' if ends else ''}"


def _of(rows: Rows, state: str) -> Rows:
    return [row for row in rows if row["state"] == state]


def _labels(comparison: Comparison, row: dict[str, Any]) -> str:
    shown = [(one.column, row[one.column]) for one in comparison.varied]
    words = (f"{n} {v:.4g}" if isinstance(v, float) else f"{n} {v}" for n, v in shown)
    return ", ".join([*words, f"seed {row['seed']}"])


def write_ranking(folder: Path, comparison: Comparison, table: dict[str, Any]) -> None:
    """Write ranking.csv and ranking.parquet, a row a combination, and seal them.

    Raises FolderError where that fails. A folder without a provenance has no place for seals.
    """
    notes = [f"ranked by {order_in_words(comparison.quantities)}", *notes_on(comparison)]
    write_atomic(folder / "ranking.csv", as_csv(table["ranking"]))
    about = {"notes": ". ".join(notes)}
    write_atomic(folder / "ranking.parquet", as_parquet(table["ranking"], about))
    if (folder / "provenance.json").exists():
        RunFolder(folder).seal("ranking.csv", "ranking.parquet")


def write_pictures(
    folder: Path, comparison: Comparison, columns: Sequence[str], picture: str = "sweep.png",
    draw: "Callable[[Comparison], Figure | None]" = draw_sweep,
) -> dict[str, str]:  # fmt: skip
    """Write a picture and page.html into a folder; their paths by "picture" and "page".

    columns     of numbers that the page shows first; draw: makes the picture
    There is no picture where nothing was measured. Raises FolderError where they cannot be written.
    """
    written = {}
    image = as_png(lambda: draw(comparison))
    if image is not None:
        write_atomic(folder / picture, image)
        written["picture"] = str(folder / picture)
    page = folder / "page.html"
    write_atomic(page, study_page(folder, columns, page))
    return written | {"page": str(page)}
