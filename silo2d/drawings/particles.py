"""Outlines of particles, drawn or photographed, as spheropolygons with their error; shape files.

A spheropolygon of spheroradius r is a convex core swept by a disc. The core is the outline's convex
hull, shrunk by r, with the fewest corners by which the rounded shape stays within a tolerance.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from granulab.contact.files.casefile import toml_value
from granulab.errors import InputError
from silo2d.case.shape import Points, shape_from_outline

if TYPE_CHECKING:
    from shapely import Polygon

SPHERORADIUS = 0.1  # over the diameter of a disc of the smallest particle's area
TOLERANCE = 0.02  # over that of a disc of the mean particle's area
_CORNERS = 24  # beyond which none is worth its cost: a disc is then within 1 % of its radius
_EVEN = 0.02  # depth of what is no hollow, over the diameter
_DENSE = 100  # points along a diameter, between which distances are measured


@dataclass(frozen=True, eq=False)
class Fitted:
    """An outline as a spheropolygon; SI.

    corners    outer corners (n, 2), counter-clockwise, as a shape file takes them
    rounded    the rounded shape (m, 2), for drawing
    error      largest distance between the rounded shape and the outline
    concavity  how far the outline is inside its convex hull at most, which is a part of the error;
               0 where that is less than a fiftieth of its size
    area       of the rounded shape over that of the outline [-]
    """

    name: str
    corners: Points
    rounded: Points
    error: float
    concavity: float
    area: float

    def in_words(self) -> str:
        """One line: corners, error, area."""
        hollow = f" (hollow by {1e3 * self.concavity:.3g} mm)" if self.concavity else ""
        return (
            f"{self.name}: {len(self.corners)} corners, within {1e3 * self.error:.3g} mm of its "
            f"outline{hollow}, area {100 * (self.area - 1):+.2f} %"
        )


def spheropolygons(
    outlines: Sequence[Points],
    where: str,
    spheroradius: float | None = None,
    tolerance: float | None = None,
) -> tuple[list[Fitted], float]:
    """Spheropolygons of closed outlines (n, 2) [m], and their spheroradius [m].

    Left out, the spheroradius is a tenth of the smallest particle, the tolerance a fiftieth of the
    mean one. Raises InputError where a spheroradius is too large for a particle.
    """
    from shapely import Polygon

    drawn = [Polygon(outline) for outline in outlines]
    for k, one in enumerate(drawn, start=1):
        if not one.is_valid or one.area <= 0:
            raise InputError(f"{where}: outline {k} crosses itself; draw it as a simple curve")
    diameters = [_diameter(one) for one in drawn]
    if spheroradius is None:
        spheroradius = float(f"{SPHERORADIUS * min(diameters):.2g}")
    within = TOLERANCE * float(np.mean(diameters)) if tolerance is None else tolerance
    found = [_fitted(str(k), one, spheroradius, within, where) for k, one in enumerate(drawn, 1)]
    return found, spheroradius


def _diameter(outline: "Polygon") -> float:
    return 2 * math.sqrt(outline.area / math.pi)


def _fitted(name: str, drawn: "Polygon", r: float, within: float, where: str) -> Fitted:
    """The spheropolygon with the fewest corners within a distance, or the nearest there is."""
    core, best = drawn.convex_hull.buffer(-r, join_style="mitre"), None
    for corners in _simpler(core):
        one = _made(name, corners, drawn, r)
        if one is not None and (best is None or one.error < best.error):
            best = one
        if best is not None and best.error <= within:
            return best
    if best is None:
        raise InputError(
            f"{where}: spheroradius = {1e3 * r:g} mm: too large for particle {name}, "
            f"{1e3 * _diameter(drawn):.3g} mm; give a smaller one"
        )
    return best


def _simpler(core: "Polygon") -> list[Points]:
    """A convex polygon with 3 corners and more: each time without the one that sticks out least."""
    if core.is_empty or core.geom_type != "Polygon":
        return []
    corners = np.array(core.exterior.coords)[:-1]
    found: list[Points] = []
    while len(corners) >= 3:
        if len(corners) <= _CORNERS or not found:
            found.append(corners)
        before, after = np.roll(corners, 1, axis=0), np.roll(corners, -1, axis=0)
        (ax, ay), (bx, by) = (corners - before).T, (after - before).T
        corners = np.delete(
            corners, (np.abs(ax * by - ay * bx) / np.hypot(bx, by)).argmin(), axis=0
        )
    return found[::-1]


def _made(name: str, corners: Points, drawn: "Polygon", r: float) -> Fitted | None:
    """A spheropolygon on some corners of a core; None where that has no room for the radius.

    Round corners and those left out took area with them: the shape gets that of the outline. What
    rounding takes does not grow with the polygon, whose angles stay.
    """
    from shapely import Polygon, distance, hausdorff_distance, points, segmentize
    from shapely.geometry.polygon import orient

    outer = orient(Polygon(corners).buffer(r, join_style="mitre", mitre_limit=1e3))
    corners = np.array(outer.exterior.coords)[:-1]
    try:
        taken = outer.area - shape_from_outline(name, corners, r, name).area
        centre = np.array(outer.centroid.coords[0])
        corners = centre + math.sqrt((drawn.area + taken) / outer.area) * (corners - centre)
        shape = shape_from_outline(name, corners, r, name)
    except InputError:
        return None
    rounded = Polygon(corners).buffer(-r, join_style="mitre").buffer(r, quad_segs=16).exterior
    step, outline = _diameter(drawn) / _DENSE, drawn.exterior
    depth = distance(drawn.convex_hull.exterior, points(outline.coords)).max()
    return Fitted(
        name,
        corners,
        np.array(rounded.coords)[:-1],
        hausdorff_distance(segmentize(rounded, step), segmentize(outline, step)),
        float(depth) if depth > _EVEN * _diameter(drawn) else 0.0,
        shape.area / drawn.area,
    )


def shape_file(shapes: Sequence[Fitted], spheroradius: float, origin: str) -> str:
    """A shape file of some spheropolygons, with their errors as comments; origin: its head."""
    lines = [
        *(f"# {line}" for line in origin.splitlines()),
        "",
        "schema = 1",
        f'spheroradius = "{1e3 * spheroradius:.6g} mm"',
        'unit = "mm"',
    ]
    for shape in shapes:
        corners = np.round(1e3 * (shape.corners - shape.corners.mean(axis=0)), 4).tolist()
        lines += [
            "",
            f"# {shape.in_words()}",
            "[[shape]]",
            f"name = {toml_value(shape.name)}",
            f"outline = {toml_value(corners)}",
        ]
    return "\n".join(lines) + "\n"
