"""Cylinders with rounded edges, round the z axis: a smaller cylinder and all within one distance.

The small cylinder has the radius p and the height h, the distance is r. Volume and surface are
Steiner's: V + S r + M r^2 + (4/3) pi r^3, S + 2 M r + 4 pi r^2 with M = pi h + pi^2 p. The moments
are integrals of the radius of the sections, its fourth power and its square times z^2, which are
trigonometric polynomials at the rounded edges.
"""

import math

import numpy as np

from damper3d.shapes.family import Family, Numbers, Value
from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.surfaces.solid import Solid, filled
from damper3d.shapes.surfaces.surface import revolved
from granulab.errors import InputError

_AROUND = 96  # corners of the triangles round the axis
_ARC = 12  # pieces of a rounded edge
_NODES = 24  # of the Gauss rule for the moments, which is exact to rounding then


def cylinder(slenderness: float, rounding: float) -> Solid:
    """A rounded cylinder of an equal-volume radius of 1 m.

    slenderness: length over diameter; rounding: radius of the edges over that of the cylinder,
    at most 1 and at most the slenderness. Both 1: a sphere.
    """
    core = np.array([1.0 - rounding, 2.0 * (slenderness - rounding), rounding])
    radius = (4.0 / 3.0 * math.pi / _volume(*core)) ** (1 / 3)
    p, h, r = radius * core
    flank, bend = 2.0 * math.pi * p * (p + h), math.pi * h + math.pi**2 * p
    profile = _profile(p, h, r)
    rises = [radius * (1.0 - math.cos(math.pi / _AROUND)), r * (1.0 - math.cos(math.pi / 4 / _ARC))]
    return Solid(
        surface=revolved(profile, _AROUND),
        flatness=sum(rises),
        volume=_volume(p, h, r),
        area=flank + 2.0 * bend * r + 4.0 * math.pi * r**2,
        inertia=_inertia(p, h, r),
    )


def _volume(p: float, h: float, r: float) -> float:
    surface, bend = 2.0 * math.pi * p * (p + h), math.pi * h + math.pi**2 * p
    return math.pi * p**2 * h + surface * r + bend * r**2 + 4.0 / 3.0 * math.pi * r**3


def _inertia(p: float, h: float, r: float) -> np.ndarray:
    """Moments of discs of radius R(z): pi R^4/2 round the axis, pi R^4/4 + pi R^2 z^2 across."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    t, dt = math.pi / 4 * (nodes + 1.0), math.pi / 4 * weights
    section, height = p + r * np.cos(t), 0.5 * h + r * np.sin(t)
    dz = r * np.cos(t) * dt
    fourth = h * (p + r) ** 4 + 2.0 * np.sum(section**4 * dz)
    tilt = h**3 / 12.0 * (p + r) ** 2 + 2.0 * np.sum(section**2 * height**2 * dz)
    across = math.pi * (0.25 * fourth + tilt)
    return np.array([across, across, 0.5 * math.pi * fourth])


def _profile(p: float, h: float, r: float) -> np.ndarray:
    """Radius and height (k, 2) [m] of half a section, from the lower pole to the upper."""
    t = np.linspace(-0.5 * math.pi, 0.0, _ARC + 1)
    step = 2.0 * math.pi * (p + r) / _AROUND
    flat = np.linspace(0.0, p, max(math.ceil(p / step), 1), endpoint=False)
    lower = [np.stack([flat, np.full(len(flat), -0.5 * h - r)], 1)] if p > 0.0 else []
    lower.append(np.stack([p + r * np.cos(t), -0.5 * h + r * np.sin(t)], 1))
    side = np.linspace(-0.5 * h, 0.5 * h, max(math.ceil(h / step), 1) + 1)[1:-1]
    below = np.concatenate(lower)
    middle = np.stack([np.full(len(side), p + r), side], 1)
    above = below[::-1] * [1.0, -1.0]
    return np.concatenate([below, middle, above if h > 0.0 else above[1:]])


def _build(numbers: Numbers, sub_spheres: int | None, tolerance: float | None) -> MultiSphere:
    slenderness, rounding = numbers
    if rounding > slenderness:
        raise InputError(
            f"shape = 'cylinder:{slenderness:g},{rounding:g}': the rounding must be at most the "
            f"length over the diameter, {slenderness:g}"
        )
    return filled(cylinder(*numbers), "cylinder", sub_spheres, tolerance)


FAMILY = Family(
    "cylinder:1.5,0.2",
    _build,
    values=(Value("length over diameter", 0.2, 10.0), Value("rounding", 0.1, 1.0)),
)
