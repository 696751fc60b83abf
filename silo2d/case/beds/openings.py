"""Inserts in a silo and further outlets in its walls: limits, and the ways between them."""

import math
from dataclasses import replace

import numpy as np

from granulab.errors import InputError
from silo2d.case.outline import Outline, on_wall
from silo2d.case.shape import COINCIDENT, Points, simple_polygon, vertex_list


def with_inserts(
    outline: Outline, given: list[list[list[float]]], unit: float, field: str
) -> Outline:
    """A silo with inserts, corners in a unit [m] as its outline is drawn, counter-clockwise; held.

    Raises InputError, "FIELD insert K ...", for one that is no polygon, or not inside the silo and
    apart from its walls and from the other inserts.
    """
    from shapely import LinearRing, Polygon

    apart = COINCIDENT * max(outline.width, outline.height)
    silo = Polygon(outline.polygon)
    found: list[Points] = []
    for k, points in enumerate(given, start=1):
        where = f"{field}: insert {k}"
        corners = simple_polygon(vertex_list(points, where) * unit, where) - [0.0, outline.floor]
        corners.setflags(write=False)
        insert = Polygon(corners)
        if not silo.contains(insert):
            raise InputError(f"{where}: not inside the silo; move it, or draw it into the outline")
        if LinearRing(outline.polygon).distance(insert) <= apart:
            raise InputError(f"{where}: touches a wall; keep it apart, or draw it into the outline")
        for other, corners_of in enumerate(found, start=1):
            if Polygon(corners_of).distance(insert) <= apart:
                raise InputError(
                    f"{where}: touches insert {other}; make one of both, or keep apart"
                )
        found.append(corners)
    return replace(outline, inserts=tuple(found))


def with_outlets(
    outline: Outline, given: list[list[list[float]]], unit: float, field: str
) -> Outline:
    """A silo with further outlets, ends in a unit [m] as its outline is drawn, each on one wall.

    Raises InputError, "FIELD outlet K ...", for one that is not on a single wall between its ends.
    """
    nothing = COINCIDENT * max(outline.width, outline.height)
    for k, points in enumerate(given, start=2):
        where = f"{field}: outlet {k}"
        ends = vertex_list(points, where) * unit - [0.0, outline.floor]
        if ends.shape != (2, 2) or math.hypot(*(ends[1] - ends[0])) <= nothing:
            raise InputError(f"{where}: expected both its ends, such as [[-150, 100], [-150, 160]]")
        bare = replace(outline, inserts=())
        if on_wall(bare.walls(), ends, nothing) is None:
            raise InputError(
                f"{where}: not on one wall, away from its ends and from other outlets; walls go "
                "from corner to corner of the outline"
            )
        ends.setflags(write=False)
        outline = replace(outline, outlets=(*outline.outlets, ends))
    return outline


def check_ways(outline: Outline, narrowest: float, where: str) -> None:
    """Raise InputError where no particle could pass to an outlet, or through it.

    narrowest: width of the narrowest particle [m].
    """
    from shapely import Point, Polygon, union_all

    for k, ends in enumerate(outline.outlets, start=2):
        width = math.hypot(*(ends[1] - ends[0]))
        if width < narrowest:
            raise InputError(
                f"{where}: [silo] outlets: outlet {k} is {1e3 * width:.3g} mm wide: smaller than "
                f"the narrowest particle, {1e3 * narrowest:.3g} mm; nothing would come out"
            )
    if not (outline.inserts or outline.outlets):
        return
    openings = [np.array(outline.lips), *outline.outlets]
    spouts = [_spout(outline, ends, narrowest) for ends in openings]
    high = replace(outline.raised(2 * narrowest), inserts=())
    solid = [Polygon(one) for one in outline.inserts]
    space = union_all([Polygon(high.polygon), *(spout for spout, _ in spouts)]) - union_all(solid)
    free = space.buffer(-0.499 * narrowest)
    parts = list(getattr(free, "geoms", [free]))
    top = outline.height + narrowest
    from_top = [part for part in parts if not part.is_empty and part.bounds[3] >= top]
    for k, (_, end) in enumerate(spouts, start=1):
        if not any(part.distance(Point(end)) < 0.5 * narrowest for part in from_top):
            which = f"outlet {k}" if k > 1 else "the outlet"
            raise InputError(
                f"{where}: [silo] inserts: no way from the top to {which} is as wide as the "
                f"narrowest particle, {1e3 * narrowest:.3g} mm; move or shrink an insert"
            )


def _spout(outline: Outline, ends: Points, length: float) -> tuple["object", np.ndarray]:
    """A channel out of an outlet, and the middle of its end [m]."""
    from shapely import Point, Polygon

    along = ends[1] - ends[0]
    out = 1.5 * length * np.array([along[1], -along[0]]) / math.hypot(*along)
    middle = ends.mean(axis=0)
    if Polygon(outline.polygon).contains(Point(middle + 1e-3 * out)):
        out = -out
    back = -1e-3 * out  # overlaps with the silo, so that both are one
    corners = [ends[0] + back, ends[1] + back, ends[1] + out, ends[0] + out]
    return Polygon(corners), middle + 0.6 * out
