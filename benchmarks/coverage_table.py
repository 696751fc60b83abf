"""Rows of a coverage benchmark in its CSV file, and the table of all of them next to it."""

import csv
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TypeVar

R = TypeVar("R")


def read(path: Path, fields: Iterable[str], row: Callable[..., R]) -> list[R]:
    """The rows of earlier runs, each made of its cells; a file with the heads alone if none is."""
    if not path.exists():
        path.write_text(",".join(fields) + "\n", encoding="utf-8", newline="\n")
    with path.open(newline="", encoding="utf-8") as file:
        return [row(*cells) for cells in list(csv.reader(file))[1:]]


def report(path: Path, lines: Iterable[str]) -> None:
    """Print a table, and keep it as the text file next to the CSV file."""
    text = "\n".join(lines) + "\n"
    path.with_suffix(".txt").write_text(text, encoding="utf-8", newline="\n")
    print(text, end="")
