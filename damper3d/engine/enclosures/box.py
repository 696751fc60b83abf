"""A closed box: six flat walls."""

from dataclasses import dataclass

import numpy as np

from damper3d.engine.enclosures.enclosure import Enclosure


@dataclass(frozen=True)
class Box(Enclosure):
    """A closed box, width along x, depth along y (the width if left out); inner sizes [m]."""

    shape = "box"
    width: float
    depth: float = 0.0
    height: float = 0.04

    def __post_init__(self) -> None:
        """Let a depth that is left out be the width."""
        object.__setattr__(self, "depth", self.depth or self.width)

    @property
    def volume(self) -> float:
        """Volume of the void [m3]."""
        return self.width * self.depth * self.height

    @property
    def planes(self) -> np.ndarray:
        """Walls (6, 4): inward unit normal and offset [m]; bottom and top first."""
        half_width, half_depth = 0.5 * self.width, 0.5 * self.depth
        sides = [
            (1.0, 0.0, 0.0, -half_width), (-1.0, 0.0, 0.0, -half_width),
            (0.0, 1.0, 0.0, -half_depth), (0.0, -1.0, 0.0, -half_depth),
        ]  # fmt: skip
        return np.array([*super().planes, *sides])

    @property
    def wall_names(self) -> list[str]:
        """As the rows of `planes`."""
        return ["bottom", "top", "left", "right", "front", "back"]


def box(width: float, depth: float, height: float) -> Box:
    """Return a closed box; inner sizes [m]."""
    return Box(width, depth, height)
