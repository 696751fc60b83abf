"""Coarse-grained density and velocity keep mass and momentum, and are right up to the walls."""

import math
import shutil

import numpy as np
import pytest
import scenes
from hand_built import scene_of
from hypothesis import given
from hypothesis import strategies as st
from refusals import assert_refused
from small_silo import silo2d

from silo2d.case.outline import hopper, outline_from_polygon
from silo2d.measures import fields
from silo2d.measures.basics.coarse_graining import (
    Grid,
    closed,
    grid_round,
    inside_polygon,
    intervals_at,
    part_inside,
)
from silo2d.view.scene import read_scene

WIDTH = 14e-3  # of the Gaussian [m]
SILO = hopper(math.radians(45), 0.06, 0.2, 0.3, "fields")
SPECK = scenes.block(3e-3, 3e-3)
SPACING = 4e-3


def phi(z: float) -> float:
    """The normal distribution function."""
    return 0.5 * math.erfc(-z / math.sqrt(2))


def lattice(silo, spacing=SPACING):
    """Points in the middle of square cells that lie in the silo with their middle (n, 2) [m]."""
    x = np.arange(-0.1 + spacing / 2, 0.1, spacing)
    y = np.arange(spacing / 2, silo.height, spacing)
    points = np.array([(a, b) for b in y for a in x])
    inside = [
        any(left <= a <= right for left, right in intervals_at(closed(silo.polygon), b))
        for a, b in points
    ]
    return points[inside]


@pytest.fixture(scope="module")
def lattice_scene():
    """Specks on a square lattice in a silo, moving like a rigid body that rotates and sinks."""
    points = lattice(SILO)
    x, y = points.T
    return scene_of([SPECK], np.zeros(len(x), int), SILO, x, y, vx=2 * y, vy=-1 - 2 * x)


# The grid


@given(st.lists(st.tuples(*[st.floats(-0.05, 0.05)] * 2, st.floats(-3, 3)), min_size=1, max_size=5))
def test_deposit_is_a_sum_of_gaussians_and_keeps_their_weight(points):
    """Against the sum written out; the integral over the plane is the sum of the weights, to the
    rim's 1e-9 (six widths) and rounding."""
    places, weights = np.array(points)[:, :2], np.array(points)[:, 2:]
    grid = grid_round(np.full(2, -0.05), np.full(2, 0.05), WIDTH)
    found = grid.deposit(places, weights)[0]
    apart = np.stack(np.meshgrid(grid.x, grid.y), axis=-1)[:, :, None] - places
    each = np.exp(-(apart**2).sum(axis=-1) / (2 * WIDTH**2)) / (2 * np.pi * WIDTH**2)
    np.testing.assert_allclose(found, each @ weights[:, 0], atol=1e-9 / WIDTH**2)
    total = np.abs(weights).sum()
    assert grid.integral(found) == pytest.approx(weights.sum(), abs=1e-8 * total + 1e-300)


def test_part_inside_at_walls_and_corners():
    """Half a kernel on a wall, a quarter in a corner, and the distribution function between; the
    rows of an eighth of a width are good to 1e-3 at a floor, and exact next to a wall."""
    box = hopper(0.0, 0.05, 0.2, 0.3).polygon
    xs, ys = np.array([-0.1, -0.1 + WIDTH, 0.0]), np.array([0.0, WIDTH, 0.15])
    found = part_inside(Grid(xs, ys, WIDTH), closed(box))
    across, up = [0.5, phi(1.0), 1.0], [0.5, phi(1.0), 1.0]
    np.testing.assert_allclose(found, np.outer(up, across), atol=1e-3)
    np.testing.assert_allclose(found[2], across, atol=1e-9)


def test_part_inside_at_a_slope_and_above_the_open_top():
    """Half on a hopper's wall; whole at the top, beyond which the silo goes on."""
    rise = 0.07
    xs, ys = np.array([0.03 + rise / 2, 0.0]), np.array([rise / 2, 0.3])
    found = part_inside(Grid(xs, ys, 5e-3), closed(SILO.polygon))
    assert found[0, 0] == pytest.approx(0.5, abs=2e-3)
    assert found[1, 1] == pytest.approx(1.0, abs=1e-6)


def test_inside_of_a_silo_that_is_not_convex():
    """A roof in the middle splits the line at a low height in two."""
    polygon = [[-10, 0], [10, 0], [40, 30], [40, 50], [-40, 50], [-40, 10], [-25, 30]]
    silo = outline_from_polygon(np.array(polygon) * 1e-3)
    np.testing.assert_allclose(
        1e3 * intervals_at(closed(silo.polygon), 0.015), [[-40, -36.25], [-17.5, 25]], atol=1e-9
    )


def test_the_inside_is_found_again_from_the_walls(lattice_scene):
    """A run keeps wall segments; in turn they are the corners of the silo, lips included."""
    from shapely import Polygon

    found = Polygon(inside_polygon(lattice_scene))
    assert found.symmetric_difference(Polygon(SILO.polygon)).area < 1e-12


