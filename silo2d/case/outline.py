"""The silo: a polygon open at the top, with an outlet in its floor; the sixteen presets."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granulab.contact.files.units import nearest
from granulab.errors import InputError
from silo2d.case.shape import COINCIDENT, Points, merge_collinear, simple_polygon

if TYPE_CHECKING:
    from shapely import Polygon

_ANGLES = {"A": 60, "B": 45, "C": 30, "D": 0}  # hopper, from the horizontal [deg]
_OUTLETS = {"1": 0.040, "2": 0.060, "3": 0.100, "4": 0.150}  # [m]

# The paper's silos, 300 mm wide and 500 mm high: hopper angle by letter, outlet by number.
PRESETS = [letter + number for letter in _ANGLES for number in _OUTLETS]


class Walls(NamedTuple):
    """Straight pieces of wall, the inside on their left; the door across the outlet is last."""

    segments: NDArray[np.float64]  # (w, 2, 2) end points [m]
    # (w,) "left wall", "right hopper", "floor left", "wall 3", ..., "insert 1 side 1", ...,
    # "door 2" of a further outlet, "door"
    names: list[str]
    # (w,) how many end points, first point first, are corners that edges of particles can rest
    # on. Each distinct point of the walls counts once; the door has none of its own.
    corners: NDArray[np.int64]

    @property
    def doors(self) -> list[int]:
        """Indices of the doors, the last walls."""
        return [k for k, name in enumerate(self.names) if name.startswith("door")]


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """A silo's inside.

    polygon          corners (n, 2) [m], counter-clockwise, simple, not always convex; the
                     lowest edge is horizontal, at y = 0, and holds the outlet; the highest
                     edge is horizontal too and is the open top
    outlet           its width [m]
    outlet_centre    x of its middle [m]
    inserts          corners (n, 2) [m] of bodies in it, counter-clockwise
    outlets          ends (2, 2) [m] of further outlets in its walls
    floor            y of the lowest edge where it was drawn [m]: inserts and outlets are drawn so
    """

    name: str
    polygon: Points
    outlet: float
    outlet_centre: float
    inserts: tuple[Points, ...] = ()
    outlets: tuple[Points, ...] = ()
    floor: float = 0.0

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

    @property
    def inside(self) -> "Polygon":
        """Space that particles may fill: the polygon without the inserts."""
        from shapely import Polygon, union_all

        inside = Polygon(self.polygon)
        return (
            inside - union_all([Polygon(one) for one in self.inserts]) if self.inserts else inside
        )

    @property
    def blocking_lines(self) -> list[tuple[float, float, float]]:
        """Vertical lines x, from and to a height [m], of which what blocks an outlet crosses one.

        They are the middle of each outlet in the floor up to the inserts over it and, next to such
        an insert, the middle of the passage where it is widest, from its foot on: a bridge between
        insert and wall stands there, and a heap on the insert or on the floor does not.
        """
        level = [ends for ends in self.outlets if (ends[:, 1] == 0.0).all()]
        lines = []
        for x in (self.outlet_centre, *(float(ends[:, 0].mean()) for ends in level)):
            over = [one for one in self.inserts if one[:, 0].min() < x < one[:, 0].max()]
            feet = [float(one[:, 1].min()) for one in over]
            lines.append((x, -math.inf, min(feet, default=math.inf)))
            lines += [
                (middle, foot, math.inf)
                for one, foot in zip(over, feet, strict=True)
                for middle in self._passages(one)
            ]
        return lines

    def _passages(self, insert: Points) -> Iterator[float]:
        """Middle [m] of the space to the left and to the right of an insert, at its ends."""
        from shapely import LineString

        for x, y in (insert[insert[:, 0].argmin()], insert[insert[:, 0].argmax()]):
            way = -1.0 if x < insert[:, 0].mean() else 1.0
            free = self.inside.intersection(LineString([(x, y), (x + way * self.width, y)]))
            ends = [one.bounds for one in getattr(free, "geoms", [free]) if not one.is_empty]
            near = min(ends, key=lambda one: min(abs(one[0] - x), abs(one[2] - x)), default=None)
            if near is not None:
                yield (near[0] + near[2]) / 2

    def area_below(self, level: float) -> float:
        """Area [m2] of the inside under y = level [m]."""
        return self._area_below(level, self.polygon[:, 0].min(), self.polygon[:, 0].max())

    def area_above_outlet(self, level: float) -> float:
        """Area [m2] of the inside straight above the outlet, under y = level [m]."""
        (left, _), (right, _) = self.lips
        return self._area_below(level, left, right)

    def _area_below(self, level: float, left: float, right: float) -> float:
        from shapely import box

        return float(self.inside.intersection(box(left, 0, right, max(level, 0))).area)

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
        walls = Walls(np.array([*segments, door]), [*names, "door"], corners)
        for ends in self.outlets:
            walls = _opened(walls, ends, nothing)
        return _with_inserts(walls, self.inserts)


def on_wall(walls: Walls, ends: Points, nothing: float) -> int | None:
    """Index of the wall that holds both ends (2, 2) of an outlet between its own; None: of none."""
    for k, (start, end) in enumerate(walls.segments):
        if k in walls.doors:
            continue
        length = math.hypot(*(end - start))
        tangent = (end - start) / length
        along = (ends - start) @ tangent
        aside = (ends - start) @ np.array([-tangent[1], tangent[0]])
        if (
            np.abs(aside).max() <= nothing
            and nothing < along.min() < along.max() < length - nothing
        ):
            return k
    return None


def _opened(walls: Walls, ends: Points, nothing: float) -> Walls:
    """Walls with a door (2, 2) in one of them, before the others."""
    k = on_wall(walls, ends, nothing)
    assert k is not None  # with_outlets has refused it
    start, end = walls.segments[k]
    first, last = sorted(ends, key=lambda point: math.hypot(*(point - start)))
    at = len(walls.names)  # before the last door, once the wall is two
    segments = np.insert(walls.segments, k, np.array([start, first]), axis=0)
    segments[k + 1] = last, end
    corners = np.insert(walls.corners, k, 2)  # the end of the piece is a corner too
    name = walls.names[k]
    names = [*walls.names[:k], f"{name} a", f"{name} b", *walls.names[k + 1 :]]
    return Walls(
        np.insert(segments, at, np.array([first, last]), axis=0),
        [*names[:at], f"door {len(walls.doors) + 1}", *names[at:]],
        np.insert(corners, at, 0),
    )


def _with_inserts(walls: Walls, inserts: tuple[Points, ...]) -> Walls:
    """Walls with the sides of inserts before the doors; what is outside of an insert is inside."""
    if not inserts:
        return walls
    at = walls.doors[0]
    sides = [np.stack([np.roll(one, -1, axis=0), one], axis=1)[::-1] for one in inserts]
    names = [f"insert {k} side {n + 1}" for k, one in enumerate(sides, 1) for n in range(len(one))]
    return Walls(
        np.concatenate([walls.segments[:at], *sides, walls.segments[at:]]),
        [*walls.names[:at], *names, *walls.names[at:]],
        np.concatenate([walls.corners[:at], np.ones(len(names), np.int64), walls.corners[at:]]),
    )


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
    floor = float(corners[bottom, 1])
    corners[:, 1] -= floor
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
    return Outline(name, corners, outlet, outlet_centre, floor=floor)


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
