"""The silo: a polygon open at the top, with an outlet in its floor; the sixteen presets."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granulab.contact.files.units import nearest
from granulab.errors import InputError
from silo2d.case.shape import COINCIDENT, Points, merge_collinear, simple_polygon

_ANGLES = {"A": 60, "B": 45, "C": 30, "D": 0}  # hopper, from the horizontal [deg]
_OUTLETS = {"1": 0.040, "2": 0.060, "3": 0.100, "4": 0.150}  # [m]

# The paper's silos, 300 mm wide and 500 mm high: hopper angle by letter, outlet by number.
PRESETS = [letter + number for letter in _ANGLES for number in _OUTLETS]


class Walls(NamedTuple):
    """Straight pieces of wall, the inside on their left; the door across the outlet is last."""

    segments: NDArray[np.float64]  # (w, 2, 2) end points [m]
    names: list[str]  # (w,) "left wall", "right hopper", "floor left", "wall 3", ..., "door"
    # (w,) how many end points, first point first, are corners that edges of particles can rest
    # on. Each distinct point of the walls counts once; the door has none of its own.
    corners: NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A silo's inside.

    polygon          corners (n, 2) [m], counter-clockwise, simple, not always convex; the
                     lowest edge is horizontal, at y = 0, and holds the outlet; the highest
                     edge is horizontal too and is the open top
    outlet           its width [m]
    outlet_centre    x of its middle [m]
    """

    name: str
    polygon: Points
    outlet: float
    outlet_centre: float

    @property
    def lips(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Left and right end of the outlet (x, y) [m]."""
        half = self.outlet / 2
        return (self.outlet_centre - half, 0.0), (self.outlet_centre + half, 0.0)

    @property
    def width(self) -> float:
        """Width from the leftmost to the rightmost point [m]."""
        return float(np.ptp(self.polygon[:, 0]))

    @property
    def height(self) -> float:
        """Height from the outlet to the open top [m]."""
        return float(self.polygon[:, 1].max())

    def area_below(self, level: float) -> float:
        """Area [m2] of the inside under y = level [m]."""
        from shapely import Polygon, box

        left, right = self.polygon[:, 0].min(), self.polygon[:, 0].max()
        return float(Polygon(self.polygon).intersection(box(left, 0, right, max(level, 0))).area)

    def raised(self, by: float) -> "Outline":
        """The same silo with vertical walls of height `by` [m] put on its open top."""
        right = _level_edge(self.polygon, self.height)
        corners = np.roll(self.polygon, -right, axis=0)
        top = corners[:2] + np.array([0.0, by])
        polygon = np.concatenate([corners[:1], top, corners[1:]])
        return replace(self, polygon=merge_collinear(polygon))

    def walls(self) -> Walls:
        """The walls: from the right lip up to the top, then from the top down to the left lip."""
        left_lip, right_lip = self.lips
        floor = _level_edge(self.polygon, 0.0)
        around = np.roll(self.polygon, -floor - 1, axis=0)  # from the floor's right end
        top = _level_edge(around, self.height)
        nothing = COINCIDENT * max(self.width, self.height)
        right, right_names = _side(around[: top + 1], right_lip, nothing, "right")
        # The left side is named from the bottom up, as the right one, and then reversed.
        left, left_names = _side(around[:top:-1], left_lip, nothing, "left")
        segments = [*right, *(piece[::-1] for piece in reversed(left))]
        names = [*right_names, *reversed(left_names)]
        names = [name or f"wall {k}" for k, name in enumerate(names, start=1)]
        corners = np.ones(len(segments) + 1, dtype=np.int64)
        corners[[len(right) - 1, -2]] = 2  # both sides are chains: the end of each counts too
        corners[-1] = 0
        door = np.array([left_lip, right_lip])
        return Walls(np.array([*segments, door]), [*names, "door"], corners)


def _level_edge(corners: Points, level: float) -> int:
    """Index of the corner at which the edge at y = level starts."""
    on_level = corners[:, 1] == level  # exact: outline_from_polygon has put it there
    return int(np.flatnonzero(on_level & np.roll(on_level, -1))[0])


def _side(
    corners: Points, lip: tuple[float, float], nothing: float, side: str
) -> tuple[list[Points], list[str]]:
    """Wall pieces of one side from the lip upwards and their names, "" where none is common."""
    pieces = list(np.stack([corners[:-1], corners[1:]], axis=1))
    run, rise = (corners[1:] - corners[:-1]).T
    outwards = 1 if side == "right" else -1
    steep = np.abs(run) <= nothing
    leans = (run * outwards > nothing) & (rise > 0)
    names = [""] * len(pieces)
    if len(pieces) <= 2 and steep[1:].all() and (steep[0] or leans[0]):
        names = [f"{side} wall" if upright else f"{side} hopper" for upright in steep]
    if abs(corners[0, 0] - lip[0]) > nothing:
        pieces.insert(0, np.array([lip, corners[0]]))
        names.insert(0, f"floor {side}")
    else:
        pieces[0][0] = lip  # not a rounding error apart, or a vertex would stand twice
    return pieces, names


def outline_from_polygon(
    points: ArrayLike,
    outlet: float | None = None,
    outlet_centre: float | None = None,
    name: str = "outline",
    field: str = "outline",
) -> Outline:
    """A silo from the corners (n, 2) [m] of its inside, counter-clockwise, moved to y = 0.

    The outlet [m] is the whole lowest edge unless given, and in its middle unless its centre
    (x [m]) is given. Raises InputError, "FIELD: ...", for a polygon that crosses itself or is
    clockwise, a lowest or highest edge that is not horizontal, or an outlet outside the
    lowest edge.
    """
    corners = simple_polygon(points, field)
    extent = np.ptp(corners, axis=0).max()
    bottom = _levelled(corners, corners[:, 1].min(), extent, f"{field}: the lowest edge")
    _levelled(corners, corners[:, 1].max(), extent, f"{field}: the highest edge (the open top)")
    corners[:, 1] -= corners[bottom, 1]
    left, right = corners[bottom, 0], corners[(bottom + 1) % len(corners), 0]
    if outlet is None:
        outlet = float(right - left)
    if outlet_centre is None:
        outlet_centre = float(left + right) / 2
    _check_positive(outlet, f"{field}: outlet")
    if outlet > right - left + COINCIDENT * extent:
        raise InputError(
            f"{field}: outlet = {_mm(outlet)}: wider than the lowest edge; "
            f"at most {_mm(right - left)}"
        )
    range_ = (right - left - outlet) / 2  # of the centre, from the middle of the lowest edge
    if not abs(outlet_centre - (left + right) / 2) <= range_ + COINCIDENT * extent:
        raise InputError(
            f"{field}: outlet_centre = {_mm(outlet_centre)}: the outlet would leave the lowest "
            f"edge; from {_mm(left + outlet / 2)} to {_mm(right - outlet / 2)} would do"
        )
    return Outline(name, corners, outlet, outlet_centre)


def _levelled(corners: Points, level: float, extent: float, field: str) -> int:
    """Put the one edge at a level exactly there; the index of the corner where it starts."""
    near = np.abs(corners[:, 1] - level) <= COINCIDENT * extent
    starts = np.flatnonzero(near & np.roll(near, -1))
    if starts.size == 0:
        raise InputError(f"{field} is not horizontal; give both its ends the same y")
    if np.count_nonzero(near) > 2:
        raise InputError(f"{field} is not the only one at its level; give one such edge")
    corners[near, 1] = level
    return int(starts[0])


def hopper(
    angle: float, outlet: float, width: float = 0.3, height: float = 0.5, name: str = "hopper"
) -> Outline:
    """A silo with vertical walls over a symmetric hopper, x = 0 in its middle.

    angle     of the hopper from the horizontal [rad], 0 for a flat floor, below pi/2
    outlet    [m]; width and height [m] are of the whole silo, the hopper included

    Raises InputError for an angle or size out of range, or a hopper higher than the silo.
    """
    for size, value in {"outlet": outlet, "width": width, "height": height}.items():
        _check_positive(value, f"{name}: {size}")
    if not 0 <= angle < math.pi / 2:
        raise InputError(
            f"{name}: angle = {math.degrees(angle):g} deg: must be at least 0 deg (a flat floor) "
            "and less than 90 deg"
        )
    if outlet > width:
        raise InputError(f"{name}: outlet = {_mm(outlet)}: wider than the silo, {_mm(width)}")
    run = (width - outlet) / 2
    rise = run * math.tan(angle)
    if math.isclose(rise, height):
        rise = height  # a hopper up to the top
    if rise > height:
        steepest = math.floor(10 * math.degrees(math.atan2(height, run))) / 10
        raise InputError(
            f"{name}: angle = {math.degrees(angle):g} deg: the hopper would be {_mm(rise)} high, "
            f"the silo is {_mm(height)}; at most {steepest:g} deg for this outlet"
        )
    right = [(outlet / 2, 0.0), (width / 2, rise), (width / 2, height)]
    right = list(dict.fromkeys(right))  # two of them coincide where there is no hopper, or no wall
    left = [(-x, y) for x, y in reversed(right)]
    return outline_from_polygon([*right, *left], outlet, 0.0, name, name)


def preset_sizes(name: str) -> tuple[float, float]:
    """Hopper angle [rad] and outlet [m] of a preset; InputError for an unknown name."""
    if name not in PRESETS:
        raise InputError(f"preset = {name!r}: unknown; {nearest(name, PRESETS)}")
    return math.radians(_ANGLES[name[0]]), _OUTLETS[name[1]]


def preset(name: str) -> Outline:
    """One of the paper's silos, "A1" ... "D4"; InputError for another name."""
    return hopper(*preset_sizes(name), name=name)


def _check_positive(length: float, field: str) -> None:
    if not 0 < length < math.inf:
        raise InputError(f"{field} = {_mm(length)}: must be positive, such as '100 mm'")


def _mm(length: float) -> str:
    return f"{1e3 * length:.6g} mm"
