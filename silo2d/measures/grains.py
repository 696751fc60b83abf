"""What several measures ask of a run: the size of its grains, columns across it, who is in it."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from silo2d.scene import Scene

Series = NDArray[np.float64]


def grain_size(scene: Scene) -> float:
    """Side [m] of the square that has the mean area of the grains' outlines."""
    points, start = scene.trajectory.static["shape_points"], scene.trajectory.static["shape_start"]
    areas = []
    for first, end in pairwise(start):
        x, y = points[first:end].T
        areas.append(0.5 * (x * np.roll(y, -1) - np.roll(x, -1) * y).sum())  # Gauss
    return float(np.sqrt(np.array(areas)[scene.trajectory.static["kind"]].mean()))


def column_edges(scene: Scene) -> Series:
    """Edges (c + 1,) [m] of equal columns across the silo, an odd number, about two grains wide.

    An odd number puts one column in the middle of a silo whose outlet is there.
    """
    left, right, _, _ = scene.window
    count = 2 * round(((right - left) / (2 * grain_size(scene)) - 1) / 2) + 1
    return np.linspace(left, right, max(count, 3) + 1)


def outlet_centre(scene: Scene) -> float:
    """x of the outlet's middle [m]."""
    (left, _), (right, _) = scene.trajectory.attributes["lips"]
    return float(left + right) / 2


def in_silo(scene: Scene) -> NDArray[np.bool_]:
    """Which grains have not passed y = 0 at each frame (F, n)."""
    out_time = scene.trajectory["out_time"][-1]
    return ~(out_time <= scene.time[:, None])  # NaN: never


def start_height(scene: Scene) -> Series:
    """Height of each grain at the opening (n,) [m]."""
    return scene.trajectory["y"][0].astype(float)


def numbers(series: NDArray) -> list:
    """A series as nested lists for JSON, NaN as None."""
    if series.ndim > 1:
        return [numbers(row) for row in series]
    return [None if np.isnan(value) else float(value) for value in series]
