"""Level below which a void has a volume, exact for the walls that an enclosure is drawn by."""

import numpy as np
from numpy.typing import NDArray

from damper3d.engine.enclosures import Cavity, Cells, Enclosure, Polyhedron

Array = NDArray[np.float64]

_HALVINGS = 40  # of where a level lies


def level_of(enclosure: Enclosure, up: Array, volume: float) -> float:
    """Level [m] along a unit vector `up` (3,) below which the void has a volume [m3]."""
    over, area = walls_along(enclosure, up)
    low, high = float(over.min()), float(over.max())
    part = volume / enclosure.volume * volume_below(over, area, high)
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if volume_below(over, area, middle) < part:
            low = middle
        else:
            high = middle
    return high


def walls_along(enclosure: Enclosure, up: Array) -> tuple[Array, Array]:
    """Heights (m, 3) [m] of the corners of an enclosure's walls, in triangles, along `up` (3,).

    Also their areas (m,) [m2] as seen along it, negative from below. The walls are those that it is
    drawn by: closed and, but for a cavity's or polyhedron's, convex.
    """
    if isinstance(enclosure, Cells):
        over, area = walls_along(enclosure.cell, up)
        raised = enclosure.cells @ up[:2]
        return (raised[:, None, None] + over).reshape(-1, 3), np.tile(area, len(raised))
    corners = np.concatenate([_fan(points) for _, points in enclosure.polygons])
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    if not isinstance(enclosure, Cavity | Polyhedron):  # of the others any way round will do
        outwards = np.einsum("ij,ij->i", across, corners.mean(axis=1) - enclosure.middle)
        across *= np.sign(outwards)[:, None]
    return corners @ up, 0.5 * across @ up


def volume_below(over: Array, area: Array, level: float) -> float:
    """Volume [m3] of a void below a level [m], from the heights and areas of its walls.

    By the divergence theorem: the sum over the walls of their area times the mean of the height
    over the level, where they are below it.
    """
    return float(area @ _mean_below(over - level))


def _fan(points: Array) -> Array:
    """A polygon (p, 3) as triangles (p - 2, 3, 3) from its first corner."""
    return np.stack([np.broadcast_to(points[0], points[1:-1].shape), points[1:-1], points[2:]], 1)


def _mean_below(over: Array) -> Array:
    """Mean over triangles of min(h, 0) for a linear h with values (m, 3) at their corners."""
    low, middle, high = np.sort(over, axis=1).T
    with np.errstate(divide="ignore", invalid="ignore"):
        one_below = low**3 / ((low - middle) * (low - high)) / 3.0
        one_above = high**3 / ((high - middle) * (high - low)) / 3.0
    mean = over.mean(axis=1)
    return np.select([high <= 0.0, middle <= 0.0, low < 0.0], [mean, mean - one_above, one_below])
