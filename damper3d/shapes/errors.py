"""Relative errors of volume, surface and section that sub-spheres make of a shape."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.particle import Particle, particle_of
from damper3d.shapes.surfaces import union
from granulab.errors import InputError

# Numbers and tolerances between which the error curves of a shape run; those of figs 4.7 and 4.11
# run to a hundred sub-spheres or so.
_NUMBERS = (3, 5, 7, 9, 13, 17, 25, 35, 51, 71, 101, 151, 201)
_TOLERANCES = (0.2, 0.14, 0.1, 0.07, 0.05, 0.035, 0.025, 0.0175, 0.0125)


class Section(NamedTuple):
    """Section of the sub-spheres, or of the shape that they stand for."""

    area: float  # [m2]
    perimeter: float  # [m]


@dataclass(frozen=True)
class Errors:
    """Relative errors of all sub-spheres together against the smooth shape [-]."""

    sub_spheres: int
    surface: float  # bound on the distance of the two surfaces over the equal-volume radius
    volume: float
    area: float
    section_area: float | None  # eqs 4.16-4.19, 4.31; None: the thesis has none for the shape
    section_perimeter: float | None  # eqs 4.20-4.23, 4.32


def errors_of(particle: MultiSphere) -> Errors:
    """Errors of a particle; volume and area are exact for rows and rings, else to some 1e-4."""
    volume, area = _together(particle)
    section, exact = _sections(particle)
    return Errors(
        sub_spheres=len(particle.radii),
        surface=particle.surface_error / particle.equal_volume_radius,
        volume=volume / particle.volume - 1.0,
        area=area / particle.area - 1.0,
        section_area=section.area / exact.area - 1.0 if section and exact else None,
        section_perimeter=section.perimeter / exact.perimeter - 1.0 if section and exact else None,
    )


def _together(particle: MultiSphere) -> tuple[float, float]:
    """Volume [m3] and surface [m2] of the sub-spheres."""
    offsets, radii = particle.offsets, particle.radii
    if particle.arrangement == "row":
        return union.of_row(offsets[:, 0], radii)
    if particle.arrangement == "ring":
        return union.of_ring(float(np.linalg.norm(offsets[0])), float(radii[0]), len(radii))
    return union.of_any(offsets, radii)


def _sections(particle: MultiSphere) -> tuple[Section | None, Section | None]:
    offsets, radii = particle.offsets, particle.radii
    if particle.arrangement == "row":
        half = slice(len(radii) // 2, None)
        a, b = float(offsets[-1, 0] + radii[-1]), float(radii.max())
        return (prolate_spheres(offsets[half, 0], radii[half]), prolate_exact(a, b))
    if particle.arrangement == "ring":
        a, b = float(np.linalg.norm(offsets[0])), float(radii[0])
        return toroid_spheres(a, b, len(radii)), toroid_exact(a, b)
    return None, None


def curve(wanted: Particle, least: int) -> list[Errors]:
    """Errors against the number of sub-spheres, of the same shape; rising numbers.

    least: of sub-spheres in the last one, where the shape takes a tolerance.
    """
    found: list[Errors] = []
    if wanted.kind in ("prolate", "toroid"):
        for number in _NUMBERS:
            try:
                particle = particle_of(replace(wanted, sub_spheres=number, tolerance=None))
            except InputError:  # fewer than hang together
                continue
            found.append(errors_of(particle))
        return found
    for tolerance in _TOLERANCES:
        try:
            particle = particle_of(replace(wanted, sub_spheres=None, tolerance=tolerance))
        except InputError:  # it takes none, or more sub-spheres than there may be
            break
        if not found or len(particle.radii) > found[-1].sub_spheres:
            found.append(errors_of(particle))
        if len(particle.radii) >= least:
            break
    return found or [errors_of(particle_of(wanted))]


def prolate_spheres(x: np.ndarray, radii: np.ndarray) -> Section:
    """Eqs 4.16-4.23: of the spheres at x_0 = 0 < x_1 < ... (n + 1,) with radii R_i (n + 1,) [m]."""
    meet = 0.5 * (x[1:] + x[:-1] + (radii[:-1] ** 2 - radii[1:] ** 2) / np.diff(x))
    height = np.sqrt(radii[:-1] ** 2 - (meet - x[:-1]) ** 2)
    # of each sphere: the angle at its centre that is left of its two meeting points, and the
    # triangles under these
    to_left, to_right = x[1:] - meet, meet - x[:-1]
    angle = np.full(len(x), math.pi)
    angle[0] = 0.5 * math.pi
    angle[:-1] -= np.arctan2(height, to_right)
    angle[1:] -= np.arctan2(height, to_left)
    triangles = np.zeros(len(x))
    triangles[:-1] += 0.5 * height * to_right
    triangles[1:] += 0.5 * height * to_left
    area = np.sum(0.5 * radii**2 * angle + triangles)
    return Section(float(area), float(np.sum(radii * angle)))


def prolate_exact(a: float, b: float) -> Section:
    """Eq. 4.24 of half axes a, b [m], and the perimeter by the complete elliptic integral.

    Eq. 4.25 (Ramanujan's) is too small by 3e-5 at a/b = 3 and by 3e-4 at 6: as much as
    some 200 sub-spheres are off.
    """
    from scipy.special import ellipe

    return Section(math.pi * a * b / 4, float(a * ellipe(1.0 - (b / a) ** 2)))


def toroid_spheres(a: float, b: float, number: int) -> Section:
    """Eqs 4.31, 4.32 of equal spheres of the tube's radius b on the ring of radius a [m]."""
    d = 2.0 * a * math.sin(math.pi / number)  # eq. 4.30
    lens = 2.0 * b**2 * math.acos(d / (2.0 * b)) - d * math.sqrt(b**2 - d**2 / 4.0)
    # the argument of eq. 4.32 rises to one and falls again: its inverse sine is an inverse cosine
    angle = math.pi - 2.0 * math.acos(d / (2.0 * b))
    return Section(number * (math.pi * b**2 - lens), 2.0 * number * b * angle)


def toroid_exact(a: float, b: float) -> Section:
    """Eqs 4.33, 4.34 of the ring's radius a and the tube's radius b [m]."""
    return Section(4.0 * math.pi * a * b, 4.0 * math.pi * a)
