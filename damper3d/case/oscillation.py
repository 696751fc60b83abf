"""Radius of the sphere that oscillates on its contact as fast as a multi-sphere particle does.

Rayleigh's step (thesis, eq. 3.31) is a part of the time that a sphere stays in contact: by Hertz
both go as its radius. A contact of a multi-sphere particle carries all of its mass, and
lasts as (m^2/R)^(1/5) (eq. 5.10): a small sub-sphere of a heavy particle stays longer than a large
one. What makes contacts shorter is that several act at once, and that the particle also rotates. So
the limit is that of the swiftest oscillation (contact/timestep.py) of the particle on all its
contacts with a flat wall together, over the directions in which it can meet one, at the energy that
presses the sphere of the same volume as deep as Hertz's law may hold. It is as many Rayleigh steps
of that sphere as that one, on its own contact, oscillates faster or slower. Moduli and density drop
out.
"""

import numpy as np

from damper3d.shapes.multisphere import MultiSphere
from damper3d.shapes.surfaces.surface import normals_and_areas

DEEPEST = 0.05  # overlap over radius: Hertz's law is for small ones
_CELL = 0.2  # by which the directions differ that are looked at: some four hundred
_NEWTON_STEPS = 12  # from above on a convex function: to the last digits


def equivalent_sphere_radius(particle: MultiSphere, tangential: float) -> float:
    """Radius of the sphere that oscillates as fast on a flat wall [m]; of a sphere its own.

    tangential is kt/kn of the contact law [-].
    """
    if particle.is_sphere:
        return particle.smallest_radius
    unit = particle.scaled(1.0 / particle.equal_volume_radius)
    normals = _normals(unit)
    heights = normals @ unit.offsets.T + unit.radii
    gaps = heights.max(axis=1)[:, None] - heights
    roots = np.sqrt(unit.radii * np.maximum(_depths(gaps, unit.radii) - gaps, 0.0))
    sphere = np.sqrt(DEEPEST) * max(1.5, 3.5 * tangential)  # as 1/m and 1/m + r^2/I of a sphere
    swiftest = _highest(normals, roots, unit, tangential).max()
    return particle.equal_volume_radius * float(np.sqrt(sphere / swiftest))


def _normals(unit: MultiSphere) -> np.ndarray:
    """Outward normals of the surface (d, 3), of each cell of directions its largest triangle's."""
    normals, areas = normals_and_areas(unit.surface.corners)
    normals = normals[np.argsort(-areas, kind="stable")]
    return normals[np.unique(np.round(normals / _CELL), axis=0, return_index=True)[1]]


def _depths(gaps: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Overlap (d, 1) of the deepest sub-sphere where all together hold what one sphere would.

    Each holds sqrt(R) overlap^2.5, but for the same factor, and the rigid wall meets sphere s by
    gaps (d, k) later than the first.
    """
    first = radii[np.argmin(gaps, axis=1)]
    depth = (DEEPEST * first**-0.2)[:, None]  # which the first would need alone
    for _ in range(_NEWTON_STEPS):
        overlap = np.maximum(depth - gaps, 0.0)
        force = np.sqrt(radii) * overlap * np.sqrt(overlap)
        held = (force * overlap).sum(axis=1, keepdims=True)
        depth = depth - (held - DEEPEST**2.5) / (2.5 * force.sum(axis=1, keepdims=True))
    return depth


def _highest(
    normals: np.ndarray, roots: np.ndarray, unit: MultiSphere, tangential: float
) -> np.ndarray:
    """Largest eigenvalue (d,) of M^-1/2 J^T k J M^-1/2 of the contacts, for a particle of mass one.

    Contact s has the springs 1.5 roots[:, s] along the normal (the tangent of Hertz's force) and
    tangential roots[:, s] in both directions across, but for the same factor. With their sum
    K = tangential + (1.5 - tangential) n n^T and the arm p, J^T k J = [K, -K P; P K, -P K P],
    P the cross product with p.
    """
    n = normals
    spring = tangential * np.eye(3) + (1.5 - tangential) * n[:, :, None] * n[:, None, :]
    arms = unit.offsets + unit.radii[:, None] * n[:, None, :]  # (d, k, 3)
    rotations = np.cross(arms[:, :, None, :], np.eye(3)) / np.sqrt(unit.inertia / unit.volume)
    rates = np.concatenate(  # (d, k, 3, 6) of the contact point, from those of the particle
        [np.broadcast_to(np.eye(3), rotations.shape), rotations], axis=3
    )
    matrix = np.einsum("dk,dkai,dab,dkbj->dij", roots, rates, spring, rates, optimize=True)
    return np.linalg.eigvalsh(matrix)[:, -1]
