"""The inside of a silo from a drawing, as the points of a case's outline."""

from pathlib import Path
from typing import Any

import numpy as np

from granulab.contact.files.casefile import changed
from granulab.errors import InputError
from silo2d.drawings.curves import Curve, Points, joined, read_drawing, signed_area

_LEVEL = 1e-4  # distance from the lowest or highest point that counts as level, over the extent
_DIGITS = 4  # of millimetres


def _drawn(
    path: str | Path, unit: str | None, layer: str | None
) -> tuple[list[list[float]], dict[str, str]]:
    """Corners [mm] of the silo in an SVG or DXF file, counter-clockwise, as a case takes them.

    One closed curve; or one open one, which a straight line closes (an open top); or two, its
    sides, whose lower ends are the outlet's: then also the keys of that. Lines and arcs that meet
    are joined, curves are polylines within 5e-4 of their extent, and points that are level but for
    a ten thousandth of it are made level. unit, layer: see read_drawing. Raises InputError for
    anything else.
    """
    drawing = read_drawing(path, unit, layer)
    assert drawing.unit is not None
    corners, sides = _inside(joined(drawing, str(path)), str(path))
    corners = 1e3 * drawing.unit * corners
    if signed_area(corners) < 0:
        corners = corners[::-1]
    y = corners[:, 1]
    near = _LEVEL * np.ptp(corners, axis=0).max()
    for level in (y.min(), y.max()):
        y[np.abs(y - level) <= near] = level
    outlet = {}
    if sides is not None:
        ends = 1e3 * drawing.unit * sides
        if np.abs(ends[:, 1] - y.min()).max() <= near:
            width, middle = float(np.ptp(ends[:, 0])), float(ends[:, 0].mean())
            outlet = {"silo.outlet": f"{round(width, _DIGITS):g} mm",
                      "silo.outlet_centre": f"{round(middle, _DIGITS):g} mm"}  # fmt: skip
    return np.round(corners, _DIGITS).tolist(), outlet


def outline_changes(
    path: str | Path, unit: str | None = None, layer: str | None = None
) -> dict[str, Any]:
    """Keys of a case that put the silo of a drawing in place of the one it has; "section.key"."""
    other = dict.fromkeys(("silo.preset", "silo.angle", "silo.width", "silo.height"))
    corners, outlet = _drawn(path, unit, layer)
    return {**other, "silo.outline": corners, "silo.outline_unit": "mm", **outlet}


def drawn_case(path: str | Path, unit: str | None = None, layer: str | None = None) -> str:
    """A case file with a comment on every key, and the silo of a drawing.

    It is filled to the usual level, or where it is lower to nine tenths of its height; its outlet
    is the whole lowest edge, unless it lies between two sides. InputError for one that is no case.
    """
    from silo2d.case.case import SiloCase
    from silo2d.case.settings import Fill, Settings, commented_case

    values = outline_changes(path, unit, layer)
    y = [corner[1] for corner in values["silo.outline"]]
    height = max(y) - min(y)
    level = {} if 1e3 * Fill().level <= height else {"fill.level": f"{0.9 * height:.4g} mm"}
    keys = {"silo.outlet": None, **values, **level}
    document = changed({"name": "drawn"}, keys, Settings)
    SiloCase.resolve(document, str(path), Path())  # refused before a file is written
    return commented_case(Path(path).stem, keys)


def _inside(curves: list[Curve], where: str) -> tuple[Points, Points | None]:
    """The polygon (n, 2) of the inside, from the one closed curve or the open sides.

    Of two sides also their lower ends (2, 2).
    """
    closed = [one.points for one in curves if one.closed]
    sides = [one.points for one in curves if not one.closed]
    if len(closed) == 1 and not sides:
        return closed[0].copy(), None
    if len(sides) == 1 and not closed:
        return sides[0].copy(), None
    if len(sides) == 2 and not closed:
        down, up = (side if side[0, 1] > side[-1, 1] else side[::-1] for side in sides)
        return np.concatenate([down, up[::-1]]), np.array([down[-1], up[-1]])
    parts = [f"{len(closed)} closed"] * bool(closed) + [f"{len(sides)} open"] * bool(sides)
    raise InputError(
        f"{where}: {' and '.join(parts)} curves; a silo is one closed curve, or one or two open "
        "ones (its sides): leave the others out, or name its layer"
    )
