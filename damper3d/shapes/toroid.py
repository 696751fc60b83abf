"""Circular toroids: n equal sub-spheres on the ring (thesis, sec. 4.4.2, eqs 4.26-4.30).

A tube of radius b runs round the z axis at the distance a; the hole ratio is
h = (a - b)/(a + b). The sub-spheres have the tube's radius and stand at phi_i = 2 pi (i - 1)/n.
"""

import math
from functools import partial

import numpy as np

from damper3d.shapes.family import Family, Numbers, Value, counted
from damper3d.shapes.multisphere import MultiSphere, sphere
from damper3d.shapes.surfaces.surface import tube

USUAL_SUB_SPHERES = 50  # the thesis's, sec. 8.2.2


def radii_of(hole_ratio: float) -> tuple[float, float]:
    """a and b [m] at an equal-volume radius of 1 m (eq. 8.4): 2 pi^2 a b^2 = 4 pi/3."""
    slenderness = (1.0 + hole_ratio) / (1.0 - hole_ratio)  # a/b
    b = (1.5 * math.pi * slenderness) ** (-1 / 3)
    return slenderness * b, b


def fewest_sub_spheres(hole_ratio: float) -> int:
    """The least number whose neighbours overlap: 2 pi/n below 2 b/a (eqs 4.26, 4.27)."""
    a, b = radii_of(hole_ratio)
    return math.floor(math.pi * a / b) + 1


def toroid(hole_ratio: float, sub_spheres: int, name: str = "") -> MultiSphere:
    """A circular toroid of an equal-volume radius of 1 m round the z axis.

    hole_ratio: between 0 and 1; sub_spheres: fewest_sub_spheres() or more.
    """
    a, b = radii_of(hole_ratio)
    phi = np.arange(sub_spheres) * (2.0 * math.pi / sub_spheres)  # eq. 4.29
    volume = 2.0 * math.pi**2 * a * b**2
    across = volume * (0.5 * a**2 + 0.625 * b**2)
    return MultiSphere(
        name=name or f"toroid:{hole_ratio:g}",
        kind="toroid",
        offsets=np.stack([a * np.cos(phi), a * np.sin(phi), np.zeros(sub_spheres)], axis=1),
        radii=np.full(sub_spheres, b),
        volume=volume,
        area=4.0 * math.pi**2 * a * b,
        inertia=np.array([across, across, volume * (a**2 + 0.75 * b**2)]),
        surface=tube(b, a),
        arrangement="ring",
        surface_error=_gap(a, b, sub_spheres),
    )


def _gap(a: float, b: float, n: int) -> float:
    """Depth of the grooves where they are deepest: on the outer equator, half-way between two."""
    outer = a + b
    to_centre = math.sqrt(a**2 + outer**2 - 2.0 * a * outer * math.cos(math.pi / n))
    return to_centre - b


def _build(numbers: Numbers, sub_spheres: int | None, tolerance: float | None) -> MultiSphere:
    (hole,) = numbers
    if hole == 0.0:
        return sphere(1.0)
    make, fewest = partial(toroid, hole), fewest_sub_spheres(hole)
    return counted("toroid", make, fewest, 1, USUAL_SUB_SPHERES, sub_spheres, tolerance)


# Radius and number in a cylinder of 40 mm x 40 mm: thesis, secs 8.2, 8.3.
FAMILY = Family("toroid:0.2", _build, 3.5e-3, 110, (Value("hole ratio (a - b)/(a + b)", 0.0, 0.8),))
