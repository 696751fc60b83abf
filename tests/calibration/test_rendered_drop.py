"""Rendered drop tests show what their truth says: places, contacts, blur, lost frames, the file."""

from dataclasses import replace

import numpy as np
import pytest

from calibration.rendered.backdrop import Backdrop, disc
from calibration.rendered.camera import Camera
from calibration.rendered.drop import Ball, DropScene, film_drop, sharp
from calibration.tracking.film.reader import open_film

G = 9.80665
SHARP = Camera(60, exposure=0.0, blur=0.0, noise=0.0, falloff=0.0, moments=1)
FLAT = Backdrop(wall=(0, 0, 0), plate=(0, 0, 0), texture=0.0)
SMALL = DropScene((Ball(diameter=0.02),), width=80, height=440, backdrop=FLAT, shadow=0.0)


def test_free_fall_and_restitution_between_the_contacts():
    """t1 = sqrt(2 h/g), T(k+1)/T(k) = e: the first contact and all flights, to rounding."""
    ball = Ball(fall=0.4, restitution=0.7, release=0.2)
    times, e, speeds = ball.contacts()
    assert times[0] == pytest.approx(0.2 + np.sqrt(0.8 / G), rel=1e-12)
    flights = np.diff(times)
    np.testing.assert_allclose(flights[1:] / flights[:-1], 0.7)
    np.testing.assert_allclose(speeds[1:], e[:-1] * speeds[:-1])
    assert [ball.height(t) for t in times[:4]] == pytest.approx([0] * 4, abs=1e-9)
    apex = times[0] + flights[0] / 2
    assert np.sqrt(ball.height(apex) / ball.fall) == pytest.approx(0.7)  # eq. 3.5


def test_restitution_that_falls_with_speed_is_a_power_of_it():
    _, e, speeds = Ball(restitution=0.6, exponent=-0.2, bounces=5).contacts()
    np.testing.assert_allclose(e, 0.6 * (speeds / speeds[0]) ** -0.2)


@pytest.mark.parametrize("radius", [4.0, 7.3, 60.0])
def test_a_disc_has_its_area_and_its_centre(radius):
    """Cover of pixels cut by the rim is linear in the distance to it: area to (1 px)^2/12/r^2."""
    patch = disc(31.37, 18.81, radius, (1, 1, 1))
    rows, columns = np.indices(patch.cover.shape)
    area = patch.cover.sum()
    assert area == pytest.approx(np.pi * radius**2, rel=0.1 / radius**2 + 1e-3)
    assert (columns * patch.cover).sum() / area + patch.column == pytest.approx(31.37, abs=0.01)
    assert (rows * patch.cover).sum() / area + patch.row == pytest.approx(18.81, abs=0.01)


def test_the_ball_is_where_the_truth_says(tmp_path):
    """Lossless film; the lit disc's bounding box is its place to a pixel's half."""
    truth = film_drop(SMALL, SHARP, tmp_path / "a.avi", duration=0.5, codec="FFV1")
    frames = [frame.picture.max(axis=2) > 8 for frame in open_film(tmp_path / "a.avi").frames()]
    assert len(frames) == len(truth.path) == 30
    for seen, (x, y), radius in zip(frames, truth.path, truth.radius, strict=True):
        rows, columns = np.nonzero(seen)
        assert abs((columns.min() + columns.max()) / 2 - x) <= 1
        assert abs((rows.min() + rows.max()) / 2 - y) <= 1
        assert abs(np.ptp(columns) + 1 - 2 * radius) <= 2
    assert truth.frame == pytest.approx(truth.contacts * 60)
    # the lowest place is at the plate, 0.9 of the height, less the radius
    assert truth.path[:, 1].max() <= 0.9 * 440 - 10 + 1e-9


def test_motion_blur_is_speed_times_exposure():
    """At v = 2 m/s, half open at 50 frames/s, 1 mm/px: the disc is drawn out by 20 px."""
    ball = SMALL.balls[0]
    time = ball.release + 2 / G
    camera = sharp(SMALL, replace(SHARP, rate=50, exposure=0.5))
    still, moving = (
        one.picture(SMALL.paint, time, np.random.default_rng(1)).max(axis=(1, 2))
        for one in (SHARP, camera)
    )
    # the ends of the trail are faint: less than a grey level at the last of them
    assert np.count_nonzero(moving) - np.count_nonzero(still) == pytest.approx(20, abs=2)


def test_repeated_and_lost_frames_and_the_header_are_as_requested(tmp_path):
    path = tmp_path / "b.avi"
    truth = film_drop(
        SMALL, SHARP, path, duration=0.5, repeated=[5], dropped=[9, 10], header=25, codec="FFV1"
    )
    film = open_film(path)
    pictures = [frame.picture for frame in film.frames()]
    assert film.rate == 25
    assert len(pictures) == len(truth.path) == 30 + 1 - 2
    assert np.array_equal(pictures[5], pictures[6])
    steps = np.diff(truth.path[:, 1])
    # camera frames 8 and 11 are neighbours 9 and 10 of the file: three frames' way
    assert steps[9] > 2 * steps[8]
    assert truth.rate == 60


def test_a_ball_that_comes_nearer_grows_and_its_plate_sinks():
    """Pinhole: size and distance from the axis go as 1/(1 - approach t)."""
    near = replace(SMALL, approach=0.2)
    ball = replace(SMALL.balls[0], fall=0.1, release=10)
    (_, y0, r0), (_, y1, r1) = near.position(ball, 0.0), near.position(ball, 1.0)
    assert r1 / r0 == pytest.approx(1 / 0.8)
    assert (y1 - 220) / (y0 - 220) == pytest.approx(1 / 0.8)


@pytest.mark.parametrize("scene", [replace(SMALL, balls=()), replace(SMALL, with_hand=True)])
def test_scenes_with_a_hand_or_without_a_ball_are_filmed(tmp_path, scene):
    truth = film_drop(scene, SHARP, tmp_path / "c.avi", duration=0.2, codec="FFV1")
    assert len(truth.contacts) == 0
    assert len(list(open_film(tmp_path / "c.avi").frames())) == 12
