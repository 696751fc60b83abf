"""The drawn surface of overlapping spheres: closed, on the spheres, of nearly their volume."""

import numpy as np
import pytest

from damper3d.shapes.particle import parse_particle
from damper3d.shapes.surfaces.skin import OF_A_CELL, skin
from damper3d.shapes.surfaces.union import of_any

CELLS = 20


@pytest.fixture(scope="module", params=["prolate:1.5", "toroid:0.2", "oblate:0.7"])
def particle(request):
    return parse_particle(request.param, 3.8e-3)


def test_skin_is_closed_and_faces_outwards(particle):
    """Each edge is passed once each way; nearly all triangles look the way of their normals."""
    found = skin(particle.offsets, particle.radii, CELLS)
    edges = np.concatenate([found.triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    passed = set(map(tuple, edges))
    assert len(passed) == len(edges)
    assert all((b, a) in passed for a, b in passed)
    corners = found.corners[found.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert ((across * found.normals[found.triangles[:, 0]]).sum(axis=1) > 0).mean() > 0.99


def test_corners_of_the_skin_lie_on_the_spheres(particle):
    """On the nearest surface after three steps towards it: to a thousandth of a cell."""
    found = skin(particle.offsets, particle.radii, CELLS)
    away = np.linalg.norm(found.corners[:, None] - particle.offsets, axis=2) - particle.radii
    cell = np.ptp(found.corners, axis=0).max() / CELLS
    assert np.abs(away.min(axis=1)).max() < 1e-3 * cell
    np.testing.assert_allclose(np.linalg.norm(found.normals, axis=1), 1.0, rtol=1e-12)


def test_volume_of_the_skin_is_that_of_the_union(particle):
    """By the divergence theorem. Chords cut off (h/R)^2 of it: some 2 % of a grid of 20 cells."""
    found = skin(particle.offsets, particle.radii, CELLS)
    a, b, c = found.corners[found.triangles].transpose(1, 0, 2)
    volume = (a * np.cross(b, c)).sum() / 6
    assert volume == pytest.approx(of_any(particle.offsets, particle.radii)[0], rel=0.02)


def test_triangles_are_as_many_as_a_page_reckons(particle):
    """Their number goes with the square of the cells; to a third for these shapes."""
    for cells in (10, 20):
        n = len(skin(particle.offsets, particle.radii, cells).triangles)
        assert n == pytest.approx(OF_A_CELL * cells**2, rel=0.35)
