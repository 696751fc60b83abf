"""The enclosure: a closed cylinder or box, as planes and one round wall, in its own frame.

z is the axis and the origin the centre of the bottom. A plane is a row (n_x, n_y, n_z, offset)
with the unit normal n pointing inwards; a point r inside has n . r - offset > 0.
"""

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Enclosure:
    """A cylinder (radius, height) or a box (width along x, depth along y, height); inner sizes."""

    shape: str  # "cylinder" or "box"
    radius: float | None  # [m] of a cylinder, None for a box
    width: float  # [m] of a cylinder its diameter, like the depth
    depth: float  # [m]
    height: float  # [m]

    @property
    def volume(self) -> float:
        """Of the void [m3]."""
        if self.radius is not None:
            return math.pi * self.radius**2 * self.height
        return self.width * self.depth * self.height

    @property
    def cylinder_radius(self) -> float:
        """Radius of the round wall [m]; 0: there is none."""
        return self.radius or 0.0

    @property
    def narrowest(self) -> float:
        """The largest diameter of a ball that would still fit in [m]."""
        return min(self.width, self.depth, self.height)

    @property
    def planes(self) -> np.ndarray:
        """The flat walls (n, 4): inward unit normal and offset [m]; bottom and top first."""
        rows = [(0.0, 0.0, 1.0, 0.0), (0.0, 0.0, -1.0, -self.height)]
        if self.radius is None:
            half_width, half_depth = 0.5 * self.width, 0.5 * self.depth
            rows += [(1.0, 0.0, 0.0, -half_width), (-1.0, 0.0, 0.0, -half_width)]
            rows += [(0.0, 1.0, 0.0, -half_depth), (0.0, -1.0, 0.0, -half_depth)]
        return np.array(rows)

    @property
    def wall_names(self) -> list[str]:
        """Of the planes, then of the round wall."""
        sides = ["side"] if self.radius is not None else ["left", "right", "front", "back"]
        return ["bottom", "top", *sides]


def cylinder(diameter: float, height: float) -> Enclosure:
    """A closed cylinder; inner sizes [m]."""
    return Enclosure("cylinder", 0.5 * diameter, diameter, diameter, height)


def box(width: float, depth: float, height: float) -> Enclosure:
    """A closed box; inner sizes [m]."""
    return Enclosure("box", None, width, depth, height)