def test_areas_of_the_particles(lattice_scene):
    """From the outlines kept for drawing, whose chords cut 0.1 % at most."""
    assert lattice_scene.areas[0] == pytest.approx(SPECK.area, rel=0.02)
    block = scene_of([scenes.block(20e-3, 10e-3)], [0], SILO, np.zeros(1), np.full(1, 0.1))
    assert block.areas[0] == pytest.approx(scenes.block(20e-3, 10e-3).area, rel=1e-3)


# Fields


def test_mass_and_momentum_are_conserved(lattice_scene):
    """Integrals over the plane are the sums over the particles, to the rim's 1e-9 and rounding."""
    field = fields.field_of(lattice_scene, np.array([0]), WIDTH)
    mass = lattice_scene.trajectory.static["mass"]
    assert field.grid.integral(field.density) == pytest.approx(mass.sum(), rel=1e-8)
    for k, key in enumerate(("vx", "vy")):
        momentum = (mass * lattice_scene.trajectory[key][0]).sum()
        scale = (mass * np.abs(lattice_scene.trajectory[key][0])).sum()
        assert field.grid.integral(field.momentum[k]) == pytest.approx(momentum, abs=1e-8 * scale)


def test_a_uniform_packing_is_uniform_up_to_the_walls(lattice_scene):
    """Packing fraction: area of a speck over its cell. The lattice has steps of 4 mm at the
    slopes, 0.14 of a kernel's half: within 2 % at upright walls and floor, 8 % at the slopes."""
    field = fields.field_of(lattice_scene, np.array([0]), WIDTH)
    expected = lattice_scene.areas[0] / SPACING**2
    grid = field.grid
    below_surface = grid.y < SILO.height - 5 * WIDTH
    solid = field.solid[below_surface]
    upright = solid[grid.y[below_surface] > 0.07 + 4 * WIDTH]
    known = np.isfinite(upright)
    assert known.sum() > 100
    np.testing.assert_allclose(upright[known], expected, rtol=0.02)
    known = np.isfinite(solid)
    np.testing.assert_allclose(solid[known], expected, rtol=0.08)


def test_velocity_of_a_rigid_motion(lattice_scene):
    """A rotation and a fall are linear in place: a Gaussian's mean of a linear field over an even
    lattice is the field itself, four widths from where the lattice ends."""
    field = fields.field_of(lattice_scene, np.array([0]), WIDTH)
    x, y = np.meshgrid(field.grid.x, field.grid.y)
    deep = (np.abs(x) < 0.1 - 4 * WIDTH) & (y > 0.07 + 2 * WIDTH) & (y < 0.3 - 4 * WIDTH)
    assert deep.sum() > 20
    np.testing.assert_allclose(field.velocity[0][deep], 2 * y[deep], atol=2e-3)
    np.testing.assert_allclose(field.velocity[1][deep], -1 - 2 * x[deep], atol=2e-3)


def test_an_even_motion_is_even_up_to_the_walls():
    """What walls cut off cancels in momentum over density, to rounding."""
    points = lattice(SILO)
    scene = scene_of([SPECK], np.zeros(len(points), int), SILO, *points.T, vx=0.3, vy=-0.8)
    velocity = fields.field_of(scene, np.array([0]), WIDTH).velocity
    known = np.isfinite(velocity[0])
    np.testing.assert_allclose(velocity[0][known], 0.3, rtol=1e-6)
    np.testing.assert_allclose(velocity[1][known], -0.8, rtol=1e-6)


def test_fields_of_a_run(reference, tmp_path):
    """The mass in the silo is the mean over the window's frames, and what passes the height of
    the lowest profile is a flow downwards."""
    folder = shutil.copytree(reference.path, tmp_path / "run")
    scene = read_scene(folder)
    numbers = fields.measure(folder)
    frames = fields.flow_frames(scene)
    mass = scene.trajectory.static["mass"]
    inside = [mass[fields.in_silo(scene, frame)].sum() for frame in frames]
    assert numbers["mass_in_silo_kg"] == pytest.approx(np.mean(inside), rel=1e-6)
    assert numbers["profiles"][0]["mass_flow_kg_per_s"] > 0
    result = silo2d("observe", folder, "fields")
    assert result.code == 0, result.err
    assert (folder / "figures" / "fields.png").stat().st_size > 20_000


def test_a_run_that_hardly_flowed_has_no_flow_field(runs, tmp_path):
    """One line, exit code 2."""
    from small_silo import the_run, write_case

    case = write_case(tmp_path, {"run.max_time": "20 ms"})
    silo2d("run", case, "-o", runs, "--no-figures", "--quiet")
    result = silo2d("observe", the_run(runs).path, "fields", "--no-figures")
    assert_refused(result, "a mean over the flow needs 20 particles")
