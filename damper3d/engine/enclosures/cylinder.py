"""A closed cylinder: bottom, top and one round wall."""

import math
from dataclasses import dataclass

import numpy as np

from damper3d.engine.enclosures.enclosure import Enclosure, Round


@dataclass(frozen=True)
class Cylinder(Enclosure):
    """A closed cylinder; inner sizes [m]."""

    shape = "cylinder"
    diameter: float = 0.04
    height: float = 0.04

    @property
    def radius(self) -> float:
        """Radius of the round wall [m]."""
        return 0.5 * self.diameter

    @property
    def width(self) -> float:
        """The diameter [m]."""
        return self.diameter

    @property
    def depth(self) -> float:
        """The diameter [m]."""
        return self.diameter

    @property
    def volume(self) -> float:
        """Volume of the void [m3]."""
        return math.pi * self.radius**2 * self.height

    @property
    def surface(self) -> Round:
        """The round wall."""
        return Round(self.radius)

    @property
    def wall_names(self) -> list[str]:
        """Bottom, top and side."""
        return ["bottom", "top", "side"]

    @property
    def identity(self) -> list[object]:
        """Shape and sizes of the box around it: by these a cylinder has always been named."""
        return [self.shape, self.width, self.depth, self.height]

    def lowest(self, up: np.ndarray) -> float:
        """Least of up . x in the enclosure [m]; up (3,) is a unit vector."""
        low_z = min(0.0, float(up[2]) * self.height)
        return low_z - self.radius * float(np.hypot(up[0], up[1]))

    def clearance(self, points: np.ndarray) -> np.ndarray:
        """Distance (n,) [m] of points (n, 3) from the round wall."""
        return self.radius - np.hypot(points[:, 0], points[:, 1])


def cylinder(diameter: float, height: float) -> Cylinder:
    """Return a closed cylinder; inner sizes [m]."""
    return Cylinder(diameter, height)


def nearest_round(surface, wall, x, y, z):
    """Distance of a point in the enclosure from the round wall, and what belongs to it.

    See damper3d.engine.enclosures.register for what the geometry of a curved wall returns.
    """
    away = np.sqrt(x * x + y * y)
    outwards = 1.0 / max(away, 1e-300)
    return surface.radius - away, (outwards * x, outwards * y, 0.0), 2.0 * surface.radius
