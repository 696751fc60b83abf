"""What can be observed of a finished run: a table of names, each a module of this package.

A measure is a module with two functions of a run folder:

    measure(folder) -> dict            numbers and series in SI, ready for JSON
    draw(folder) -> Figure             the same as a matplotlib figure

Measures read run folders and never the live world.
"""

import importlib
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, cast

from granulab.contact.files.units import nearest
from granulab.errors import InputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# name as in `silo2d observe RUN WHAT`: module of this package, what it measures
MEASURES: dict[str, tuple[str, str]] = {
    "arch": ("arch", "the arch that a clogged run stands on: particles, span, rise, load"),
    "curve": ("curve", "discharge curve and rate, and the part where the flow is steady"),
    "fields": ("fields", "packing fraction and velocity, coarse-grained over the flow"),
    "janssen": ("janssen", "wall pressure and vertical stress against Janssen's law"),
    "massflow": ("massflow", "mass flow index: velocity at the walls over that at the centre"),
    "network": ("network", "contact network: coordination, sliding, force distribution"),
    "profile": ("profile", "lines of the painted layers every 0.25 s, V depth and V width"),
    "residence": ("residence", "when particles leave, by starting level and position"),
    "stickslip": ("stickslip", "particles that stick to the walls, slip along them, and how long"),
    "stress": ("stress", "stress field before the opening and during the flow"),
}


class Measure(Protocol):
    """What a module of this package offers."""

    def measure(self, folder: Path) -> dict[str, Any]:
        """Numbers and series in SI."""

    def draw(self, folder: Path) -> "Figure":
        """The measure as a picture."""


def find(name: str) -> Measure:
    """The measure of a name; InputError with the names there are."""
    if name not in MEASURES:
        raise InputError(f"observe {name!r}: {nearest(name, list(MEASURES))}")
    return cast(Measure, importlib.import_module(f"silo2d.measures.{MEASURES[name][0]}"))
