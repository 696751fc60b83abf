"""Walls of an enclosure for a page: triangles, edges, the box round it, and the way to a wall."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from damper3d.engine.enclosures import Enclosure, nearest_of
from granulab.campaign.output.page.packing import Quantised, linear

Floats = NDArray[np.float64]

_SHARP = 0.87  # cosine between two faces, below which the edge between them is always drawn


def to_wall(enclosure: Enclosure, wall: int, point: Floats) -> Floats:
    """From a point to the nearest one of a wall (3,) [m]; walls as wall_names has them."""
    planes = enclosure.planes
    if wall < len(planes):
        normal, offset = planes[wall, :3], planes[wall, 3]
        return -(point @ normal - offset) * normal
    surface = enclosure.surface
    nearest: Callable[..., Any] = nearest_of(type(surface))
    distance, outwards, _ = nearest(surface, wall - len(planes), *map(float, point))
    return distance * np.array(outwards)


def box(enclosure: Enclosure) -> tuple[Floats, Floats]:
    """Lower and upper corner [m] of the box round an enclosure."""
    points = np.concatenate([points for _, points in enclosure.polygons])
    return points.min(axis=0), points.max(axis=0)


def drawn_walls(enclosure: Enclosure) -> dict[str, Quantised]:
    """Triangles of the walls (t, 3, 3), and of their edges the ends and two normals (e, 2, 3)."""
    polygons = [points for _, points in enclosure.polygons]
    triangles = [points[[0, k, k + 1]] for points in polygons for k in range(1, len(points) - 1)]
    ends, normals = _edges(polygons)
    return {
        "face": linear(np.concatenate(triangles), 0.0),
        "edge": linear(ends, 0.0),
        "edge_normal": linear(normals, 0.0),
    }


def _edges(polygons: list[Floats]) -> tuple[Floats, Floats]:
    """Ends of the edges (e, 2, 3) [m], and unit normals of the two faces beside each (e, 2, 3).

    The normals are zeros where the edge is sharp and always drawn; else it is drawn where one of
    the faces is turned away from the eye.
    """
    beside: dict[tuple[Any, ...], list[tuple[Floats, int]]] = {}
    for points in polygons:
        normal = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
        normal /= max(float(np.linalg.norm(normal)), 1e-300)
        corners = [tuple(np.round(point, 9) + 0.0) for point in points]
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            beside.setdefault((min(a, b), max(a, b)), []).append((normal, 1 if a < b else -1))
    normals = np.zeros((len(beside), 2, 3))
    for row, faces in zip(normals, beside.values(), strict=True):
        if len(faces) == 2:
            (one, along), (two, other) = faces
            two = -two if along == other else two  # their corners go round alike
            if one @ two > _SHARP:
                row[:] = one, two
    return np.array(list(beside)), normals
