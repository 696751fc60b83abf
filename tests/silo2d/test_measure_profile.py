"""Displacement profile of the painted layers, against motions whose V is known."""

import json

import numpy as np
import pytest
from moved_run import falling, write_moved_run

from granulab.campaign.output.figure import write_figure
from silo2d.case.outline import hopper
from silo2d.measures import find, profile
from silo2d.measures.basics.particles import column_edges
from silo2d.view.scene import read_scene

WIDE = hopper(0.0, 0.15, name="flat")  # 300 mm, x = 0 in the middle
FALL = 0.2  # m/s


def layers_at(folder, time, key):
    """A number of every layer at a time; NaN for None."""
    numbers = profile.measure(folder)
    (k,) = np.flatnonzero(np.isclose(numbers["times_s"], time))
    return np.array([layer[key][k] for layer in numbers["layers"]], dtype=float)


def test_layers_that_come_down_as_one_have_no_v(tmp_path):
    """Rigid translation: depth 0, no width, and lines one fall below where they began.

    Tolerance: places are stored in single precision, 3e-8 m at half a metre.
    """
    start = write_moved_run(tmp_path, lambda s, t: falling(s, t, FALL), silo=WIDE)
    assert np.nanmax(np.abs(layers_at(tmp_path, 0.5, "depth_m"))) < 2e-7
    assert np.isnan(layers_at(tmp_path, 0.5, "width_m")).all()
    layer = profile.measure(tmp_path)["layers"][4]
    members = read_scene(tmp_path).trajectory.static["layer"] == layer["layer"]
    expected = start[members, 1].mean() - 0.5 * FALL
    line = [y for y in layer["lines_m"][2] if y is not None]
    np.testing.assert_allclose(line, expected, atol=2e-7)


def test_what_waits_in_a_store_is_of_no_layer(tmp_path):
    """Particles of the uppermost layer that are put on later: its line stays where it was."""
    write_moved_run(tmp_path, lambda s, t: falling(s, t, FALL), silo=WIDE)
    scene = read_scene(tmp_path)
    before = profile.layer_lines(scene, [0, 20])[0]
    layer = scene.trajectory.static["layer"]
    top = np.flatnonzero(layer == layer.max())[::2]
    scene.trajectory.frames["inside"][:10, top] = False
    after, counts, _ = profile.layer_lines(scene, [0, 20])
    assert counts[-1, 1].sum() == (layer == layer.max()).sum() - len(top)
    seen = np.isfinite(after[-1])
    assert seen[:, 1:-1].all()
    np.testing.assert_allclose(after[-1][seen], before[-1][seen], atol=6e-3)  # half a spacing


def test_depth_and_width_of_a_parabola(tmp_path):
    """Fall s(x) = S (1 - (x/h)^2): depth S (x_s/h)^2 between columns at 0 and x_s, and the half
    depth is reached at x_s/sqrt(2) on both sides.

    Columns are 27 mm wide; the mean of x^2 over a column is its middle's plus w^2/12, alike in
    all. Particles stand 12 mm apart and 7.2 mm off the walls, so those of the side columns are
    3.6 mm further in than the columns' middles, and known to about 2 mm: 3 % of the depth. The
    line is straight between columns, which puts the half width off by less than w/8 on each side.
    """
    deep, half = 0.1, 0.15
    write_moved_run(
        tmp_path, lambda s, t: falling(s, t, deep * (1 - (s[:, 0] / half) ** 2)), silo=WIDE,
        n_frames=101,
    )  # fmt: skip
    edges = column_edges(read_scene(tmp_path))
    w = edges[1] - edges[0]
    side = edges[-1] - w / 2 - 0.0036
    depth, width = (layers_at(tmp_path, 1.0, key) for key in ("depth_m", "width_m"))
    full = np.arange(3, 10)  # layers that are not cut by the surface or the outlet
    np.testing.assert_allclose(depth[full], deep * (side / half) ** 2, rtol=0.03)
    np.testing.assert_allclose(width[full], 2 * side / np.sqrt(2), atol=w / 4)


def test_depth_grows_with_the_time(tmp_path):
    """The parabola's depth is linear in time: at 0.25 s half of that at 0.5 s, to rounding.

    Particles keep their columns, so that both times have the same errors but single precision's.
    """
    write_moved_run(tmp_path, lambda s, t: falling(s, t, 0.1 * np.cos(10 * s[:, 0])), silo=WIDE)
    early, late = (layers_at(tmp_path, t, "depth_m") for t in (0.25, 0.5))
    np.testing.assert_allclose(early, late / 2, atol=2e-7)
    assert (late > 0.02).all()


def test_a_layer_whose_middle_has_left_is_pierced(tmp_path):
    """The middle third of the lowest layers leaves: no depth there, and the others have one."""
    middle = lambda s: np.where((np.abs(s[:, 0]) < 0.05) & (s[:, 1] < 0.09), 0.1, np.nan)  # noqa: E731
    write_moved_run(tmp_path, lambda s, t: falling(s, t, 0.0), silo=WIDE, out_time=middle)
    pierced = layers_at(tmp_path, 0.25, "pierced")
    np.testing.assert_array_equal(pierced, np.arange(len(pierced)) < 2)
    np.testing.assert_array_equal(np.isnan(layers_at(tmp_path, 0.25, "depth_m")), pierced)


def test_scatter_is_that_of_the_displacements_about_their_line(tmp_path):
    """Falls of 0.2 m/s with an sd of 0.02 m/s: 10 mm after 0.5 s, none at the start.

    A layer of some 60 particles knows an sd to 1/sqrt(120) = 9 %; four of these allowed.
    """
    speed = lambda s: FALL + 0.02 * np.random.default_rng(5).standard_normal(len(s))  # noqa: E731
    write_moved_run(tmp_path, lambda s, t: falling(s, t, speed(s)), silo=WIDE)
    full = np.arange(3, 10)
    np.testing.assert_allclose(layers_at(tmp_path, 0.5, "scatter_m")[full], 0.01, rtol=0.36)
    np.testing.assert_allclose(layers_at(tmp_path, 0.0, "scatter_m"), 0.0, atol=1e-9)


@pytest.mark.parametrize("end", [0.0, 0.24, 0.25, 0.6])
def test_frames_stand_at_the_paper_s_times(end):
    """Every 0.25 s from the opening, none beyond the end."""
    time = np.arange(0.0, end + 1e-9, 0.01)
    wanted = time[profile.profile_frames(time)]
    np.testing.assert_allclose(wanted, 0.25 * np.arange(len(wanted)))
    assert end - wanted[-1] < 0.25


def test_profile_of_a_run_is_json_and_a_picture(reference, tmp_path):
    """A real run, whose last moment has no particle left."""
    found = find("profile")
    json.dumps(found.measure(reference.path), allow_nan=False)
    assert write_figure(tmp_path / "profile.png", lambda: found.draw(reference.path)).stat().st_size
