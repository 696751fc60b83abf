"""A smooth shape with its mass properties, and the particle that a filling makes of it."""

from typing import NamedTuple

import numpy as np

from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.surfaces.filling import MOST_SUB_SPHERES, Filler
from damper3d.shapes.surfaces.surface import Surface
from granulab.errors import InputError

# Of the equal-volume radius: with it an oblate spheroid of 0.7 takes about as many sub-spheres as a
# prolate one of the thesis (docs/damper/shapes.md).
USUAL_TOLERANCE = 0.02
LEAST_TOLERANCE = 1e-3  # the triangles that stand for curved surfaces are not finer


class Solid(NamedTuple):
    """A shape of an equal-volume radius of 1 m about its centroid, in its principal axes."""

    surface: Surface
    flatness: float  # how far the true surface rises above the triangles [m]
    volume: float  # [m3]
    area: float  # [m2]
    inertia: np.ndarray  # (3,) principal moments over density [m5]


def filled(
    solid: Solid, kind: str, sub_spheres: int | None, tolerance: float | None, name: str = ""
) -> MultiSphere:
    """The particle by a filling: of at most so many sub-spheres, or by its surface error.

    tolerance: over the equal-volume radius [-]; left out, as sub_spheres, it is the usual one.
    Raises InputError where that takes too many sub-spheres.
    """
    if sub_spheres is not None:
        check_number(kind, sub_spheres, 1)
    within = checked(tolerance)
    filler = Filler(solid.surface.corners, solid.volume, solid.flatness)
    if sub_spheres is not None:
        filling = filler.by_number(sub_spheres)
    else:
        filling = filler.by_tolerance(within)
    return MultiSphere(
        name=name,
        kind=kind,
        offsets=filling.centres,
        radii=filling.radii,
        volume=solid.volume,
        area=solid.area,
        inertia=solid.inertia,
        surface=solid.surface,
        arrangement="any" if len(filling.radii) > 1 else "ball",
        surface_error=filling.surface_error,
    )


def checked(tolerance: float | None) -> float:
    """The tolerance, or the usual one; InputError where it is out of range."""
    if tolerance is None:
        return USUAL_TOLERANCE
    if not LEAST_TOLERANCE <= tolerance <= 0.5:
        raise InputError(
            f"tolerance = {tolerance:g}: must be from {LEAST_TOLERANCE:g} to 0.5 of the "
            f"equal-volume radius, such as {USUAL_TOLERANCE:g}"
        )
    return tolerance


def check_number(kind: str, sub_spheres: int, fewest: int) -> None:
    """Raise InputError where so many sub-spheres cannot be."""
    if not fewest <= sub_spheres <= MOST_SUB_SPHERES:
        raise InputError(
            f"sub_spheres = {sub_spheres} of {kind!r}: must be from {fewest} to {MOST_SUB_SPHERES}"
        )
