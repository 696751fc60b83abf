"""An enclosure of one's own: a closed cone on its larger end."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from damper3d import DamperCase, Enclosure, register_enclosure, run


@dataclass(frozen=True)
class Cone(Enclosure):
    """A closed cone; its fields are keys of [enclosure]; inner sizes [m]."""

    shape = "cone"
    diameter: float  # of the bottom
    lid_diameter: float
    height: float = 0.04

    @property
    def width(self):
        return self.diameter

    depth = width

    @property
    def volume(self):
        a, b = 0.5 * self.diameter, 0.5 * self.lid_diameter
        return math.pi / 3.0 * self.height * (a * a + a * b + b * b)

    @property
    def wall_names(self):
        return ["bottom", "top", "side"]

    @property
    def surface(self):
        fall = 0.5 * (self.diameter - self.lid_diameter) / self.height
        return Mantle(0.5 * self.diameter, fall)


class Mantle(NamedTuple):
    """The side: its radius is bottom - fall z."""

    bottom: float
    fall: float


def nearest(surface, wall, x, y, z):
    """Distance from the side, unit vector towards it, harmonic mean of its radii of curvature."""
    away = max(np.sqrt(x * x + y * y), 1e-300)
    slope = np.sqrt(1.0 + surface.fall * surface.fall)
    distance = (surface.bottom - surface.fall * z - away) / slope
    normal = x / (away * slope), y / (away * slope), surface.fall / slope
    return distance, normal, 2.0 * (away * slope + distance)


register_enclosure(Cone, Mantle, nearest)

if __name__ == "__main__":
    sizes = {"diameter": "40 mm", "lid_diameter": "30 mm", "height": "40 mm"}
    cone = {"enclosure.shape": "cone", **{f"enclosure.{key}": text for key, text in sizes.items()}}
    result = run(DamperCase.load("thesis", cone | {"particles.count": 200}))
    print(result.efficiency, result.energy_closure)
