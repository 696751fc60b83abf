"""Stick and slip at a wall, against motions along it that are known."""

import json
from itertools import pairwise

import numpy as np
import pytest
from fake_run import write_fake_run
from hand_built import scene_of
from moved_run import falling, write_moved_run

from granulab.campaign.output.figure import write_figure
from granulab.campaign.runs.trajectory import read_trajectory
from silo2d.case.beds.openings import with_inserts
from silo2d.case.outline import hopper
from silo2d.case.shape import disc
from silo2d.measures import find, stickslip

SILO = hopper(0.0, 0.15, name="flat")
WALL = 0.15  # m: the right wall
STICK, SLIP = 6, 4  # frames of each, in turn
FAST = 0.2  # m/s


@pytest.fixture
def reach(tmp_path) -> np.ndarray:
    """How far each particle of a made run extends to the right (n,) [m], at an angle of 0."""
    write_fake_run(tmp_path / "shapes", silo=SILO, spacing=0.03)
    static = read_trajectory(tmp_path / "shapes").static
    points, first = static["shape_points"][:, 0], static["shape_start"]
    furthest = [points[a:b].max() for a, b in pairwise(first)]
    return np.array(furthest)[static["kind"]]


def at_wall(reach, speed, gap=0.0):
    """Particles that touch the right wall and come down at a speed that depends on the time."""

    def motion(start, time):
        high = 0.2 + 0.2 * start[:, 1]  # no particle near an end of the wall
        x = np.full(len(start), WALL - gap) - reach
        down = np.broadcast_to(speed(time), len(start))
        return np.array([x, high, 0 * high, -down])

    return motion


def test_sticks_and_slips_of_a_square_wave(tmp_path, reach):
    """Frames 1 to 50: four at 0.2 m/s end a period of six at rest. Durations: whole frames.

    Frames 1 to 5 rest (cut off by the beginning), 6 to 9 slip, 10 to 15 rest, ..., 46 to 49 slip,
    50 rests (cut off): five slips and four sticks are complete, 30 of 50 frames stick.
    """

    def speed(time):
        return FAST if round(time / 0.01) % (STICK + SLIP) >= STICK else 0.0

    write_moved_run(tmp_path / "run", at_wall(reach, speed), silo=SILO, spacing=0.03)
    wall = stickslip.measure(tmp_path / "run")["walls"]["right wall"]
    n = len(reach)
    assert wall["touching_mean"] == n
    assert wall["sticking_fraction"] == pytest.approx(30 / 50)
    assert wall["mean_sliding_m_per_s"] == pytest.approx(0.4 * FAST, rel=1e-6)
    assert (wall["sticks_complete"], wall["sticks_cut_off"]) == (4 * n, 2 * n)
    assert (wall["slips_complete"], wall["slips_cut_off"]) == (5 * n, 0)
    assert wall["stick_mean_s"] == wall["stick_longest_s"] == pytest.approx(0.06)
    assert wall["slip_mean_s"] == pytest.approx(0.04)


def test_only_what_comes_near_enough_touches(tmp_path, reach):
    """A gap of 0.15 mm is none within 0.1 mm and one within 0.2 mm; nothing touches elsewhere."""
    motion = at_wall(reach, lambda time: 0.0, gap=1.5e-4)
    write_moved_run(tmp_path / "run", motion, silo=SILO, spacing=0.03, n_frames=5)
    assert stickslip.measure(tmp_path / "run")["touching_mean"] == 0
    walls = stickslip.measure(tmp_path / "run", gap=2e-4)["walls"]
    assert walls["right wall"]["touching_mean"] == len(reach)
    assert walls["left wall"]["touching_mean"] == walls["floor left"]["touching_mean"] == 0


