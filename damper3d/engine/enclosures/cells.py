"""Cells: an array of equal boxes or cylinders, side by side in one carrier that moves as one."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from damper3d.engine.enclosures.enclosure import Enclosure


class Sides(NamedTuple):
    """The sides of equal cells about the axis: of boxes, or of cylinders."""

    pitch_x: float  # from the middle of a cell to that of the next [m]
    pitch_y: float
    n_x: int
    n_y: int
    half_x: float  # half the width of a box [m]
    half_y: float
    radius: float  # of a cylinder [m]; 0: boxes


@dataclass(frozen=True)
class Cells(Enclosure):
    """n_x by n_y equal cells with walls of a thickness between them [m]."""

    cell: Enclosure
    n_x: int
    n_y: int
    thickness: float

    shape = "cells"

    @property
    def pitch(self) -> np.ndarray:
        """From the middle of a cell to that of the next (2,) [m]."""
        return np.array([self.cell.width, self.cell.depth]) + self.thickness

    @property
    def cells(self) -> np.ndarray:
        """Centres (n, 2) of the cells [m], row by row along x."""
        x, y = (
            (np.arange(n) - 0.5 * (n - 1)) * step
            for n, step in zip((self.n_x, self.n_y), self.pitch, strict=True)
        )
        return np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)

    @property
    def middle(self) -> np.ndarray:
        """The middle of the first cell (3,) [m]."""
        return np.array([*self.cells[0], 0.0]) + self.cell.middle

    @property
    def width(self) -> float:
        """From the first cell's outer side to that of the last, along x [m]."""
        return float(self.n_x * self.pitch[0]) - self.thickness

    @property
    def depth(self) -> float:
        """Along y, likewise [m]."""
        return float(self.n_y * self.pitch[1]) - self.thickness

    @property
    def height(self) -> float:
        """Height of a cell [m]."""
        return self.cell.height

    @property
    def volume(self) -> float:
        """Volume of all voids together [m3]."""
        return self.n_x * self.n_y * self.cell.volume

    @property
    def surface(self) -> Sides:
        """The sides of all cells."""
        half = 0.5 * self.cell.width, 0.5 * self.cell.depth
        return Sides(*map(float, self.pitch), self.n_x, self.n_y, *half, self.cell.radius or 0.0)

    @property
    def wall_names(self) -> list[str]:
        """As of one cell: the walls of a name are those of all cells."""
        return self.cell.wall_names

    @property
    def narrowest(self) -> float:
        """Largest diameter of a sphere that would still fit into a cell [m]."""
        return self.cell.narrowest

    @property
    def narrowest_place(self) -> str:
        """Place at which that sphere is held, in words."""
        return self.cell.narrowest_place

    @property
    def identity(self) -> list[Any]:
        """The cell, how many there are and what is between them."""
        return [*self.cell.identity, "cells", self.n_x, self.n_y, self.thickness]

    @property
    def keys(self) -> dict[str, Any]:
        """Those of a cell, and of the array."""
        own = {"cells": [self.n_x, self.n_y], "cell_wall": self.thickness}
        return {**self.cell.keys, **own}

    @property
    def words(self) -> str:
        """The array and its cell, in words."""
        return f"{self.n_x} by {self.n_y} cells, {self.thickness:g} m apart: {self.cell.words}"

    @property
    def polygons(self) -> list[tuple[str, np.ndarray]]:
        """Those of all cells; see Enclosure.polygons."""
        return [
            (name, points + np.array([*centre, 0.0]))
            for centre in self.cells
            for name, points in self.cell.polygons
        ]

    def lowest(self, up: np.ndarray) -> float:
        """Least of up . x in the cells [m]; up (3,) is a unit vector."""
        return self.cell.lowest(up) + float((self.cells @ up[:2]).min())

    def through(self, along: np.ndarray) -> tuple[float, float]:
        """Extent of a cell from its middle, against and with `along` [m]."""
        return self.cell.through(along)

    def volume_below(self, up: np.ndarray, level: float) -> float:
        """Volume of the voids where up . x < level [m3]."""
        raised = np.round(self.cells @ up[:2], 15)
        levels, times = np.unique(level - raised, return_counts=True)
        parts = [self.cell.volume_below(up, level) for level in levels]
        return float(times @ parts)

    def clearance(self, points: np.ndarray) -> np.ndarray:
        """Least distance (n,) [m] of points (n, 3) from the sides of the nearest cell."""
        x, y = np.asarray(points, float).T[:2]
        sides = range(1 if self.surface.radius else 4)
        return np.min([_to_side(self.surface, side, x, y) for side in sides], axis=0)


def _to_side(surface: Sides, wall: int, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Distance (n,) [m] of points from a side, as nearest_side has it."""
    ways = [
        way - pitch * (np.clip(np.floor(way / pitch + 0.5 * n), 0, n - 1) - 0.5 * (n - 1))
        for way, pitch, n in ((x, surface.pitch_x, surface.n_x), (y, surface.pitch_y, surface.n_y))
    ]
    if surface.radius > 0.0:
        return surface.radius - np.hypot(*ways)
    sign = 1.0 if wall % 2 == 0 else -1.0
    return (surface.half_x, surface.half_y)[wall // 2] + sign * ways[wall // 2]


def nearest_side(surface, wall, x, y, z):
    """Distance of a point from a side of the cell that it is in, and what belongs to it.

    Sides of a box: left, right, front, back. See damper3d.engine.enclosures.register.
    """
    i = min(max(np.floor(x / surface.pitch_x + 0.5 * surface.n_x), 0.0), surface.n_x - 1.0)
    j = min(max(np.floor(y / surface.pitch_y + 0.5 * surface.n_y), 0.0), surface.n_y - 1.0)
    x -= surface.pitch_x * (i - 0.5 * (surface.n_x - 1))
    y -= surface.pitch_y * (j - 0.5 * (surface.n_y - 1))
    if surface.radius > 0.0:
        away = np.sqrt(x * x + y * y)
        outwards = 1.0 / max(away, 1e-300)
        normal = outwards * x, outwards * y, 0.0
        return surface.radius - away, normal, 2.0 * surface.radius
    sign = 1.0 if wall % 2 == 0 else -1.0
    if wall < 2:
        return surface.half_x + sign * x, (-sign, 0.0, 0.0), np.inf
    return surface.half_y + sign * y, (0.0, -sign, 0.0), np.inf
