"""A closed frustum of a cone: bottom, top and one conical wall."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from damper3d.engine.enclosures.enclosure import Enclosure, ring


class Mantle(NamedTuple):
    """A conical wall about the axis, whose radius is bottom - fall z."""

    bottom: float  # radius at z = 0 [m]
    fall: float  # of the radius with height; negative where it widens upwards


@dataclass(frozen=True)
class Frustum(Enclosure):
    """A closed frustum about the axis; inner sizes [m]."""

    shape = "frustum"
    diameter: float  # of the bottom
    top_diameter: float
    height: float = 0.04

    @property
    def width(self) -> float:
        """The larger diameter [m]."""
        return max(self.diameter, self.top_diameter)

    depth = width

    @property
    def volume(self) -> float:
        """Volume of the void [m3]."""
        a, b = 0.5 * self.diameter, 0.5 * self.top_diameter
        return math.pi / 3.0 * self.height * (a * a + a * b + b * b)

    @property
    def surface(self) -> Mantle:
        """The conical wall."""
        fall = 0.5 * (self.diameter - self.top_diameter) / self.height
        return Mantle(0.5 * self.diameter, fall)

    @property
    def wall_names(self) -> list[str]:
        """Bottom, top and side."""
        return ["bottom", "top", "side"]

    @property
    def narrowest(self) -> float:
        """Diameter of the largest sphere that fits in [m]: it touches the side and an end, or both.

        One on the axis at the larger end, of radius r, touches the side where
        r (slope + |fall|) is the radius of that end.
        """
        fall = abs(self.surface.fall)
        return min(self.height, self.width / (math.hypot(1.0, fall) + fall))

    @property
    def narrowest_place(self) -> str:
        """Place at which that sphere is held, in words."""
        between = self.narrowest == self.height
        return "between bottom and top" if between else "across, within the side"

    @property
    def words(self) -> str:
        """Shape and sizes in words."""
        return (
            f"frustum, {self.diameter:g} m in diameter at the bottom and {self.top_diameter:g} m "
            f"at the top, {self.height:g} m high"
        )

    @property
    def polygons(self) -> list[tuple[str, np.ndarray]]:
        """Bottom, top and the flat pieces that stand for the side; see Enclosure.polygons."""
        bottom = 0.5 * self.diameter * ring()
        top = 0.5 * self.top_diameter * ring() + np.array([0.0, 0.0, self.height])
        after = np.roll(bottom, -1, axis=0), np.roll(top, -1, axis=0)
        sides = np.stack([bottom, *after, top], axis=1)
        return [("bottom", bottom[::-1]), ("top", top), *(("side", side) for side in sides)]

    def lowest(self, up: np.ndarray) -> float:
        """Least of up . x in the enclosure [m]; up (3,) is a unit vector."""
        across = 0.5 * float(np.hypot(up[0], up[1]))
        return min(-across * self.diameter, float(up[2]) * self.height - across * self.top_diameter)

    def clearance(self, points: np.ndarray) -> np.ndarray:
        """Distance (n,) [m] of points (n, 3) from the conical wall."""
        x, y, z = np.asarray(points, float).T
        bottom, fall = self.surface
        return (bottom - fall * z - np.hypot(x, y)) / math.hypot(1.0, fall)


def nearest_on_mantle(surface, wall, x, y, z):
    """Distance of a point in the enclosure from the conical wall, and what belongs to it.

    The wall's smaller radius of curvature at the place is its radius there over the cosine of its
    slope, the other is infinite. See damper3d.engine.enclosures.register.
    """
    away = max(np.sqrt(x * x + y * y), 1e-300)
    slope = np.sqrt(1.0 + surface.fall * surface.fall)
    distance = (surface.bottom - surface.fall * z - away) / slope
    normal = x / (away * slope), y / (away * slope), surface.fall / slope
    return distance, normal, 2.0 * (away * slope + distance)
