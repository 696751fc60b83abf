"""Oblate spheroids, their short axis along x (thesis, eqs 4.8, 8.1, 8.2)."""

import math

import numpy as np

from damper3d.shapes.family import Family, Numbers, Value
from damper3d.shapes.multisphere import MultiSphere, sphere
from damper3d.shapes.prolate import axes
from damper3d.shapes.surfaces.solid import Solid, filled
from damper3d.shapes.surfaces.surface import Surface, unit_sphere


def oblate(ratio: float) -> Solid:
    """An oblate spheroid of an equal-volume radius of 1 m; ratio: a/b, below 1."""
    a, b = axes(ratio)
    sphere = unit_sphere()
    corners = sphere.corners
    # Triangles of the sphere lie 1 - |middle| inside; stretched, at most the longer axis as much.
    flatness = b * (1.0 - float(np.linalg.norm(corners.mean(axis=1), axis=1).min()))
    volume = 4.0 / 3.0 * math.pi * a * b**2
    bent = math.sqrt(1.0 - (a / b) ** 2)
    return Solid(
        surface=Surface(sphere.vertices * [a, b, b], sphere.triangles),
        flatness=flatness,
        volume=volume,
        area=2.0 * math.pi * b**2 * (1.0 + (a / b) ** 2 / bent * math.atanh(bent)),
        inertia=volume / 5.0 * np.array([2 * b**2, a**2 + b**2, a**2 + b**2]),
    )


def _build(numbers: Numbers, sub_spheres: int | None, tolerance: float | None) -> MultiSphere:
    (ratio,) = numbers
    if ratio == 1.0:
        return sphere(1.0)
    return filled(oblate(ratio), "oblate", sub_spheres, tolerance)


FAMILY = Family("oblate:0.7", _build, values=(Value("aspect ratio a/b", 0.2, 1.0),))
