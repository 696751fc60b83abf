"""How densely a shape is known to pack at random: the shipped table, interpolated in the ratio.

The table is that of `damper3d reproduce packing` (docs/damper-packing.md): "spheroid" goes by
aspect ratio from oblate to prolate, "toroid" by hole ratio.
"""

import csv
from functools import cache
from typing import NamedTuple

import numpy as np

from contact.datafile import data_root

# Fractions of spheres packed at random (thesis, below eq. 6.13), of which the table is a check.
LOOSE_PACKING, CLOSE_PACKING = 0.55, 0.64
_FAMILIES = {"prolate": "spheroid", "oblate": "spheroid", "toroid": "toroid"}


class Fraction(NamedTuple):
    """A packing fraction."""

    value: float  # volume of the particles over that of the space [-]
    uncertainty: float  # one standard deviation [-]
    source: str  # in words


def close_packing(shape: str) -> Fraction | None:
    """Random close packing of a shape such as "prolate:1.5", without walls; None: not known.

    Spheres are the thesis's 0.64; their uncertainty is how far the table is off that.
    """
    return _known(shape, "close", CLOSE_PACKING)


def loose_packing(shape: str) -> Fraction | None:
    """Random loose packing of a shape, poured into the thesis's enclosure; None: not known.

    Spheres are the thesis's 0.55, likewise.
    """
    return _known(shape, "loose", LOOSE_PACKING)


def _known(shape: str, which: str, spheres: float) -> Fraction | None:
    kind, _, values = shape.partition(":")
    if kind != "sphere" and kind not in _FAMILIES:
        return None
    if kind == "sphere" or float(values) == (0.0 if kind == "toroid" else 1.0):
        found = _at("spheroid", 1.0, which)
        assert found is not None  # the table begins below the sphere and ends above
        off = max(abs(spheres - found[0]), found[1])
        return Fraction(spheres, off, "spheres (thesis, below eq. 6.13)")
    found = _at(_FAMILIES[kind], float(values), which)
    return found and Fraction(*found, f"shipped table, {_FAMILIES[kind]} of ratio {values}")


def _at(family: str, ratio: float, which: str) -> tuple[float, float] | None:
    """Value and uncertainty at a ratio, between those of the table; None beyond its ends."""
    rows = [row for row in _table() if row["family"] == family]
    ratios = [float(row["ratio"]) for row in rows]
    if not ratios[0] <= ratio <= ratios[-1]:
        return None
    value, sigma = (
        float(np.interp(ratio, ratios, [float(row[key]) for row in rows]))
        for key in (which, f"{which}_uncertainty")
    )
    return value, sigma


@cache
def _table() -> list[dict[str, str]]:
    text = (data_root() / "packings" / "random.csv").read_text(encoding="utf-8")
    return list(csv.DictReader(line for line in text.splitlines() if not line.startswith("#")))
