"""Fillings: the surface error that they state is a bound; volume, area, inertia of the shapes."""

import math

import numpy as np
import pytest
import trimesh
from fuzzing import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from damper3d.shapes import prolate, toroid
from damper3d.shapes.cylinder import cylinder
from damper3d.shapes.oblate import oblate
from damper3d.shapes.particle import parse_particle
from damper3d.shapes.superquadric import superquadric
from damper3d.shapes.surfaces import union
from damper3d.shapes.surfaces.filling import fine
from damper3d.shapes.surfaces.mesh_data import mass_of
from damper3d.shapes.surfaces.surface import area_of, unit_sphere


def on_spheres(centres: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Points of the surface of overlapping spheres (n, 3) [m]."""
    ball = unit_sphere(3).vertices
    points = (centres[:, None] + radii[:, None, None] * ball).reshape(-1, 3)
    inside = np.zeros(len(points), bool)
    for centre, radius in zip(centres, radii, strict=True):
        inside |= np.linalg.norm(points - centre, axis=1) < radius * (1.0 - 1e-9)
    return points[~inside]


def gap(points: np.ndarray, centres: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Distance of points to the nearest sphere's surface, negative inside (n,) [m]."""
    apart = np.linalg.norm(points[:, None] - centres, axis=2) - radii
    return apart.min(axis=1)


@pytest.mark.parametrize(("ratio", "tolerance"), [(0.7, None), (0.85, 0.01)])
def test_oblates_keep_their_surface_error_volume_and_area(ratio, tolerance):
    """The bound at points of the true spheroid, and of the spheres; volume and area within 2 %.

    Points of the spheroid: none lies deeper than the bound. Of the spheres: none stands out more;
    the distance to x^2/a^2 + r^2/b^2 = 1 is at least that along the gradient of its left side, by
    which it is estimated from below: f/|grad f| with the smaller of the two half axes, at f > 0.
    """
    particle = parse_particle(f"oblate:{ratio}", 1.0, tolerance=tolerance)
    centres, radii, bound = particle.offsets, particle.radii, particle.surface_error
    assert bound <= (0.02 if tolerance is None else tolerance)
    a, b = prolate.axes(ratio)
    assert gap(unit_sphere(4).vertices * [a, b, b], centres, radii).max() <= bound
    outside = on_spheres(centres, radii)
    size = np.linalg.norm(outside / [a, b, b], axis=1)
    # the ray through a point meets the spheroid at 1/size of its length: farther than the foot is
    beyond = np.linalg.norm(outside, axis=1) * (1.0 - 1.0 / size)
    normal = outside / np.square([a, b, b])
    along = np.einsum("nx,nx->n", outside, normal) / np.linalg.norm(normal, axis=1)
    cosine = along / np.linalg.norm(outside, axis=1)
    assert (beyond * cosine).max() <= bound * 1.02  # the normal turns a little on the way
    volume, area = union.of_any(centres, radii)
    assert volume == pytest.approx(particle.volume, rel=0.02)
    assert area == pytest.approx(particle.area, rel=0.02)


def test_more_sub_spheres_are_nearer_to_the_shape():
    """And a number that is given is kept to."""
    found = [parse_particle("oblate:0.7", sub_spheres=n) for n in (9, 40)]
    assert [len(p.radii) <= n for p, n in zip(found, (9, 40), strict=True)] == [True] * 2
    errors = [p.surface_error for p in found]
    assert errors[1] < 0.5 * errors[0]


def test_a_filling_is_the_same_every_time():
    from damper3d.shapes.surfaces.solid import filled

    first, second = (filled(oblate(0.8), "oblate", None, 0.1) for _ in range(2))
    assert np.array_equal(first.offsets, second.offsets)
    assert np.array_equal(first.radii, second.radii)


@pytest.mark.parametrize("k", range(3))
def test_volume_and_surface_of_spheres_in_any_direction(k):
    """Of a row and a ring by slices and caps; latitudes leave 7e-4 where bands are 1/50 wide."""
    row, ring = (
        np.roll(parse_particle(name, 1.0).offsets, k, 1) for name in ("prolate:2", "toroid:0.2")
    )
    x, radii = prolate.centres(2.0, 51)
    whole = np.concatenate([-x[:0:-1], x]), np.concatenate([radii[:0:-1], radii])
    assert union.of_any(row, whole[1]) == pytest.approx(union.of_row(*whole), rel=7e-4)
    a, b = toroid.radii_of(0.2)
    assert union.of_any(ring, np.full(50, b)) == pytest.approx(union.of_ring(a, b, 50), rel=7e-4)


@given(st.floats(0.2, 3.0), st.floats(0.01, 0.99))
@settings(deadline=None, max_examples=examples(30))
def test_two_spheres_lose_their_lens(radius, share):
    """lens = pi (R + r - d)^2 (d^2 + 2 d (R + r) - 3 (R - r)^2)/(12 d)."""
    d = abs(1.0 - radius) + share * (1.0 + radius - abs(1.0 - radius))
    wide = d**2 + 2.0 * d * (1.0 + radius) - 3.0 * (1.0 - radius) ** 2
    lens = math.pi * (1.0 + radius - d) ** 2 * wide / (12.0 * d)
    exact = 4 / 3 * math.pi * (1 + radius**3) - lens
    volume, _ = union.of_any(np.array([[0.0, 0, 0], [0, 0, d]]), np.array([1.0, radius]))
    assert volume == pytest.approx(exact, rel=1e-3)
    assert union.of_row(np.array([0.0, d]), np.array([1.0, radius]))[0] == pytest.approx(
        exact, rel=1e-9
    )


@pytest.mark.parametrize(
    ("solid", "tolerance"),
    [
        (oblate(0.5), 0.004), (superquadric(1.5, 0.7, 1.0, 1.0), 0.001),
        (superquadric(1.0, 1.0, 0.5, 0.5), 0.002), (superquadric(0.8, 1.3, 1.3, 0.6), 0.002),
        (cylinder(1.5, 0.2), 0.002), (cylinder(2.0, 1.0), 0.006), (cylinder(0.4, 0.3), 0.004),
    ],
)  # fmt: skip
def test_closed_forms_of_volume_area_and_inertia_are_those_of_the_surface(solid, tolerance):
    """Sums over the triangles, whose corners lie on the surface: they lack at most `tolerance`.

    It follows from the flatness, the depth of the triangles: 3 times it for the volume of a body of
    radius 1, 5 times for moments, which the tolerance rounds up.
    """
    mass = mass_of(solid.surface.corners)
    assert 5.0 * solid.flatness <= 10.0 * tolerance
    assert solid.volume == pytest.approx(4.0 / 3.0 * math.pi, rel=1e-9)
    assert mass.volume == pytest.approx(solid.volume, rel=tolerance)
    assert mass.area == pytest.approx(solid.area, rel=tolerance)
    assert np.diag(mass.inertia) == pytest.approx(solid.inertia, rel=2.0 * tolerance)
    assert mass.inertia == pytest.approx(np.diag(np.diag(mass.inertia)), abs=1e-12)
    assert mass.centroid == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("hole_ratio", [0.1, 0.4])
def test_closed_forms_of_a_toroid_are_those_of_its_surface(hole_ratio):
    """Volume, area and both moments over the mass; the triangles lack some per cent."""
    ring = toroid.toroid(hole_ratio, 50)
    mass = mass_of(ring.surface.corners)
    assert mass.volume == pytest.approx(ring.volume, rel=0.03)
    assert mass.area == pytest.approx(ring.area, rel=0.03)
    gyration = np.diag(mass.inertia) / mass.volume
    assert gyration == pytest.approx(ring.inertia / ring.volume, rel=0.03)


def test_limits_of_the_families_are_ellipsoids_capsules_and_spheres():
    """Exponents of one: V (b^2 + c^2)/5. Rounding of one: a ball, or a cylinder with two halves."""
    ellipsoid = superquadric(1.5, 0.7, 1.0, 1.0)
    scale = (1.05) ** (-1 / 3)
    a, b, c = scale, 1.5 * scale, 0.7 * scale
    wanted = ellipsoid.volume / 5.0 * np.array([b * b + c * c, c * c + a * a, a * a + b * b])
    assert ellipsoid.inertia == pytest.approx(wanted, rel=1e-12)
    ball = cylinder(1.0, 1.0)
    assert ball.area == pytest.approx(4.0 * math.pi, rel=1e-12)
    assert ball.inertia == pytest.approx(0.4 * ball.volume, rel=1e-12)
    capsule = cylinder(2.0, 1.0)
    r = (4.0 / 3.0 / (2.0 + 4.0 / 3.0)) ** (1 / 3)  # pi r^2 (2 r) + 4/3 pi r^3 = 4/3 pi
    axial = 0.5 * math.pi * r**4 * 2.0 * r + 0.4 * 4.0 / 3.0 * math.pi * r**5
    assert capsule.inertia[2] == pytest.approx(axial, rel=1e-12)
    assert capsule.area == pytest.approx(2.0 * math.pi * r * 2.0 * r + 4.0 * math.pi * r**2)


def test_finer_triangles_are_the_same_surface():
    corners = unit_sphere(1).corners
    pieces = fine(corners, 2000)
    assert len(pieces) > 1500
    assert area_of(pieces) == pytest.approx(area_of(corners), rel=1e-12)
    assert mass_of(pieces).volume == pytest.approx(mass_of(corners).volume, rel=1e-12)


@pytest.mark.parametrize("length", [10.0, 1000.0])
def test_long_triangles_are_cut_in_few_more_pieces_than_their_area_needs(length):
    """A bar of 1 mm x 1 mm; in triangles of its own form one of 1000 mm took a million pieces."""
    corners = trimesh.creation.box((1.0, 1.0, length)).triangles
    pieces = fine(corners, 2000)
    assert 1500 < len(pieces) < 20_000
    assert area_of(pieces) == pytest.approx(area_of(corners), rel=1e-12)
    assert mass_of(pieces).volume == pytest.approx(mass_of(corners).volume, rel=1e-12)
