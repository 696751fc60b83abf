"""Films that cannot be measured: one line that says why, and exit code 2; never a traceback."""

from dataclasses import replace

import calibrating
import numpy as np
import pytest
from refusals import assert_refused

from calibration.drop.measure import measure_drop
from calibration.rendered.camera import Camera
from calibration.rendered.drop import Ball, DropScene, film_drop
from calibration.tracking.track import Track
from granulab.errors import InputError

# A fall of 64 ms, 100 px: contacts at frames 20.8, 41.2, 57.6, 70.6 of 200 a second.
BALL = Ball(diameter=0.004, fall=0.02, release=0.04, aside=0.0)
SCENE = DropScene((BALL,), width=80, height=160, scale=2e-4)
CAMERA = Camera(200, moments=2)


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    path = tmp_path_factory.mktemp("films") / "good.avi"
    film_drop(SCENE, CAMERA, path, duration=0.36, codec="MJPG")
    return path


def refused(*arguments):
    """What stderr says, after checks that it is one line, with exit code 2 and nothing else."""
    found = calibrating.calibrate("drop", *arguments, "--quiet")
    assert_refused(found)
    return found.err


def test_the_film_that_the_others_spoil_is_measured(good):
    assert calibrating.calibrate("drop", good, "--quiet").code == 0


@pytest.mark.parametrize(
    "content", [b"", b"frame,x,y\n0,1,2\n", b"\x00\x00\x00\x18ftypmp42" + bytes(range(256)) * 9]
)
def test_what_is_no_film_is_refused(tmp_path, content):
    path = tmp_path / "film.mp4"
    path.write_bytes(content)
    assert "film.mp4" in refused(path)


def test_an_mp4_without_its_end_is_refused(tmp_path, good):
    """Its index stands there: no frame can be found without."""
    whole, cut = tmp_path / "whole.mp4", tmp_path / "cut.mp4"
    film_drop(SCENE, CAMERA, whole, duration=0.2)
    cut.write_bytes(whole.read_bytes()[:-600])
    assert "cut.mp4" in refused(cut)


def test_a_film_cut_off_after_its_first_contact_has_one_bounce(tmp_path, good):
    """Frames of an avi stand one after the other: two fifths of the file hold one contact.

    The ball was seen at rest before: eq. 3.5 then needs no second one.
    """
    path = tmp_path / "cut.avi"
    data = good.read_bytes()
    path.write_bytes(data[: len(data) * 2 // 5 + 3000])
    found = measure_drop(path)
    assert found.first.held
    assert len(found.bounces.contacts) == 1
    ball = SCENE.balls[0]
    assert abs(found.restitution.value - ball.restitution) < 4 * found.restitution.sigma


@pytest.mark.parametrize(
    ("scene", "duration", "words"),
    [
        (replace(SCENE, balls=(replace(BALL, release=9.0),)), 0.2, "nothing"),  # held
        (replace(SCENE, balls=()), 0.2, "nothing moves"),
        (replace(SCENE, plate=1.6), 0.2, "bounce"),  # it leaves the picture
        (
            replace(SCENE, balls=(BALL, replace(BALL, position=0.8, release=0.06))),
            0.36,
            "2 objects bounce",
        ),
    ],
)
def test_scenes_without_two_bounces_of_one_object_are_refused(tmp_path, scene, duration, words):
    path = tmp_path / "clip.avi"
    film_drop(scene, CAMERA, path, duration=duration, codec="MJPG")
    assert words in refused(path)


@pytest.mark.parametrize("fps", ["0", "-30", "nan", "inf", "1e9", "0.01"])
def test_a_rate_that_no_camera_has_is_refused(good, fps):
    assert "--fps" in refused(good, "--fps", fps)


def test_an_object_that_leaves_faster_than_it_came_is_no_drop_test():
    """Restitution is at most 1 (eq. 3.5): each flight here begins with 1.3 times the speed."""
    times = np.arange(0, 300.0)
    speeds = 10 * 1.3 ** np.arange(5)
    starts = np.concatenate([[0], np.cumsum(2 * speeds / 0.5)])
    k = np.clip(np.searchsorted(starts, times, side="right") - 1, 0, len(speeds) - 1)
    inside = times < starts[-1]
    s = times - starts[k]
    height = (speeds[k] * s - 0.25 * s**2)[inside]
    noise = np.random.default_rng(1).normal(0, 0.1, len(height))
    with pytest.raises(InputError, match=r"restitution of 1\.30 \+- .* no drop test"):
        measure_drop(Track(times[inside], np.zeros(len(height)), noise - height))
