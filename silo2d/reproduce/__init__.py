"""The paper's tables beside ours: a table of names, each a module of this package.

A table is a module with

    SEEDS                              how many seeds it takes unless told otherwise
    run(*, out, seeds, workers, quiet) -> list[dict]    a row a run, as silo2d.sweep gives them
    report(rows) -> str                our numbers beside the published ones, and a word on each
    draw(rows) -> Figure               the same as a matplotlib figure

Those that can also compute on a cluster take the `engine` and `scheduler` of silo2d.sweep too.
"""

import importlib
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

from contact.quantity import InputError, nearest

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Row = dict[str, Any]

# name as in `silo2d reproduce TABLE`: module of this package, what it shows
TABLES: dict[str, tuple[str, str]] = {
    "beverloo": ("beverloo", "flow rate against the outlet, here and in a wide silo"),
    "clogging": ("clogging", "how often 40, 60 and 100 mm clog (paper's Table 5)"),
    "discharge": ("discharge", "discharge times of the sixteen silos (paper's Tables 5 and 6)"),
    "disorder": ("disorder", "A4 and A3 with parameters drawn from pair to pair"),
    "displacement": ("displacement", "profiles of the painted layers in A4 and D4"),
    "filling": ("filling", "A3 and B3 poured in three ways, opened in two"),
    "sensitivity": ("sensitivity", "A4's time against each parameter (paper's Tables 7 to 11)"),
}


class PublishedTable(Protocol):
    """What a module of this package offers."""

    SEEDS: int

    def run(
        self, *, out: Path, seeds: Sequence[int], workers: int | None, quiet: bool, **engine: Any
    ) -> list[Row]:
        """All runs of the table; those that are there are not done again."""

    def report(self, rows: list[Row]) -> str:
        """What a person reads."""

    def draw(self, rows: list[Row]) -> "Figure":
        """The table as a picture."""


def find(name: str) -> PublishedTable:
    """The table of a name; InputError with the names there are."""
    if name not in TABLES:
        raise InputError(f"reproduce {name!r}: no such table; {nearest(name, list(TABLES))}")
    return cast(PublishedTable, importlib.import_module(f"silo2d.reproduce.{TABLES[name][0]}"))
