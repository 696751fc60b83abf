"""Triangles on the surface of overlapping spheres taken together, for pictures.

Surface nets (Gibson 1998, MICCAI, LNCS 1496, 888): a corner in every cell of a grid that the
surface passes through, moved onto it, and a square round every edge of the grid that it cuts.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

OF_A_CELL = 5.6  # triangles of a surface over the square of the cells along it; 5.5 to 7.6 found
_STEPS = 3  # towards the nearest sphere, of a corner that moves onto the surface
# The four cells round an edge along each axis, in turn, as steps back along the other two.
_ROUND = ((0, 0), (1, 0), (1, 1), (0, 1))


class Skin(NamedTuple):
    """Corners (v, 3) [m], outward unit normals there (v, 3), triangles (t, 3) anticlockwise."""

    corners: Floats
    normals: Floats
    triangles: NDArray[np.int64]


def skin(centres: Floats, radii: Floats, cells: int) -> Skin:
    """The surface of spheres, centres (k, 3) and radii (k,) [m].

    cells: of the grid along their longest side. Corners lie on the spheres; what is smaller than a
    cell is lost.
    """
    low, high = (centres - radii[:, None]).min(axis=0), (centres + radii[:, None]).max(axis=0)
    size = float((high - low).max()) / cells
    # Two free layers all round, and off the symmetric planes, on which much would be zero.
    origin = low - 2.13 * size
    shape = np.ceil((high - origin) / size).astype(int) + 3
    nodes = origin + size * np.moveaxis(np.indices(shape), 0, -1)
    inside = np.zeros(shape, bool)
    for centre, radius in zip(centres, radii, strict=True):
        inside |= ((nodes - centre) ** 2).sum(axis=-1) < radius**2
    return _nets(inside, origin, size, centres, radii)


def _nets(inside: NDArray[np.bool_], origin: Floats, size: float, centres: Floats,
          radii: Floats) -> Skin:  # fmt: skip
    squares, outwards = [], []
    for axis in range(3):
        before, after = np.delete(inside, -1, axis), np.delete(inside, 0, axis)
        edges = np.argwhere(before != after)
        one, two = (axis + 1) % 3, (axis + 2) % 3
        square = np.repeat(edges[:, None], 4, axis=1)
        for k, (i, j) in enumerate(_ROUND):
            square[:, k, one] -= i
            square[:, k, two] -= j
        # Round the axis anticlockwise, as the cells lie behind: turned where it leads inwards.
        squares.append(square)
        outwards.append(before[tuple(edges.T)])
    of_squares, leads_out = np.concatenate(squares), np.concatenate(outwards)
    of_squares[~leads_out] = of_squares[~leads_out][:, ::-1]
    cells, which = np.unique(of_squares.reshape(-1, 3), axis=0, return_inverse=True)
    quads = which.reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    points, normals = _onto(origin + size * (cells + 0.5), centres, radii)
    return Skin(points, normals, triangles)


def _onto(points: Floats, centres: Floats, radii: Floats) -> tuple[Floats, Floats]:
    """Points moved onto the spheres, each onto the one whose surface is nearest; and normals."""
    for _ in range(_STEPS):
        away = points[:, None] - centres
        distance = np.linalg.norm(away, axis=2)
        nearest = np.argmin(distance - radii, axis=1)
        rows = np.arange(len(points))
        normals = away[rows, nearest] / distance[rows, nearest, None]
        points = centres[nearest] + radii[nearest, None] * normals
    return points, normals
