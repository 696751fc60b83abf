"""The ranking of a study as a table of its page: an estimate and its interval in one cell."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from granulab.campaign.output.layout import share_within, with_half_width
from granulab.campaign.output.results import read_of_study

_FILE = "ranking.parquet"
_PARTS = ("mean", "sd", "n", "low", "high")  # of an estimate: columns "efficiency.mean", ...
_ALSO = ("as_good_as_best",)  # that stand in other cells

Row = Mapping[str, Any]


def ranking_table(folder: Path) -> dict[str, Any] | None:
    """The table of the combinations of a study, the best first; None where it has none.

    A cell is a value, or words and the number by which they are sorted. Raises FolderError where
    the file cannot be read, or was changed.
    """
    if not (folder / _FILE).is_file():
        return None
    about, rows = read_of_study(folder, _FILE)
    names = [name for name in rows[0] if name not in _ALSO and not _is_part(name, rows[0])]
    columns = [name for name in names if any(_cell(name, row) is not None for row in rows)]
    cells = [[_cell(name, row) for name in columns] for row in rows]
    told_apart = [k for k in range(len(columns)) if any(line[k] != cells[0][k] for line in cells)]
    return {
        "title": "Combinations, the best first",
        "note": about.get("notes", ""),
        "columns": [name.removesuffix(".mean") for name in columns],
        "rows": cells,
        "links": None,
        "key": told_apart or list(range(len(columns))),
        "plot": {},
    }


def _is_part(name: str, row: Row) -> bool:
    """True for the parts of an estimate, but the one that stands for all of it."""
    whole, _, part = name.rpartition(".")
    return part in _PARTS[1:] and (whole in row or f"{whole}.mean" in row)


def _cell(name: str, row: Row) -> Any:
    value = row[name]
    if value is None:
        return None
    if name == "rank":
        return {
            "words": f"{value}{'~' if row['as_good_as_best'] and value > 1 else ''}",
            "by": value,
        }
    if name.endswith(".mean"):
        return {"words": _estimate(name.removesuffix(".mean"), row), "by": value}
    if f"{name}.low" in row:
        ends = row[f"{name}.low"], row[f"{name}.high"]
        return {"words": share_within(value, row["runs"], *ends), "by": value / max(row["runs"], 1)}
    return value


def _estimate(name: str, row: Row) -> str:
    low, high, n = (row[f"{name}.{part}"] for part in ("low", "high", "n"))
    half = None if low is None or high is None else (high - low) / 2
    runs = f"{n}" if n == row["runs"] else f"{n} of {row['runs']}"
    return f"{with_half_width(row[f'{name}.mean'], half)} ({runs})"
