"""The rows of a table as files to keep: CSV and Parquet with their origin, report and picture."""

import csv
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from granulab.campaign.output.figure import write_figure
from granulab.campaign.output.files import write_atomic, writing
from granulab.campaign.output.table import as_csv, as_parquet, read_parquet
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.provenance import in_words, provenance
from granulab.campaign.runs.seal import sha256_of
from granulab.errors import DamagedError, FolderError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from granulab.campaign.sweeps.sweep import Simulator

Row = dict[str, Any]

_OF_THIS_MACHINE = ("run_folder", "reused")  # no part of a result
_ALWAYS = ("seed", "state", "reason")
_WORDS = {"": None, "true": True, "false": False}


def origin(command: str, simulator: "Simulator") -> list[str]:
    """Lines that say which command, versions, arithmetic and machine made a table, and when."""
    known = provenance(
        command=sys.argv, seed=0, packages=simulator.packages, sources=simulator.sources.folders
    )
    versions = ", ".join(f"{name} {number}" for name, number in known["versions"].items())
    machine = known["machine"]
    return [
        f"command: {command}",
        f"versions: granulab {known['granulab']}, {versions}; sources {known['source_digest']}",
        f"date: {known['started']}",
        f"arithmetic: {in_words(known['arithmetic'])}",
        f"machine: {machine['cpu']}, {machine['cores']} cores, {machine['platform']}",
    ]


def write_results(
    folder: Path,
    name: str,
    rows: Sequence[Row],
    lines: Sequence[str],
    text: str,
    draw: "Callable[[], Figure] | None",
    kept: tuple[str, ...] | None = None,
) -> list[Path]:
    """Write NAME.csv, .parquet, .txt and .png into a folder; FolderError where that cannot be.

    draw: makes the picture; None: there is none. kept: the columns of the CSV, as
    PublishedTable.COLUMNS names them; Parquet has all of them.
    """
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    head = "".join(f"# {line}\n" for line in lines)
    table, whole, words = (folder / f"{name}.{kind}" for kind in ("csv", "parquet", "txt"))
    own = [{k: v for k, v in row.items() if k not in _OF_THIS_MACHINE} for row in rows]
    write_atomic(table, head + as_csv(own, None if kept is None else kept + _ALWAYS))
    write_atomic(whole, as_parquet(own, origin_words(lines)))
    write_atomic(words, f"{head}\n{text}\n")
    pictures = [write_figure(folder / f"{name}.png", draw)] if draw else []
    return [table, whole, words, *pictures]


def origin_words(lines: Sequence[str]) -> dict[str, str]:
    """The lines of `origin` by their first word: command, versions, date, arithmetic, machine."""
    parts = [line.partition(": ") for line in lines]
    return {word: text for word, _, text in parts}


def read_results(
    path: str | Path, by: str = "the command reproduce"
) -> tuple[dict[str, str], list[Row]]:
    """Return the origin of a CSV or Parquet file, by word (see origin_words), and its rows.

    Numbers are numbers again, and what a run does not have is None. FolderError where the file
    is missing or is no such table; by: what makes it.
    """
    path = Path(path)
    try:
        if path.suffix == ".parquet":
            return read_parquet(path)
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError) as error:
        raise FolderError(f"{path}: cannot be read ({error}); make it again with {by}") from None
    head = origin_words([line[2:] for line in lines if line.startswith("# ")])
    table = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    if not table or any("state" not in row or None in row or None in row.values() for row in table):
        raise FolderError(f"{path}: not a table of {by}, or cut short; make it again")
    rows = [{key: _value(key, text) for key, text in row.items()} for row in table]
    return head, rows


def read_of_study(folder: Path, name: str) -> tuple[dict[str, str], list[Row]]:
    """Origin and rows of a table in the folder of a sweep or map, once its seal is found to hold.

    Raises FolderError as read_results does, and where it was changed; a version before seals kept
    nothing to compare with.
    """
    path, by = folder / name, "its sweep or map"
    seal = RunFolder(folder).seals().get(name)
    try:
        whole = seal is None or sha256_of(path) == seal
    except OSError as error:
        raise FolderError(
            f"{path}: cannot be read ({error.strerror}); make it again with {by}"
        ) from None
    if not whole:
        raise DamagedError(
            f"{path}: cannot be read (changed since it was written, or damaged); make it again "
            f"with {by}"
        )
    return read_results(path, by)


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
