"""Superquadrics: ((x/A)^(2/e2) + (y/B)^(2/e2))^(e2/e1) + (z/C)^(2/e1) = 1, from boxes to octahedra.

Volume and moments in closed form by the beta function (A. Jaklic, A. Leonardis, F. Solina,
Segmentation and Recovery of Superquadrics, Kluwer 2000, chapter 2).
"""

import math

import numpy as np

from damper3d.shapes.family import Family, Numbers, Value
from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.surfaces.solid import Solid, filled
from damper3d.shapes.surfaces.surface import Surface, area_of, unit_sphere


def superquadric(depth: float, height: float, e1: float, e2: float) -> Solid:
    """A superquadric of an equal-volume radius of 1 m.

    depth B/A, height C/A; e1 of the sections along z, e2 of those across; both 1: an ellipsoid.
    """
    half = np.array([1.0, depth, height])
    half *= (4.0 / 3.0 * math.pi / _volume(half, e1, e2)) ** (1 / 3)
    surface, flatness = _surface(half, e1, e2, 5)
    coarser, _ = _surface(half, e1, e2, 4)
    # What triangles lack in area goes with the square of their size.
    area = (4.0 * area_of(surface.corners) - area_of(coarser.corners)) / 3.0
    return Solid(surface, flatness, _volume(half, e1, e2), area, _inertia(half, e1, e2))


def _volume(half: np.ndarray, e1: float, e2: float) -> float:
    from scipy.special import beta

    shape = beta(0.5 * e1 + 1.0, e1) * beta(0.5 * e2, 0.5 * e2)
    return float(2.0 * half.prod() * e1 * e2 * shape)


def _inertia(half: np.ndarray, e1: float, e2: float) -> np.ndarray:
    from scipy.special import beta

    size = half.prod() * e1 * e2
    across = 0.5 * size * beta(1.5 * e2, 0.5 * e2) * beta(0.5 * e1, 2.0 * e1 + 1.0)
    along = 2.0 * size * beta(0.5 * e2, 0.5 * e2 + 1.0) * beta(1.5 * e1, e1 + 1.0)
    squares = half**2 * [across, across, along]  # the integrals of x^2, y^2, z^2
    return squares.sum() - squares


def _surface(half: np.ndarray, e1: float, e2: float, splits: int) -> tuple[Surface, float]:
    """Triangles with their corners on it, and how far it rises above their middles [m]."""
    sphere = unit_sphere(splits)
    surface = Surface(half * _onto(sphere.vertices, e1, e2), sphere.triangles)
    middles = surface.corners.mean(axis=1)
    outside = half * _onto(middles / half, e1, e2)
    return surface, float(np.linalg.norm(outside - middles, axis=1).max())


def _onto(points: np.ndarray, e1: float, e2: float) -> np.ndarray:
    """Points (n, 3) moved along their rays onto the superquadric of half axes 1."""
    size = np.abs(points)
    across = (size[:, 0] ** (2.0 / e2) + size[:, 1] ** (2.0 / e2)) ** (e2 / e1)
    return points * ((across + size[:, 2] ** (2.0 / e1)) ** (-0.5 * e1))[:, None]


def _build(numbers: Numbers, sub_spheres: int | None, tolerance: float | None) -> MultiSphere:
    return filled(superquadric(*numbers), "superquadric", sub_spheres, tolerance)


FAMILY = Family(
    "superquadric:1,1,0.5,0.5",
    _build,
    values=(
        Value("half axis b/a", 0.2, 5.0),
        Value("half axis c/a", 0.2, 5.0),
        Value("exponent e1", 0.3, 1.6),
        Value("exponent e2", 0.3, 1.6),
    ),
)
