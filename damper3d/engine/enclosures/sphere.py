"""A closed sphere."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from damper3d.engine.enclosures.enclosure import SIDES, Enclosure, ring


class Ball(NamedTuple):
    """A spherical wall, whose lowest point is the origin."""

    radius: float  # [m]


@dataclass(frozen=True)
class Sphere(Enclosure):
    """A closed sphere; inner diameter [m]."""

    shape = "sphere"
    diameter: float

    @property
    def width(self) -> float:
        """The diameter [m]."""
        return self.diameter

    depth = width
    height = width

    @property
    def volume(self) -> float:
        """Volume of the void [m3]."""
        return math.pi / 6.0 * self.diameter**3

    @property
    def planes(self) -> np.ndarray:
        """No flat walls, (0, 4)."""
        return np.zeros((0, 4))

    @property
    def surface(self) -> Ball:
        """The one wall."""
        return Ball(0.5 * self.diameter)

    @property
    def wall_names(self) -> list[str]:
        """The one wall."""
        return ["shell"]

    @property
    def narrowest_place(self) -> str:
        """Place at which the largest sphere that fits in is held, in words."""
        return "across"

    @property
    def words(self) -> str:
        """Shape and size in words."""
        return f"sphere, {self.diameter:g} m in diameter"

    @property
    def polygons(self) -> list[tuple[str, np.ndarray]]:
        """The flat pieces that stand for the wall, with corners on it; see Enclosure.polygons."""
        radius, levels = 0.5 * self.diameter, np.linspace(-0.5 * np.pi, 0.5 * np.pi, SIDES // 2 + 1)
        rings = [
            radius * (np.cos(level) * ring() + np.array([0.0, 0.0, 1.0 + np.sin(level)]))
            for level in levels
        ]
        found = []
        for k, (low, high) in enumerate(pairwise(rings)):
            corners = [low, np.roll(low, -1, axis=0), np.roll(high, -1, axis=0), high]
            corners = corners[1:] if k == 0 else corners[:3] if k == len(rings) - 2 else corners
            found += [("shell", piece) for piece in np.stack(corners, axis=1)]
        return found

    def lowest(self, up: np.ndarray) -> float:
        """Least of up . x in the enclosure [m]; up (3,) is a unit vector."""
        return 0.5 * self.diameter * (float(up[2]) - 1.0)

    def volume_below(self, up: np.ndarray, level: float) -> float:
        """Volume of the void where up . x < level [m3]: that of a spherical cap."""
        deep = min(max(level - self.lowest(up), 0.0), self.diameter)
        return math.pi * deep**2 * (0.5 * self.diameter - deep / 3.0)

    def clearance(self, points: np.ndarray) -> np.ndarray:
        """Distance (n,) [m] of points (n, 3) from the wall."""
        radius = 0.5 * self.diameter
        return radius - np.linalg.norm(np.asarray(points, float) - (0.0, 0.0, radius), axis=1)


def nearest_in_ball(surface, wall, x, y, z):
    """Distance of a point in the enclosure from the wall, and what belongs to it.

    See damper3d.engine.enclosures.register for what the geometry of a curved wall returns.
    """
    up = z - surface.radius
    away = np.sqrt(x * x + y * y + up * up)
    outwards = 1.0 / max(away, 1e-300)
    normal = outwards * x, outwards * y, outwards * up
    return surface.radius - away, normal, surface.radius
