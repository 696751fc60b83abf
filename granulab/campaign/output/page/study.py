"""The page of many runs, a sweep or a map: its pictures, its tables, and the way to each run."""

import math
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from granulab.campaign.output.page.document import document, picture
from granulab.campaign.output.page.ranking import ranking_table
from granulab.campaign.output.results import read_of_study
from granulab.errors import FolderError

SCRIPTS = ("data.js", "scale.js", "theme.js", "curves.js", "points.js", "study.js")
_PAGE = Path("figures") / "page.html"
_ALSO = ("outcome", "phase", "state", "reason")  # columns that are shown at first, besides answers
_OF_THE_MACHINE = ("run_folder", "reused")

Row = dict[str, Any]


def page_of(run_folder: Path) -> Path:
    """Path of a run's page, unless another is given: beside its pictures."""
    return run_folder / _PAGE


def is_study(folder: Path) -> bool:
    """True for the folder of a sweep or a map, which holds a table."""
    return (folder / "table.csv").is_file()


def runs_of(folder: Path) -> list[Path]:
    """Folders of the runs of a sweep or map, those that are there, each once."""
    rows = _read(folder, _tables(folder)[-1])
    found = [_run_folder(_tables(folder)[-1].parent, row) for row in rows]
    return list(dict.fromkeys(run for run in found if run is not None))


def study_page(folder: Path, answers: Sequence[str], target: Path) -> str:
    """The page of a sweep or map, to stand at `target`, from which its links lead.

    answers: the columns of numbers that matter most. Raises FolderError for a folder whose table
    cannot be read, or was changed.
    """
    tables = [_table(folder, path, answers, target.parent) for path in _tables(folder)]
    rows = tables[-1]["rows"]
    state = tables[-1]["columns"].index("state") if "state" in tables[-1]["columns"] else None
    done = len(rows) if state is None else sum(row[state] == "done" for row in rows)
    linked = sum(link is not None for link in tables[-1]["links"])
    data = {
        "title": folder.resolve().name,
        "outcome": f"{len(rows)} runs, {done} done; {linked} with a page of their own",
        "figures": [
            {"name": path.stem, "source": picture(path.read_bytes())}
            for path in sorted(folder.glob("*.png"))
        ],
        "tables": [*filter(None, [ranking_table(folder)]), *tables],
    }
    return document("study.html", SCRIPTS, str(data["title"]), data)


def _tables(folder: Path) -> list[Path]:
    """The table of a study; of a map that of its points and that of its runs."""
    found = [path for path in (folder, folder / "runs") if is_study(path)]
    whole = [path / "table.parquet" for path in found]
    return [
        path if path.is_file() else path.with_suffix(".csv") for path in whole
    ]  # a version before Parquet wrote CSV only


def _read(folder: Path, path: Path) -> list[Row]:
    """The rows of a table of a study."""
    _, rows = read_of_study(folder, path.relative_to(folder).as_posix())
    return [
        {key: value for key, value in row.items() if not isinstance(value, dict)} for row in rows
    ]


def _table(folder: Path, path: Path, answers: Sequence[str], start: Path) -> dict[str, Any]:
    rows = _read(folder, path)
    names = [n for n in dict.fromkeys(k for row in rows for k in row) if n not in _OF_THE_MACHINE]
    has_runs = any("run_folder" in row for row in rows)
    labels = names[: names.index("seed") + 1] if "seed" in names else names[:2]
    key = [*labels, *(n for n in (*answers, *_ALSO) if n in names and n not in labels)]
    key = [n for n in key if any(row.get(n) not in (None, "") for row in rows)]
    runs = [_run_folder(path.parent, row) for row in rows]
    links = [None if run is None else _seen(page_of(run), start) for run in runs]
    folders = [None if run is None else _seen(run, start) for run in runs]
    plotted = _plotted(rows, labels, [n for n in answers if n in key])
    return {
        "title": "Runs" if has_runs else "Points",
        "note": _note(links) if has_runs else "",
        "columns": names,
        "rows": [[_plain(row.get(name)) for name in names] for row in rows],
        "links": links if has_runs else None,
        "folders": folders if has_runs else None,
        "key": [names.index(n) for n in key],
        "plot": {axis: names.index(name) for axis, name in plotted.items()},
    }


def _plotted(rows: Sequence[Row], labels: Sequence[str], answers: Sequence[str]) -> dict[str, str]:
    """Columns that the plot begins with: x, y and, where two labels vary by themselves, group."""
    columns = {name: [row.get(name) for row in rows] for name in labels if name != "seed"}
    varied = {name: len(set(map(str, column))) for name, column in columns.items()}
    found = {"y": answers[0]} if answers else {}
    numbers = [n for n, cells in columns.items() if all(isinstance(v, int | float) for v in cells)]
    if not numbers:
        return found
    x = found["x"] = max(numbers, key=lambda name: varied[name])
    for name, distinct in varied.items():
        pairs = {(str(row.get(name)), str(row.get(x))) for row in rows}
        if name != x and distinct > 1 and len(pairs) > varied[x]:
            return found | {"group": name}
    return found


def _note(links: Sequence[str | None]) -> str:
    missing = links.count(None)
    if not missing:
        return "Each row leads to the page of its run."
    return (
        f"{missing} of {len(links)} have no page here: view RUN makes one, view FOLDER --runs one "
        "of each that kept its frames."
    )


def _seen(path: Path, start: Path) -> str | None:
    """Address of a file or folder as seen from a folder; None where it is not there."""
    if not path.exists():
        return None
    try:
        seen = os.path.relpath(path.resolve(), start.resolve())
    except ValueError:  # on another drive
        return path.resolve().as_uri()
    return quote(Path(seen).as_posix())


def _run_folder(folder: Path, row: Row) -> Path | None:
    """Folder of a row's run, which its table names as seen from its own folder."""
    named = row.get("run_folder")
    path = Path(os.path.normpath(folder / str(named))) if named else None
    return path if path is not None and (path / "case.toml").is_file() else None


def _plain(value: Any) -> Any:
    """A cell for JSON, which has no number that is not finite."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def refuse_no_study(folder: Path) -> None:
    """Raise FolderError for a folder that is neither a run nor a study."""
    if not is_study(folder):
        raise FolderError(
            f"{folder}: neither a run folder (it has no case.toml) nor a sweep or map (no "
            "table.csv); give one of these"
        )
