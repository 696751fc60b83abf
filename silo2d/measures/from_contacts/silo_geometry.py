"""The silo's geometry as measures need it: its inside, sides and directions of the walls."""

import numpy as np
from numpy.typing import NDArray

from silo2d.measures.from_contacts.coarse_graining import Grid, intervals_at
from silo2d.measures.from_contacts.particles import outlet_centre
from silo2d.view.scene import Scene

Floats = NDArray[np.float64]


def inside_polygon(scene: Scene) -> Floats:
    """Corners of the silo's inside (n, 2) [m]: the walls in turn, the outlet and the top closed."""
    points = scene.walls.reshape(-1, 2)
    return points[np.r_[True, np.any(points[1:] != points[:-1], axis=1)]]


def sides(scene: Scene) -> NDArray[np.int64]:
    """-1 for walls left of the outlet's middle, 1 for those right of it, 0 for the door (w,)."""
    middles = scene.trajectory.static["wall_segments"].mean(axis=1)[:, 0]
    side = np.where(middles < outlet_centre(scene), -1, 1)
    side[-1] = 0
    return side


def outwards(segments: Floats) -> Floats:
    """Unit vectors (w, 2) out of the silo: the inside is on the left of each wall (w, 2, 2)."""
    along = segments[:, 1] - segments[:, 0]
    return np.column_stack([along[:, 1], -along[:, 0]]) / np.hypot(*along.T)[:, None]


def inside_mask(polygon: Floats, grid: Grid) -> NDArray[np.bool_]:
    """Which points of a grid are in a polygon (n, 2) (j, i)."""
    mask = np.zeros((len(grid.y), len(grid.x)), dtype=bool)
    for j, y in enumerate(grid.y):
        for left, right in intervals_at(polygon, float(y)):
            mask[j] |= (grid.x >= left) & (grid.x <= right)
    return mask
