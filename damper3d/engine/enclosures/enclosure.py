"""Base of all enclosures: a closed void as flat and curved walls, in its own frame.

z is the axis and the origin the centre of the bottom. A flat wall is a row (n_x, n_y, n_z, offset)
with the unit normal n pointing inwards; a point r inside has n . r - offset > 0. Curved walls come
after the flat ones: their numbers stand in a named tuple, `surface`, by whose type the engine
chooses the function that knows their geometry (see damper3d.engine.enclosures).
"""

import math
from collections.abc import Callable
from dataclasses import MISSING, fields
from typing import Any, ClassVar, NamedTuple

import numpy as np

_GRID = 64  # points each way by which a volume is counted
SIDES = 48  # of the polygon that stands for a circle


class Round(NamedTuple):
    """A round wall about the axis; radius 0: there is none.

    An enclosure with flat walls only has it too, and so shares the compiled kernels.
    """

    radius: float  # [m]


class Enclosure:
    """A closed void: a frozen dataclass whose fields are the keys of a case's [enclosure].

    Sizes are inner ones [m]; each of these may be a field or a property. Flat walls bound it all
    over, so that a void which is not convex has none of these, see cavity.py.
    """

    shape: ClassVar[str]  # its name in a case file
    width: float  # size along x of the box around it, centred on the axis [m]
    depth: float  # along y, likewise [m]
    height: float  # along the axis, from z = 0 [m]
    volume: float  # of the void [m3]
    wall_names: list[str]  # of the flat walls, then of the curved ones
    radius: float | None = None  # of a round wall [m]; None: there is none

    @classmethod
    def units(cls) -> dict[str, str]:
        """Return the keys of [enclosure] that it takes, with SI units: metadata "unit", else m."""
        return {field.name: field.metadata.get("unit", "m") for field in fields(cls)}

    @classmethod
    def required(cls) -> list[str]:
        """Return those of the keys that have no default."""
        return [field.name for field in fields(cls) if field.default is MISSING]

    @property
    def planes(self) -> np.ndarray:
        """Flat walls (n, 4): inward unit normal and offset [m]; bottom and top."""
        return np.array([(0.0, 0.0, 1.0, 0.0), (0.0, 0.0, -1.0, -self.height)])

    @property
    def surface(self) -> Any:
        """Numbers of the curved walls, a named tuple of a registered type."""
        return Round(0.0)

    def surface_for(self, radius: float) -> Any:
        """Numbers of the curved walls, for spheres of a radius up to this [m]."""
        return self.surface

    @property
    def narrowest(self) -> float:
        """Largest diameter of a sphere that would still fit in [m]."""
        return min(self.width, self.depth, self.height)

    @property
    def narrowest_place(self) -> str:
        """Place at which that sphere is held, in words."""
        sizes = {"across, along x": self.width, "across, along y": self.depth,
                 "between bottom and top": self.height}  # fmt: skip
        return min(sizes, key=lambda name: sizes[name])

    @property
    def words(self) -> str:
        """Shape and sizes in words."""
        if self.radius is not None:
            return f"{self.shape}, {self.width:g} m in diameter, {self.height:g} m high"
        return f"{self.shape}, {self.width:g} m (x) by {self.depth:g} m (y), {self.height:g} m high"

    @property
    def keys(self) -> dict[str, Any]:
        """The keys of [enclosure] with which a case has it again."""
        return {name: getattr(self, name) for name in self.units()}

    @property
    def cells(self) -> np.ndarray:
        """Centres (n, 2) of the equal voids that it is made of [m]; of most one, in the middle."""
        return np.zeros((1, 2))

    @property
    def cylinder_radius(self) -> float:
        """Radius of the round wall [m]; 0: there is none."""
        return self.radius or 0.0

    @property
    def identity(self) -> list[Any]:
        """Shape and sizes, by which a packing is named."""
        return [self.shape, *(getattr(self, name) for name in self.units())]

    @property
    def middle(self) -> np.ndarray:
        """A point (3,) well inside [m]: here the middle of the box around it."""
        return np.array([0.0, 0.0, 0.5 * self.height])

    @property
    def polygons(self) -> list[tuple[str, np.ndarray]]:
        """Wall and corners (p, 3) [m] of the polygons by which it is drawn; edges lie on it."""
        up = np.array([0.0, 0.0, self.height])
        if self.radius is None:
            x, y = self.width / 2, self.depth / 2
            base = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]])
            names = ["front", "right", "back", "left"]
        else:
            base, names = self.width / 2 * ring(), ["side"] * SIDES
        after = np.roll(base, -1, axis=0)
        around = [
            (name, np.stack([a, b, b + up, a + up]))
            for name, a, b in zip(names, base, after, strict=True)
        ]
        return [("bottom", base), ("top", base + up), *around]

    def lowest(self, up: np.ndarray) -> float:
        """Least of up . x in the enclosure [m], here of the box around it; up (3,) is a unit."""
        low_z = min(0.0, float(up[2]) * self.height)
        return low_z - 0.5 * (abs(up[0]) * self.width + abs(up[1]) * self.depth)

    def through(self, along: np.ndarray) -> tuple[float, float]:
        """Extent from its middle, against and with the unit vector `along` (3,) [m].

        The first is negative.
        """
        middle = self.middle
        rate = self.planes[:, :3] @ along
        distance = (self.planes[:, 3] - self.planes[:, :3] @ middle) / np.where(
            rate == 0.0, np.nan, rate
        )
        if self.cylinder_radius:
            across = np.hypot(along[0], along[1])
            side = self.cylinder_radius / across if across > 0.0 else np.inf
            distance = np.append(distance, [side, -side])
        elif len(self.wall_names) > len(self.planes):
            ends = [sign * self._to_curved(middle, sign * along) for sign in (1.0, -1.0)]
            distance = np.append(distance, ends)
        with_it, against = distance[distance > 0.0], distance[distance < 0.0]
        return float(np.nanmax(against)), float(np.nanmin(with_it))

    def _to_curved(self, start: np.ndarray, along: np.ndarray) -> float:
        """Way from a point to the nearest curved wall of a convex void, along a unit vector [m]."""
        near, far = 0.0, 2.0 * math.hypot(self.width, self.depth, self.height)
        for _ in range(60):  # bisection, to the last bits
            middle = 0.5 * (near + far)
            inside = self.clearance((start + middle * along)[None])[0] > 0.0
            near, far = (middle, far) if inside else (near, middle)
        return near

    def volume_below(self, up: np.ndarray, level: float) -> float:
        """Volume of the void where up . x < level [m3], summed over 64 cells a side.

        up (3,) is a unit vector. Of cells that the level or a wall cuts, a part counts: exact for
        the axes of a box.
        """
        middles = (np.arange(_GRID) + 0.5) / _GRID
        sizes = np.array([self.width, self.depth, self.height])
        x = (middles - 0.5)[:, None, None] * sizes[0]
        y = (middles - 0.5)[None, :, None] * sizes[1]
        z = middles[None, None, :] * sizes[2]
        extent = float(np.abs(up) @ sizes) / _GRID
        below = np.clip((level - (up[0] * x + up[1] * y + up[2] * z)) / extent + 0.5, 0.0, 1.0)
        points = np.stack(np.broadcast_arrays(x, y, z), axis=-1).reshape(-1, 3)
        away = self.clearance(points).reshape(below.shape)
        below = below * np.clip(away / (self.width / _GRID) + 0.5, 0.0, 1.0)
        return float(below.mean() * sizes.prod())

    def clearance(self, points: np.ndarray) -> np.ndarray:
        """Least distance (n,) [m] of points (n, 3) from walls that are no faces of that box.

        Negative outside of them, infinite where there are no such walls.
        """
        from damper3d.engine.enclosures import nearest_of

        slanted = [plane for plane in self.planes if np.abs(plane[:3]).max() < 1.0]
        found = [points @ plane[:3] - plane[3] for plane in slanted]
        surface, x = self.surface, np.asarray(points, float).T
        nearest: Callable[..., Any] = nearest_of(type(surface))
        for wall in range(len(self.wall_names) - len(self.planes)):
            distance = np.vectorize(lambda *p, k=wall: nearest(surface, k, *p)[0], otypes=[float])
            found.append(distance(*x))
        return np.min(found, axis=0) if found else np.full(len(points), np.inf)


def ring() -> np.ndarray:
    """Corners (SIDES, 3) of the polygon that stands for a circle of radius one about the axis."""
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    return np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
