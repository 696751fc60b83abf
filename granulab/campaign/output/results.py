"""The rows of a table as files to keep: CSV with where it comes from, report and picture."""

import csv
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granulab.campaign.output.figure import write_figure
from granulab.campaign.output.table import as_csv
from granulab.campaign.runs.folder import FolderError, write_atomic, writing
from granulab.campaign.runs.provenance import provenance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Simulator

Row = dict[str, Any]

_LEFT_OUT = ("run_folder", "reused")  # they tell of this computer's folders
_WORDS = {"": None, "true": True, "false": False}


def origin(command: str, simulator: "Simulator") -> list[str]:
    """Lines that say which command, versions and machine made a table, and when."""
    known = provenance(
        command=sys.argv, seed=0, packages=simulator.packages, sources=simulator.sources.folders
    )
    versions = ", ".join(f"{name} {number}" for name, number in known["versions"].items())
    machine = known["machine"]
    return [
        f"command: {command}",
        f"versions: granulab {known['granulab']}, {versions}; sources {known['source_digest']}",
        f"date: {known['started']}",
        f"machine: {machine['cpu']}, {machine['cores']} cores, {machine['platform']}",
    ]


def write_results(
    folder: Path,
    name: str,
    rows: Sequence[Row],
    lines: Sequence[str],
    text: str,
    draw: "Callable[[], Figure]",
    left_out: tuple[str, ...] = (),
) -> list[Path]:
    """Write NAME.csv, NAME.txt and NAME.png into a folder; FolderError where that cannot be.

    left_out: beginnings of names of columns that the CSV does not keep.
    """
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    head = "".join(f"# {line}\n" for line in lines)
    table, words = folder / f"{name}.csv", folder / f"{name}.txt"
    write_atomic(table, head + as_csv(rows, _LEFT_OUT + left_out))
    write_atomic(words, f"{head}\n{text}\n")
    return [table, words, write_figure(folder / f"{name}.png", draw)]


def read_results(path: Path) -> tuple[dict[str, str], list[Row]]:
    """Where the rows of a CSV come from, by word (command, versions, date, machine), and the rows.

    Numbers are numbers again, and what a run does not have is None. FolderError where the file
    is missing or is no such table.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FolderError(
            f"{path}: cannot be read ({error}); make it with the command reproduce"
        ) from None
    head = [line[2:].partition(": ") for line in lines if line.startswith("# ")]
    table = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    if not table or any("state" not in row or None in row or None in row.values() for row in table):
        raise FolderError(
            f"{path}: not a table of the command reproduce, or cut short; make it again"
        )
    rows = [{key: _value(key, text) for key, text in row.items()} for row in table]
    return {word: text for word, _, text in head}, rows


def _value(key: str, text: str) -> Any:
    if key in ("reason", "state_digest", "unit"):
        return text
    if text.lower() in _WORDS:
        return _WORDS[text.lower()]
    if text.startswith("["):
        return json.loads(text)
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
