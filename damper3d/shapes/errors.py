"""What sub-spheres make of a shape: relative errors of volume, surface and section."""

from dataclasses import dataclass, replace

import numpy as np

from damper3d.shapes.cluster import Cluster
from damper3d.shapes.particle import Particle, particle_of
from damper3d.shapes.surfaces import sections, union
from granulab.errors import InputError

# Numbers and tolerances between which the error curves of a shape run; those of figs 4.7 and 4.11
# run to a hundred sub-spheres or so.
_NUMBERS = (3, 5, 7, 9, 13, 17, 25, 35, 51, 71, 101, 151, 201)
_TOLERANCES = (0.2, 0.14, 0.1, 0.07, 0.05, 0.035, 0.025, 0.0175, 0.0125)


@dataclass(frozen=True)
class Errors:
    """Of sub-spheres taken together, over what the smooth shape has, less one [-]."""

    sub_spheres: int
    surface: float  # bound on the distance of the two surfaces over the equal-volume radius
    volume: float
    area: float
    section_area: float | None  # eqs 4.16-4.19, 4.31; None: the thesis has none for the shape
    section_perimeter: float | None  # eqs 4.20-4.23, 4.32


def errors_of(particle: Cluster) -> Errors:
    """Of a particle; volume and area are exact for rows and rings, else good to some 1e-4."""
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


def _together(particle: Cluster) -> tuple[float, float]:
    """Volume [m3] and surface [m2] of the sub-spheres."""
    offsets, radii = particle.offsets, particle.radii
    if particle.arrangement == "row":
        return union.of_row(offsets[:, 0], radii)
    if particle.arrangement == "ring":
        return union.of_ring(float(np.linalg.norm(offsets[0])), float(radii[0]), len(radii))
    return union.of_any(offsets, radii)


def _sections(particle: Cluster) -> tuple[sections.Section | None, sections.Section | None]:
    offsets, radii = particle.offsets, particle.radii
    if particle.arrangement == "row":
        half = slice(len(radii) // 2, None)
        a, b = float(offsets[-1, 0] + radii[-1]), float(radii.max())
        return (
            sections.prolate_spheres(offsets[half, 0], radii[half]),
            sections.prolate_exact(a, b),
        )
    if particle.arrangement == "ring":
        a, b = float(np.linalg.norm(offsets[0])), float(radii[0])
        return sections.toroid_spheres(a, b, len(radii)), sections.toroid_exact(a, b)
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
        particle = particle_of(replace(wanted, sub_spheres=None, tolerance=tolerance))
        if not found or len(particle.radii) > found[-1].sub_spheres:
            found.append(errors_of(particle))
        if len(particle.radii) >= least:
            break
    return found
