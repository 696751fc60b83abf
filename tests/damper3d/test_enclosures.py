"""Enclosures as bodies: walls, volumes, sizes and places of frustum, sphere, prism, polyhedron,
cells and cavity, against Monte Carlo, brute force and closed forms.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_cavities import box_of, cavity_of, ell, prism_of, round_rim

from damper3d.engine.enclosures import (
    Box,
    Cells,
    Enclosure,
    Frustum,
    HexagonalPrism,
    Polyhedron,
    Sphere,
    cylinder,
    nearest_of,
)

TETRAHEDRON = ((0.0, 0.0, 0.0), (0.03, 0.0, 0.0), (0.0, 0.03, 0.0), (0.0, 0.0, 0.03))
OCTAHEDRON = tuple((a, b, c, 0.01) for a in (1, -1) for b in (1, -1) for c in (1, -1))
ALL: dict[str, Enclosure] = {
    "cylinder": cylinder(0.03, 0.02),
    "box": Box(0.02, 0.03, 0.025),
    "frustum": Frustum(0.03, 0.016, 0.025),
    "funnel": Frustum(0.012, 0.03, 0.02),
    "sphere": Sphere(0.03),
    "prism": HexagonalPrism(0.03, 0.02),
    "tetrahedron": Polyhedron(vertices=TETRAHEDRON),
    "octahedron": Polyhedron(faces=OCTAHEDRON),
    "cells": Cells(Box(0.01, 0.012, 0.02), 3, 2, 0.001),
    "round cells": Cells(cylinder(0.01, 0.02), 2, 2, 0.001),
    "box of triangles": cavity_of(box_of(0.02, 0.015, 4, 0.5)),
    "L of triangles": cavity_of(prism_of(ell(0.03, 0.012), 0.02, (0.006, 0.006))),
}
EACH = pytest.mark.parametrize("enclosure", ALL.values(), ids=ALL.keys())
UPS = [np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), np.array([0.48, -0.64, 0.6])]
N = 40_000


def box_round(enclosure: Enclosure) -> tuple[np.ndarray, np.ndarray]:
    half = np.array([0.5 * enclosure.width, 0.5 * enclosure.depth, 0.0])
    return -half, half + np.array([0.0, 0.0, enclosure.height])


def inside(enclosure: Enclosure, points: np.ndarray) -> np.ndarray:
    """Which points (n, 3) of the box around it are in an enclosure."""
    return enclosure.clearance(points) > 0.0


def share(found: np.ndarray, volume: float, enclosure: Enclosure) -> None:
    """The share of N points in the box is that of a volume, to four standard deviations."""
    low, high = box_round(enclosure)
    expected = volume / np.prod(high - low)
    sigma = math.sqrt(max(expected * (1.0 - expected), 1.0 / N) / N)
    assert found.mean() == pytest.approx(expected, abs=4.0 * sigma)


@EACH
def test_volume_is_that_of_random_points(enclosure):
    points = np.random.default_rng(1).uniform(*box_round(enclosure), (N, 3))
    found = inside(enclosure, points)
    share(found, enclosure.volume, enclosure)
    for up in UPS:
        for part in (0.2, 0.5, 0.9):
            level = float(np.quantile(points @ up, part))
            share(found & (points @ up < level), enclosure.volume_below(up, level), enclosure)


@EACH
def test_the_box_around_it_touches_it_on_all_sides(enclosure):
    """And its lowest point, in any direction, is that of its drawn corners.

    Those stand for round walls: 48 on a circle miss by its sagitta, at most R (1 - cos(pi/48)).
    """
    corners = np.concatenate([points for _, points in enclosure.polygons])
    low, high = box_round(enclosure)
    assert corners.min(axis=0) == pytest.approx(low, abs=1e-15)
    assert corners.max(axis=0) == pytest.approx(high, abs=1e-15)
    sagitta = 0.5 * max(enclosure.width, enclosure.depth) * (1.0 - math.cos(math.pi / 48))
    for up in UPS:
        miss = float((corners @ up).min()) - enclosure.lowest(up)
        assert -1e-15 <= miss <= sagitta


OUTWARD = [name for name, each in ALL.items() if each.shape not in ("cylinder", "box", "cells")]


@pytest.mark.parametrize("name", OUTWARD)
def test_drawn_walls_face_outwards_and_close(name):
    """Their volume by Gauss's theorem is that of the void; of 48 edges to a circle a little less.

    What is drawn of a round one holds one that is smaller by cos(pi/48) in the radius of a frustum,
    and, of a sphere, by that twice in each of three directions.
    """
    enclosure, flux = ALL[name], 0.0
    for _, points in enclosure.polygons:
        across = np.cross(points[1:-1] - points[0], points[2:] - points[0]).sum(axis=0)
        flux += 0.5 * float(points[0] @ across)
    least = math.cos(math.pi / 48) ** {"frustum": 2, "sphere": 6}.get(enclosure.shape, 0)
    assert least - 1e-9 <= flux / (3.0 * enclosure.volume) <= 1.0 + 1e-9


@EACH
def test_the_largest_sphere_fits_and_a_larger_one_does_not(enclosure):
    """Its centre is looked for among random points: none is farther from all walls.

    Of a cavity it is found on a grid, to a thousandth.
    """
    points = np.random.default_rng(2).uniform(*box_round(enclosure), (N, 3))
    planes = points @ enclosure.planes[:, :3].T - enclosure.planes[:, 3]
    away = np.minimum(enclosure.clearance(points), planes.min(axis=1, initial=np.inf))
    found = 2.0 * float(away.max())
    # A point of N is within (volume of the box / N)^(1/3) of the best, its distance likewise.
    low, high = box_round(enclosure)
    spread = 4.0 * float(np.cbrt(np.prod(high - low) / N))
    assert enclosure.narrowest * 1.001 >= found >= enclosure.narrowest - spread
    assert enclosure.narrowest_place


@EACH
def test_a_line_through_it_ends_at_walls(enclosure):
    for along in UPS:
        for way in enclosure.through(along):
            end = enclosure.middle + (1.0 - 1e-6) * way * along
            beyond = enclosure.middle + (1.0 + 1e-6) * way * along
            planes = enclosure.planes[:, :3] @ np.stack([end, beyond], 1) - enclosure.planes[:, 3:]
            away = np.minimum(enclosure.clearance(np.stack([end, beyond])),
                              planes.min(axis=0, initial=np.inf))  # fmt: skip
            assert away[0] > 0.0
            assert away[1] <= 0.0


CURVED = [name for name, each in ALL.items() if len(each.wall_names) > len(each.planes)]


@pytest.mark.parametrize("name", CURVED)
def test_the_nearest_point_lies_on_the_wall_and_no_other_is_nearer(name):
    """The point at the returned distance along the returned direction has the distance zero; and
    the least distance of random points of the walls is larger.
    """
    enclosure, rng = ALL[name], np.random.default_rng(3)
    surface, curved = enclosure.surface, len(enclosure.wall_names) - len(enclosure.planes)
    nearest = nearest_of(type(surface))
    points = rng.uniform(*box_round(enclosure), (400, 3))
    points = points[inside(enclosure, points)][:60]
    on_walls = [
        corners.mean(axis=0)
        for wall, corners in enclosure.polygons
        if wall not in ("bottom", "top")
    ]
    for x in points:
        found = [nearest(surface, wall, *x) for wall in range(curved)]
        distance, direction, mean_radius = min(found, key=lambda one: one[0])
        if distance == getattr(surface, "reach", None):
            continue  # farther than a cavity's cells tell
        assert np.linalg.norm(direction) == pytest.approx(1.0, abs=1e-12)
        assert distance == pytest.approx(enclosure.clearance(x[None])[0], abs=1e-12)
        foot = x + (1.0 - 1e-9) * distance * np.array(direction)
        assert min(nearest(surface, w, *foot)[0] for w in range(curved)) == pytest.approx(
            0.0, abs=2e-9 * max(distance, 1e-3)
        )
        # Drawn pieces lie inside of round walls by the sagitta, R (pi/48)^2/2 at most.
        sagitta = 0.0 if mean_radius == np.inf else 2.2e-3 * enclosure.width
        assert distance <= np.linalg.norm(on_walls - x, axis=1).min() + sagitta


@given(st.integers(0, 2**32 - 1), st.integers(4, 12))
@settings(max_examples=20, deadline=None)
def test_a_polyhedron_is_the_same_by_its_corners_and_by_its_faces(seed, n):
    """Random points on a sphere are corners of their hull; the volume is that of scipy's."""
    from scipy.spatial import ConvexHull

    points = np.random.default_rng(seed).normal(size=(n, 3))
    points *= 0.02 / np.linalg.norm(points, axis=1)[:, None]
    hull = ConvexHull(points)
    if hull.volume < 1e-7 or Polyhedron(vertices=_rows(points)).narrowest < 1e-4:
        return  # flat ones are refused
    by_corners = Polyhedron(vertices=_rows(points))
    outward = np.column_stack([-by_corners.planes[:, :3], -by_corners.planes[:, 3]])
    by_faces = Polyhedron(faces=_rows(outward))
    for made in (by_corners, by_faces):
        assert made.volume == pytest.approx(hull.volume, rel=1e-9)
        assert (made.width, made.depth, made.height) == pytest.approx(np.ptp(points, axis=0))
        assert len(made.planes) == len(made.polygons) == len(made.wall_names)
    assert by_faces.narrowest == pytest.approx(by_corners.narrowest, rel=1e-6)


