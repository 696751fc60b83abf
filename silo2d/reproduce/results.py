"""The rows of a table as files to keep: CSV with where it comes from, report and picture."""

import csv
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from campaign.folder import FolderError, write_atomic, writing
from campaign.table import as_csv
from silo2d.sheet import write_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from silo2d.reproduce import Row

# Columns that tell of this computer's folders, or stand in data/published.
_LEFT_OUT = ("run_folder", "reused", "published.", "dissipated_j.")


_WORDS = {"": None, "true": True, "false": False}


def origin(command: str) -> list[str]:
    """Lines that say which command, versions and machine made a table, and when."""
    from campaign.provenance import provenance
    from silo2d.protocol import PACKAGES
    from silo2d.sources import SOURCES

    known = provenance(command=sys.argv, seed=0, packages=PACKAGES, sources=SOURCES.folders)
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
    rows: "Sequence[Row]",
    lines: Sequence[str],
    text: str,
    draw: "Callable[[], Figure]",
) -> list[Path]:
    """Write NAME.csv, NAME.txt and NAME.png into a folder; FolderError where that cannot be."""
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    head = "".join(f"# {line}\n" for line in lines)
    table, words = folder / f"{name}.csv", folder / f"{name}.txt"
    write_atomic(table, head + as_csv(rows, _LEFT_OUT))
    write_atomic(words, f"{head}\n{text}\n")
    return [table, words, write_figure(folder / f"{name}.png", draw)]


def read_results(path: Path) -> "tuple[dict[str, str], list[Row]]":
    """Where the rows of a CSV come from, by word (command, versions, date, machine), and the rows.

    Numbers are numbers again, and what a run does not have is None. FolderError where the file
    is missing or is no such table.
    """
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise FolderError(
            f"{path}: cannot be read ({error}); make it with silo2d reproduce"
        ) from None
    head = [line[2:].partition(": ") for line in lines if line.startswith("# ")]
    table = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    if not table or any("state" not in row or None in row or None in row.values() for row in table):
        raise FolderError(f"{path}: not a table of silo2d reproduce, or cut short; make it again")
    rows = [{key: _value(key, text) for key, text in row.items()} for row in table]
    return {word: text for word, _, text in head}, rows


def _value(key: str, text: str) -> Any:
    if key in ("reason", "state_digest", "unit"):
        return text
    if text.lower() in _WORDS:
        return _WORDS[text.lower()]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
