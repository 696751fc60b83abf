"""Volume, surface, centroid and inertia of what triangles enclose: exact.

Each triangle makes a tetrahedron with the origin, whose volume counts negative where the triangle
faces it; the sums are the integrals of 1, x and x x^T over the solid (B. Mirtich, J. Graphics Tools
1 (1996) 31; D. Eberly, Polyhedral mass properties, 2002).
"""

from typing import NamedTuple

import numpy as np

from damper3d.shapes.surfaces.surface import area_of


class Mass(NamedTuple):
    """Mass properties over the density."""

    volume: float  # [m3], positive where the triangles face outwards
    area: float  # [m2]
    centroid: np.ndarray  # (3,) [m]
    inertia: np.ndarray  # (3, 3) tensor about the centroid [m5]


def mass_of(corners: np.ndarray) -> Mass:
    """Of closed triangles (m, 3, 3) [m] that face outwards."""
    origin = corners.reshape(-1, 3).mean(axis=0)  # near by, so that nothing cancels
    near = corners - origin
    sizes = np.linalg.det(near) / 6.0
    volume = float(sizes.sum())
    total = near.sum(axis=1)
    first = np.einsum("m,mx->x", sizes / 4.0, total)
    # over a tetrahedron with corners 0, a, b, c: V/20 (a a + b b + c c + s s), s = a + b + c
    second = np.einsum("m,mcx,mcy->xy", sizes / 20.0, near, near)
    second += np.einsum("m,mx,my->xy", sizes / 20.0, total, total)
    centroid = first / volume
    second -= volume * np.outer(centroid, centroid)
    inertia = np.trace(second) * np.eye(3) - second
    return Mass(volume, area_of(corners), origin + centroid, inertia)


def principal_axes(inertia: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Principal moments (3,), rising, and axes in columns (3, 3), right-handed.

    Of the two senses of the first two axes the one whose largest component is positive.
    """
    moments, axes = np.linalg.eigh(inertia)
    for k in (0, 1):
        axes[:, k] *= np.sign(axes[np.argmax(np.abs(axes[:, k])), k])
    axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
    return moments, axes
