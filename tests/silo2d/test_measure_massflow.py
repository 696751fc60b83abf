"""Mass flow index, against velocity fields that are known."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from moved_run import falling, write_moved_run

from granulab.campaign.output.figure import write_figure
from granulab.errors import InputError
from silo2d.case.beds.openings import with_inserts, with_outlets
from silo2d.case.outline import hopper
from silo2d.measures import find, massflow
from silo2d.view.scene import read_scene

FLAT = hopper(0.0, 0.15, name="flat")
STEEP = hopper(np.radians(60), 0.1, name="steep")
ALL = (0.0, 0.5)


def known(folder, **options):
    rows = massflow.measure(folder, between=ALL, **options)["bands"]
    return [row for row in rows if row["index"] is not None]


def test_plug_flow_has_an_index_of_one(tmp_path):
    """All particles at one velocity: walls over centre is 1, without error, at every height.

    Tolerance: velocities are in single precision.
    """
    write_moved_run(tmp_path, lambda s, t: falling(s, t, 0.1), silo=FLAT)
    rows = known(tmp_path)
    assert len(rows) >= 9
    for row in rows:
        assert row["index"] == pytest.approx(1.0, abs=1e-6)
        assert row["error"] is None or row["error"] < 1e-6
        assert row["centre_m_per_s"] == pytest.approx(0.1)


def test_a_core_between_resting_walls_is_funnel_flow(tmp_path):
    """Only |x| < 80 mm moves: the index is 0, below Johanson's limit."""
    core = lambda s: np.where(np.abs(s[:, 0]) < 0.08, 0.1, 0.0)  # noqa: E731
    write_moved_run(tmp_path, lambda s, t: falling(s, t, core(s)), silo=FLAT)
    rows = [row for row in known(tmp_path) if row["error"] is not None]
    assert rows
    assert {(row["index"], row["flow"]) for row in rows} == {(0.0, "funnel flow")}


def test_radial_flow_in_a_hopper(tmp_path):
    """Towards the apex, v(theta) = V (1 - a (theta/theta_w)^2), theta_w at the wall.

    Particles of the strip at the wall lie up to one particle size from it and those at the centre
    up to one from the line, so the index lies between the ratios that the ends of these strips
    give. Fields are taken at one moment: the particles stand still while they have these
    velocities.
    """
    speed, a, half_angle = 0.2, 0.8, np.radians(30)
    apex = -0.05 * np.tan(np.radians(60))

    def profile(theta):
        return speed * (1 - a * (theta / half_angle) ** 2)

    def motion(start, time):
        x, y = start[:, 0], start[:, 1] - apex
        theta = np.arctan2(x, y)
        v = profile(theta)
        return np.array([start[:, 0], start[:, 1], -v * np.sin(theta), -v * np.cos(theta)])

    write_moved_run(tmp_path, motion, silo=STEEP, spacing=0.009)
    size = read_scene(tmp_path).particle_size
    hopper_top = 0.1 * np.tan(np.radians(60))
    rows = [row for row in known(tmp_path, band=0.02) if row["until_m"] < hopper_top]
    assert len(rows) >= 5
    for row in rows:
        lowest = row["from_m"] - apex  # where an angle is widest for a width
        inner = half_angle - size / (lowest / np.cos(half_angle) - size)
        slowest_centre = profile(np.arctan2(size, lowest)) * np.cos(np.arctan2(size, lowest))
        at_wall = profile(half_angle) / speed
        inside = profile(inner) / slowest_centre
        assert at_wall <= row["index"] <= inside
        assert row["flow"] == ("mass flow" if row["index"] > 0.3 else "funnel flow")


def test_the_error_is_that_of_the_parts_of_the_window():
    """Ratios 1, 2, 3, 4, 5 of five parts: sd sqrt(2.5), error sqrt(2.5/5); pooled index 3.

    A band without particles has neither, and one with two parts has no error.
    """
    ones = np.ones(5)
    wall, centre = np.zeros((5, 2, 3)), np.zeros((5, 2, 3))
    wall[:, 0, 0], wall[:, 1, 0] = np.arange(1.0, 6.0), ones
    centre[:, :, 0] = 1.0
    wall[:2, :, 2], centre[:2, :, 2] = 1.0, 1.0
    index, error = massflow.index_and_error(wall, centre)
    np.testing.assert_allclose(index, [3.0, np.nan, 1.0])
    np.testing.assert_allclose(error, [np.sqrt(0.5), np.nan, np.nan])