def _rows(array: np.ndarray) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in array.tolist())


@pytest.mark.parametrize(
    ("enclosure", "volume"),
    [
        (ALL["frustum"], math.pi * 0.025 / 12 * (0.03**2 + 0.03 * 0.016 + 0.016**2)),
        (ALL["sphere"], math.pi / 6 * 0.03**3),
        (ALL["prism"], math.sqrt(3) / 2 * 0.03**2 * 0.02),
        (ALL["tetrahedron"], 0.03**3 / 6),
        (ALL["octahedron"], 4 / 3 * (math.sqrt(3) * 0.01) ** 3),
        (ALL["cells"], 6 * 0.01 * 0.012 * 0.02),
        (ALL["L of triangles"], 0.02 * (0.03**2 - 0.018**2)),
    ],
)
def test_volumes_in_closed_form(enclosure, volume):
    assert enclosure.volume == pytest.approx(volume, rel=1e-9)


def test_a_prism_of_many_sides_is_a_cylinder():
    """Of the same volume by construction; the largest sphere in it is held by bottom and top."""
    prism, exact = cavity_of(prism_of(round_rim(0.03, 96), 0.02)), cylinder(0.03, 0.02)
    assert prism.volume == pytest.approx(exact.volume, rel=1e-9)
    assert prism.narrowest == pytest.approx(exact.narrowest, rel=1e-3)