def test_a_particle_that_rolls_down_the_wall_sticks(tmp_path, reach):
    """Its point at the wall rests: v_y + spin x_contact = 0, while its centroid moves."""
    roll = -FAST / reach  # anticlockwise: the right side goes up while the particle comes down
    write_moved_run(
        tmp_path / "run", at_wall(reach, lambda time: FAST), silo=SILO, spacing=0.03,
        spin=lambda start, time: -roll, n_frames=5,
    )  # fmt: skip
    assert stickslip.measure(tmp_path / "run")["walls"]["right wall"]["sticking_fraction"] == 1.0


def test_speed_is_positive_towards_the_outlet(tmp_path, reach):
    """Down a wall, and inwards on a floor."""
    sliding = lambda s, t: at_wall(reach, lambda t: FAST)(s, t)  # noqa: E731
    write_moved_run(tmp_path / "run", sliding, silo=SILO, spacing=0.03, n_frames=5)
    assert stickslip.measure(tmp_path / "run")["mean_sliding_m_per_s"] == pytest.approx(FAST)

    def inwards(start, time):
        x = np.where(start[:, 0] > 0, 0.11, -0.11)
        return np.array([x, np.full(len(x), 0.0), -FAST * np.sign(x), 0 * x])

    # Centroids on the floor: outlines below it touch it, whatever the shape.
    write_moved_run(tmp_path / "floor", inwards, silo=SILO, spacing=0.03, n_frames=5)
    walls = stickslip.measure(tmp_path / "floor")["walls"]
    for name in ("floor left", "floor right"):
        assert walls[name]["mean_sliding_m_per_s"] == pytest.approx(FAST)


def test_events_are_counted_by_particle():
    """Two particles: 1 sticks, 2 slips, 0 does not touch. Complete: bounded by the other on both
    sides, with no gap between.
    """
    state = np.array([[2, 1, 1, 2, 0, 1, 2, 1], [1, 2, 2, 1, 2, 0, 0, 2]]).T
    found, complete = stickslip.events(state, 1)
    np.testing.assert_array_equal(found, [[1, 0, 2], [5, 0, 1], [7, 0, 1], [0, 1, 1], [3, 1, 1]])
    np.testing.assert_array_equal(complete, [True, False, False, False, True])


def test_nothing_at_the_walls_is_a_picture_too(tmp_path):
    """Particles in the middle; every number that has no meaning is None."""
    write_moved_run(
        tmp_path, lambda s, t: falling(0.5 * s + [0, 0.2], t, 0.0), silo=SILO, n_frames=3
    )
    numbers = stickslip.measure(tmp_path)
    assert numbers["sticking_fraction"] is numbers["stick_mean_s"] is None
    assert write_figure(tmp_path / "none.png", lambda: stickslip.draw(tmp_path)).exists()


def test_stickslip_of_a_run_is_json_and_a_picture(reference, tmp_path):
    """A real run; a higher threshold calls more of it sticking."""
    found = find("stickslip")
    numbers = found.measure(reference.path)
    json.dumps(numbers, allow_nan=False)
    fractions = [numbers[f"sticking_fraction{of}"]
                 for of in ("_half_threshold", "", "_twice_threshold")]  # fmt: skip
    assert fractions == sorted(fractions)
    assert write_figure(tmp_path / "s.png", lambda: found.draw(reference.path)).stat().st_size


def test_a_particle_behind_an_insert_does_not_touch_its_far_side():
    """Of a plate 4 mm thick the upper side is touched by what lies on it, the lower by nothing."""
    plate = [[-0.04, 0.2], [0.04, 0.2], [0.04, 0.204], [-0.04, 0.204]]
    silo = with_inserts(hopper(0.0, 40e-3), [np.array(plate)], 1.0, "silo")
    scene = scene_of([disc("a", 10e-3)], [0], silo, 0.0, 0.204 + 5e-3)
    scene.trajectory.frames.update(time=np.ones(1), spin=np.zeros((1, 1)))  # after the opening
    touched = {
        name for name, one in stickslip.sliding(scene).items() if np.isfinite(one.speed).any()
    }
    top = max(
        range(len(scene.walls)), key=lambda k: scene.of_insert[k] * scene.walls[k, :, 1].min()
    )
    assert touched == {scene.wall_names[top]}
