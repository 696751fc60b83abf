"""Known random packings of shapes: the shipped table, interpolated in the ratio.

The table is that of `damper3d reproduce packing` (docs/damper/packing.md): "spheroid" goes by
aspect ratio from oblate to prolate, "toroid" by hole ratio.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from granulab.contact.files.datafile import shipped_rows

# Fractions of spheres packed at random (thesis, below eq. 6.13), of which the table is a check.
LOOSE_PACKING, CLOSE_PACKING = 0.55, 0.64
_THESIS = "spheres (thesis, below eq. 6.13)"
_FAMILIES = {"prolate": "spheroid", "oblate": "spheroid", "toroid": "toroid"}


class Fraction(NamedTuple):
    """A packing fraction."""

    value: float  # volume of the particles over that of the space [-]
    uncertainty: float | None  # one standard deviation [-]; None: not known
    source: str  # in words


def close_packing(shape: str) -> Fraction | None:
    """Random close packing of a shape such as "prolate:1.5", without walls; None: not known.

    Spheres are the thesis's 0.64; their uncertainty is how far the table is off that.
    """
    kind, _, values = shape.partition(":")
    if _is_sphere(kind, values):
        measured, sigma = _at("spheroid", 1.0)
        off = max(abs(CLOSE_PACKING - measured), sigma)
        return Fraction(CLOSE_PACKING, off, _THESIS)
    if kind not in _FAMILIES:
        return None
    family = _FAMILIES[kind]
    ratios = [float(row["ratio"]) for row in _rows(family)]
    if not ratios[0] <= float(values) <= ratios[-1]:
        return None
    return Fraction(*_at(family, float(values)), f"shipped table, {family} of ratio {values}")


def loose_packing(shape: str) -> Fraction | None:
    """Random loose packing of spheres, the thesis's 0.55; None of another shape: not known.

    It hangs on how gently they are laid down (Onoda and Liniger 1990, thesis [210]), so that no
    uncertainty is given.
    """
    kind, _, values = shape.partition(":")
    return Fraction(LOOSE_PACKING, None, _THESIS) if _is_sphere(kind, values) else None


def _is_sphere(kind: str, values: str) -> bool:
    if kind in _FAMILIES:
        return float(values) == (0.0 if kind == "toroid" else 1.0)
    return kind == "sphere"


def _at(family: str, ratio: float) -> tuple[float, float]:
    """Value and uncertainty at a ratio, on the line between two of the table."""
    rows = _rows(family)
    ratios = [float(row["ratio"]) for row in rows]
    columns = [[float(row[key]) for row in rows] for key in ("close", "close_uncertainty")]
    value, sigma = (float(np.interp(ratio, ratios, column)) for column in columns)
    return value, sigma


@cache
def _rows(family: str) -> list[dict[str, str]]:
    return [row for row in shipped_rows("packings", "random") if row["family"] == family]
