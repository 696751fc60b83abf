"""Prolate spheroids: 2n + 1 sub-spheres on the axis (thesis, sec. 4.4.1, eqs 4.8-4.15).

The spheroid x^2/a^2 + (y^2 + z^2)/b^2 = 1 has the long half axis a along x. The sphere about x_i
that touches it from inside has R_i^2 = b^2 (a^2 - b^2 - x_i^2)/(a^2 - b^2), and the last one,
R_n = b^2/a, touches its tip: x_n = a - R_n. The distances of the centres go with the height of the
spheroid there, d_(i+2) = d_(i+1) z_(i+1)/z_i, which leaves d_1 to be found from x_n.
"""

import math
from functools import partial

import numpy as np

from damper3d.shapes.family import Family, Numbers, Value, counted
from damper3d.shapes.multisphere import MultiSphere, sphere
from damper3d.shapes.surfaces.covering import needed_growth
from damper3d.shapes.surfaces.surface import Surface, unit_sphere

USUAL_SUB_SPHERES = 51  # the thesis's, sec. 8.2.1
_PIECES = 20_000  # of the quarter ellipse, for the bound on the surface error


def axes(ratio: float) -> tuple[float, float]:
    """Half axes a, b [m] at an equal-volume radius of 1 m, from a/b (eqs 8.1, 8.2)."""
    return ratio ** (2 / 3), ratio ** (-1 / 3)


def centres(ratio: float, sub_spheres: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions x_i >= 0 of the centres and radii R_i of the sub-spheres 0..n, each (n + 1,) [m].

    At an equal-volume radius of 1 m; sub_spheres = 2 n + 1, odd and at least 3; ratio above 1.
    """
    from scipy.optimize import brentq

    a, b = axes(ratio)
    n = (sub_spheres - 1) // 2
    tip = a - b**2 / a  # eqs 4.12, 4.13
    first = brentq(lambda d: _positions(d, n, a, b)[-1] - tip, 0.0, tip, xtol=1e-15, rtol=1e-15)
    x = _positions(first, n, a, b)
    x[-1] = tip  # to the last bit, as brentq cannot
    return x, b * np.sqrt(1.0 - x**2 / (a**2 - b**2))  # eq. 4.11


def fewest_sub_spheres(ratio: float) -> int:
    """The least odd number whose neighbours overlap, so that they are one particle."""
    number = 3
    while True:
        x, radii = centres(ratio, number)
        if (np.diff(x) < radii[1:] + radii[:-1]).all():
            return number
        number += 2


def _positions(first: float, n: int, a: float, b: float) -> np.ndarray:
    """x_0..x_n from d_1 by eqs 4.8, 4.10 and 4.15; a position beyond the tip has no height."""
    x, distance = np.zeros(n + 1), first
    height = b
    for i in range(1, n + 1):
        x[i] = x[i - 1] + distance
        here = b * math.sqrt(max(1.0 - (x[i] / a) ** 2, 0.0))
        distance *= here / height if height else 0.0
        height = here
    return x


def prolate(ratio: float, sub_spheres: int, name: str = "") -> MultiSphere:
    """A prolate spheroid of an equal-volume radius of 1 m, its long axis along x.

    ratio: a/b above 1; sub_spheres: odd, at least 3.
    """
    a, b = axes(ratio)
    half, radii = centres(ratio, sub_spheres)
    offsets = np.zeros((sub_spheres, 3))
    offsets[:, 0] = np.concatenate([-half[:0:-1], half])
    radii = np.concatenate([radii[:0:-1], radii])
    volume = 4.0 / 3.0 * math.pi * a * b**2
    bent = math.sqrt(1.0 - (b / a) ** 2)
    sphere = unit_sphere()
    return MultiSphere(
        name=name or f"prolate:{ratio:g}",
        kind="prolate",
        offsets=offsets,
        radii=radii,
        volume=volume,
        area=2.0 * math.pi * b**2 * (1.0 + a / (b * bent) * math.asin(bent)),
        inertia=volume / 5.0 * np.array([2 * b**2, a**2 + b**2, a**2 + b**2]),
        surface=Surface(sphere.vertices * [a, b, b], sphere.triangles),
        arrangement="row",
        surface_error=_gap(a, b, offsets, radii),
    )


def _gap(a: float, b: float, offsets: np.ndarray, radii: np.ndarray) -> float:
    """Depth of the deepest groove between the sub-spheres, which all lie inside [m].

    By the chords of the quarter ellipse, and what the ellipse rises above them: its curvature is
    at most a/b^2 and a chord of length s cuts off at most s^2 a/(8 b^2).
    """
    t = np.linspace(0.0, 0.5 * math.pi, _PIECES + 1)
    points = np.stack([a * np.cos(t), b * np.sin(t), np.zeros_like(t)], axis=1)
    chords = np.stack([points[:-1], points[1:]], axis=1)
    longest = float(np.linalg.norm(points[1:] - points[:-1], axis=1).max())
    growth = np.empty((_PIECES, len(radii)))
    needed_growth(chords, offsets, radii, growth)
    return float(growth.min(axis=1).max()) + longest**2 * a / (8.0 * b**2)


def _build(numbers: Numbers, sub_spheres: int | None, tolerance: float | None) -> MultiSphere:
    (ratio,) = numbers
    if ratio == 1.0:
        return sphere(1.0)
    make, fewest = partial(prolate, ratio), fewest_sub_spheres(ratio)
    return counted("prolate", make, fewest, 2, USUAL_SUB_SPHERES, sub_spheres, tolerance)


FAMILY = Family("prolate:1.5", _build, values=(Value("aspect ratio a/b", 1.0, 10.0),))