def test_the_lowest_band_of_runs_is_that_of_their_means():
    """Ten bands of 0.36 with errors of 0.05: the lowest of a run is 0.28 in the mean, and was
    funnel flow in most; of three runs, by two errors, hardly any is."""
    rng, verdicts = np.random.default_rng(2), []
    for _ in range(200):
        runs = [{"bands": [{"index": 0.36 + 0.05 * rng.standard_normal(), "error": 0.05}
                           for _ in range(10)]} for _ in range(3)]  # fmt: skip
        runs[0]["bands"].append({"index": 0.0, "error": None})  # of a band that hardly anyone saw
        index, error = massflow.lowest_over(runs)
        assert error == pytest.approx(0.05 / np.sqrt(3))
        verdicts.append(massflow.flow_by(index, error))
    assert verdicts.count("funnel flow") < 4
    assert massflow.lowest_over([{"bands": [{"index": 0.1, "error": None}]}]) is None


def test_what_falls_beside_the_silo_is_not_in_it(tmp_path):
    """A bed that sinks as one, and every fortieth particle 10 mm beside a wall with a window: the
    index stays 1."""
    silo = with_outlets(FLAT, [[[150, 200], [150, 270]]], 1e-3, "silo")

    def motion(start, time):
        x, y, vx, vy = falling(start, time, 0.05)
        out = np.arange(len(start)) % 40 == 0
        return np.array([np.where(out, 0.16, x), np.where(out, 0.1, y), vx,
                         np.where(out, -2.0, vy)])  # fmt: skip

    write_moved_run(tmp_path, motion, silo=silo)
    assert [row["index"] for row in known(tmp_path)] == pytest.approx(
        [1.0] * len(known(tmp_path)), abs=1e-5
    )


def test_a_window_without_a_frame_is_refused(tmp_path):
    write_moved_run(tmp_path, lambda s, t: falling(s, t, 0.1), silo=FLAT)
    with pytest.raises(InputError, match=r"no frame; the run has them from 0 to 0\.5 s"):
        massflow.measure(tmp_path, between=(5.0, 6.0))


@pytest.fixture(scope="module")
def steep(tmp_path_factory):
    """A scene of the steep hopper."""
    folder = tmp_path_factory.mktemp("steep")
    write_moved_run(folder, lambda s, t: falling(s, t, 0.0), silo=STEEP, n_frames=2, spacing=0.03)
    return read_scene(folder)


@given(st.floats(-0.2, 0.2), st.floats(-0.05, 0.6))
def test_nearest_wall_is_shapely_s(steep, x, y):
    """Oracle: shapely's distance to each wall; the direction is a unit vector down along it."""
    from shapely import LineString, Point

    distance, along = massflow.nearest_wall(steep, np.array([x]), np.array([y]))
    lengths = [LineString(wall).distance(Point(x, y)) for wall in steep.walls]
    assert distance[0] == pytest.approx(min(lengths), abs=1e-12)
    assert along[0, 1] < 0
    assert np.hypot(*along[0]) == pytest.approx(1.0)
    nearest = [
        np.cross(np.append(wall[1] - wall[0], 0), np.append(along[0], 0))[2]
        for wall, length in zip(steep.walls, lengths, strict=True)
        if length < min(lengths) + 1e-12
    ]
    assert min(map(abs, nearest)) < 1e-12  # parallel to one of the nearest: ties at a corner


def test_particles_along_an_insert_are_not_at_a_wall(tmp_path):
    """A bar of 10 mm in the middle of the steep hopper: 20 mm from it the nearest wall is the
    silo's, as without it."""
    bar = [[-5, 300], [5, 300], [5, 400], [-5, 400]]
    point, found = (np.array([0.025]), np.array([0.35])), []
    for name, silo in (("bare", STEEP), ("bar", with_inserts(STEEP, [bar], 1e-3, "silo"))):
        folder = tmp_path / name
        write_moved_run(
            folder, lambda s, t: falling(s, t, 0.0), silo=silo, n_frames=2, spacing=0.03
        )
        found.append(massflow.nearest_wall(read_scene(folder), *point)[0][0])
    assert found[1] == found[0] > 0.1


def test_massflow_of_a_run_is_json_and_a_picture(reference, tmp_path):
    """A real run."""
    found = find("massflow")
    json.dumps(found.measure(reference.path), allow_nan=False)
    assert write_figure(tmp_path / "m.png", lambda: found.draw(reference.path)).stat().st_size


def test_no_index_where_few_leave(tmp_path):
    """Particles that only tremble have no steady part: without a window one line says so."""
    write_moved_run(
        tmp_path, lambda s, t: falling(s, t, 0.0), silo=FLAT, n_frames=5,
        out_time=lambda s: np.where(np.arange(len(s)) < 19, 0.01, np.nan),
    )  # fmt: skip
    with pytest.raises(InputError, match="19 particles left: a mass flow index needs 20 particles"):
        massflow.measure(tmp_path)
    assert massflow.measure(tmp_path, between=(0.0, 0.04))["bands"]
