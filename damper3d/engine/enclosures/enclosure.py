"""Base of all enclosures: a closed convex void as flat and curved walls, in its own frame.

z is the axis and the origin the centre of the bottom. A flat wall is a row (n_x, n_y, n_z, offset)
with the unit normal n pointing inwards; a point r inside has n . r - offset > 0. Curved walls come
after the flat ones: their numbers stand in a named tuple, `surface`, by whose type the engine
chooses the function that knows their geometry (see damper3d.engine.enclosures).
"""

from collections.abc import Callable
from dataclasses import MISSING, fields
from typing import Any, ClassVar, NamedTuple

import numpy as np


class Round(NamedTuple):
    """A round wall about the axis; radius 0: there is none.

    An enclosure with flat walls only has it too, and so shares the compiled kernels.
    """

    radius: float  # [m]


class Enclosure:
    """A closed convex void: a frozen dataclass whose fields are the keys of a case's [enclosure].

    Sizes are inner ones [m]; each of these may be a field or a property.
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

    @property
    def narrowest(self) -> float:
        """Largest diameter of a sphere that would still fit in [m]."""
        return min(self.width, self.depth, self.height)

    @property
    def cylinder_radius(self) -> float:
        """Radius of the round wall [m]; 0: there is none."""
        return self.radius or 0.0

    @property
    def identity(self) -> list[Any]:
        """Shape and sizes, by which a packing is named."""
        return [self.shape, *(getattr(self, name) for name in self.units())]

    def lowest(self, up: np.ndarray) -> float:
        """Least of up . x in the enclosure [m], here of the box around it; up (3,) is a unit."""
        low_z = min(0.0, float(up[2]) * self.height)
        return low_z - 0.5 * (abs(up[0]) * self.width + abs(up[1]) * self.depth)

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
