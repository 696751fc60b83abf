"""Drop tests from films: rendered ones of known truth, spoilt ones, and recordings of strangers."""

import itertools
import os
from dataclasses import replace
from pathlib import Path

import calibrating
import cv2
import numpy as np
import pytest
from made_tracks import made_track
from refusals import assert_refused

from calibration.drop.measure import measure_drop
from calibration.rendered.backdrop import Backdrop
from calibration.rendered.camera import Camera
from calibration.rendered.drop import Ball, DropScene, film_drop
from calibration.tracking.camera_motion import CameraMotion
from calibration.tracking.film.reader import open_film
from calibration.tracking.film.stamps import clean_stamps
from calibration.tracking.follow import follow
from granulab.errors import InputError

MEDIA = Path(os.environ.get("GRANULAB_MEDIA") or Path(__file__).parents[3] / "shared" / "media")
needs_media = pytest.mark.skipif(not MEDIA.is_dir(), reason=f"no recordings in {MEDIA}")
BALL = Ball(diameter=0.03, fall=0.2, release=0.1)
SCENE = DropScene((BALL,), width=160, height=280)
CAMERA = Camera(100, moments=3)


def filmed(path, scene=SCENE, camera=CAMERA, duration=1.1, **spoilt):
    """The film's path and its truth."""
    return path, film_drop(scene, camera, path, duration=duration, **spoilt)


def check(found, truth, sigmas=4.0):
    """Contacts and restitution as they were: within four sigma, and what a lens may add.

    A contact moves by the plate's trembling over the impact speed (some px/frame): 0.02 frame.
    """
    contacts = np.array([found.frame(time) for time in found.bounces.contacts[:, 0]])
    near = np.abs(contacts[:, None] - truth.frame[None, :]).argmin(axis=1)
    assert len(contacts) >= 2
    assert np.all(np.diff(near) == 1)  # none left out
    off = contacts - truth.frame[near]
    assert np.all(np.abs(off) < sigmas * found.bounces.contacts[:, 1] + 0.02)
    e = found.restitution
    assert abs(e.value - truth.restitution[1]) < sigmas * e.sigma + 5e-4
    assert e.sigma < 0.02


@pytest.fixture(scope="module")
def ball(tmp_path_factory):
    """The film of a ball and its truth."""
    return filmed(tmp_path_factory.mktemp("ball") / "ball.mp4")


def test_a_ball_is_found_and_its_bounces_measured(ball):
    """Shadow, texture, uneven light, noise: place to a fifth of a pixel, e within its sigma."""
    path, truth = ball
    found = measure_drop(path)
    check(found, truth)
    track = found.bounces.track
    off = np.stack([track.x, track.y], axis=1) - truth.path[track.frame.astype(int)]
    assert np.abs(np.median(off, axis=0)).max() < 0.2
    assert np.median(track.radius) == pytest.approx(15, rel=0.03)  # 0.03 m over 1 mm/px
    assert found.rate_header == pytest.approx(100)
    # g = a s f^2 gives the scale, 1 mm/px, of the pictures
    assert found.scale.value == pytest.approx(1e-3, rel=0.01)


@pytest.mark.parametrize(
    ("scene", "camera"),
    [
        (replace(SCENE, with_hand=True, camera_drift=(12.0, -9.0)), CAMERA),
        (replace(SCENE, balls=(replace(BALL, diameter=0.008),)), replace(CAMERA, noise=5.0)),
        (
            replace(
                SCENE,
                balls=(replace(BALL, colour=(0.95, 0.95, 0.95)),),
                backdrop=Backdrop(wall=(0.75, 0.75, 0.75), plate=(0.7, 0.7, 0.7)),
            ),
            CAMERA,
        ),
        (
            replace(
                SCENE,
                balls=(replace(BALL, colour=(0.04, 0.04, 0.04)),),
                backdrop=Backdrop(wall=(0.25, 0.25, 0.25), plate=(0.2, 0.2, 0.2)),
            ),
            replace(CAMERA, exposure=0.9),
        ),
    ],
    ids=["hand and moving camera", "small and noisy", "white on white", "black on black, blurred"],
)
def test_what_spoils_a_film_is_coped_with(tmp_path, scene, camera):
    check(measure_drop(filmed(tmp_path / "a.mp4", scene, camera)[0]), scene_truth(tmp_path, scene))


def scene_truth(tmp_path, scene):
    """Contacts counted in frames do not depend on what the camera adds."""
    times, restitutions, _ = scene.balls[0].contacts()
    kept = times < 1.1

    class Known:
        frame = times[kept] * CAMERA.rate
        restitution = restitutions[kept]

    return Known


def test_repeated_and_lost_frames_are_found(tmp_path):
    """In flight, away from the apex, where free fall shows them."""
    path, _ = filmed(tmp_path / "a.mp4", repeated=(36, 54), dropped=(70,))
    found = measure_drop(path)
    assert len(found.bounces.base.duplicated_frames) == 2
    assert len(found.bounces.base.dropped_frames) == 1
    e = found.restitution
    assert abs(e.value - 0.8) < 4 * e.sigma + 5e-4


def test_a_film_with_every_picture_twice_is_of_half_the_rate(tmp_path):
    """As a recorder of 120 frames/s writes a camera of 60: coded again, copies are not alike."""
    camera = replace(CAMERA, rate=60)
    twice = tuple(range(66))
    path, truth = filmed(tmp_path / "a.mp4", camera=camera, repeated=twice, header=120)
    found = measure_drop(path)
    assert found.rate_header == pytest.approx(120)
    assert found.rate.value == pytest.approx(60)
    assert "the camera took 0.5" in found.to_dict()["time_base"]["remark"]
    assert len(found.bounces.base.duplicated_frames) > 50
    e = found.restitution
    assert abs(e.value - truth.restitution[1]) < 4 * e.sigma + 5e-4
    assert e.sigma < 0.005


def test_two_balls_are_named_and_chosen(tmp_path):
    other = replace(BALL, position=0.8, release=0.18, restitution=0.7, colour=(0.8, 0.3, 0.2))
    path, _ = filmed(tmp_path / "two.mp4", replace(SCENE, balls=(BALL, other)))
    tracks = follow(open_film(path))
    with pytest.raises(InputError, match=r"2 objects bounce: .* or --roi \('1' from"):
        measure_drop(tracks)
    named = [measure_drop(tracks, track=name).restitution.value for name in "12"]
    assert sorted(named) == pytest.approx([0.7, 0.8], abs=0.01)
    # the second: 0.8 of 160 px; 9.81/2 0.12^2 s^2 = 71 mm below where it hung, at 37 px
    pointed = measure_drop(path, hint=(30, 128, 108))
    assert pointed.restitution.value == pytest.approx(0.7, abs=0.01)
    seen = measure_drop(path, roi=(0, 0, 100, 280))
    assert seen.restitution.value == pytest.approx(0.8, abs=0.01)


@pytest.mark.parametrize(("growth", "reported"), [(1.2, True), (1.0, False), (0.85, True)])
def test_a_ball_that_comes_nearer_is_reported(growth, reported):
    """Its radius says so where it is slow; where it is fast the blur of motion adds to it."""
    track = made_track([0.8] * 5).track
    along = np.linspace(0, 1, len(track.frame))
    fall = np.abs(np.gradient(track.y))
    noise = np.random.default_rng(2).normal(0, 0.1, len(along))
    radius = 20 * growth**along + 0.1 * fall + noise
    found = measure_drop(replace(track, radius=radius), fps=100)
    assert any("the object comes" in warning for warning in found.warnings) == reported


def test_scale_and_header_that_contradict_free_fall_are_reported():
    """A camera of 100 frames/s whose file says 30: g would be 9.8 (30/100)^2 = 0.88 m/s2."""
    made = made_track([0.8] * 4)
    scale = 9.80665 / (made.acceleration * 100**2)  # g = a s f^2
    track = replace(made.track, time=made.track.frame / 30, radius=np.full(len(made.track.x), 9.0))
    found = measure_drop(track, scale=scale)
    assert found.gravity.value == pytest.approx(9.80665 * 0.09, rel=0.01)
    assert any("the rate would be 100" in warning for warning in found.warnings)
    again = measure_drop(track, scale=scale, fps=100)
    assert again.gravity.value == pytest.approx(9.80665, rel=0.01)
    assert (again.rate_header, again.rate.value) == (pytest.approx(30), 100)


def test_error_of_the_camera_s_motion_stays_out_of_positions(tmp_path, monkeypatch):
    """A camera that stands, said to tremble by less than pictures are steadied for (0.5 px)."""
    film = open_film(filmed(tmp_path / "a.mp4", duration=0.4)[0])
    sign = itertools.cycle((1.0, -1.0))

    def trembling(self, picture):
        return np.array([[1, 0, 0.3 * next(sign)], [0, 1, 0.3], [0, 0, 1]])

    monkeypatch.setattr(CameraMotion, "follow", lambda self, picture: np.eye(3))
    stood = follow(film)[0]
    monkeypatch.setattr(CameraMotion, "follow", trembling)
    trembled = follow(film)[0]
    np.testing.assert_array_equal(trembled.x, stood.x)
    np.testing.assert_array_equal(trembled.y, stood.y)


def test_damaged_frames_are_skipped_and_counted(tmp_path):
    """Noise over some frames of a film: the rest is read, and how many are missing is said."""
    path, _ = filmed(tmp_path / "a.avi", duration=0.6, codec="MJPG")
    data = bytearray(path.read_bytes())
    middle = data.find(b"00dc", len(data) // 2) + 8
    data[middle : middle + 400] = bytes(400)
    path.write_bytes(bytes(data))
    film = open_film(path)
    read = [frame.number for frame in film.frames()]
    assert 56 <= len(read) < 60
    assert film.count == 60
    tracks = follow(film)
    assert any("damaged" in remark or "decoded" in remark for remark in tracks[0].remarks)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--roi", "0,0,500,10"), "--roi"),
        (("--roi", "a,b"), "--roi"),
        (("--at", "3,4"), "--at"),
        (("--at", "3,4,5"), "nothing that moves is near"),
        ((), "nothing falls"),
    ],
)
def test_options_that_cannot_be_are_refused(tmp_path, still_and_ball, arguments, words):
    found = calibrating.calibrate("drop", still_and_ball, *arguments, "--quiet")
    assert_refused(found, words)


@pytest.fixture(scope="module")
def still_and_ball(tmp_path_factory):
    return filmed(tmp_path_factory.mktemp("film") / "ball.mp4", duration=0.3)[0]


def test_a_film_in_which_nothing_moves_is_refused(tmp_path, capfd):
    path = filmed(tmp_path / "still.mp4", replace(SCENE, balls=()), duration=0.3)[0]
    found = calibrating.calibrate("drop", path, "--quiet")
    assert found.code == 2
    assert "nothing" in found.err
    assert found.err.count("\n") == 1
    (tmp_path / "text.mp4").write_text("frame,x,y\n1,2,3\n")
    assert "no film" in calibrating.calibrate("drop", tmp_path / "text.mp4").err
    assert capfd.readouterr().err == ""  # nor does FFmpeg add lines of its own


def test_pictures_in_a_folder_are_a_film(ball, tmp_path):
    path, truth = ball
    folder = tmp_path / "pictures"
    folder.mkdir()
    for frame in open_film(path).frames():
        cv2.imwrite(str(folder / f"im{frame.number}.png"), frame.picture)
    found = measure_drop(folder)
    check(found, truth)
    assert found.rate is None
    assert measure_drop(folder, fps=100).rate.value == 100


def test_stamps_that_go_back_are_set_from_the_others():
    stamps = [k / 30 for k in range(28)] + [0.0, 0.0]
    time, remarks = clean_stamps(list(range(30)), stamps, 30.0)
    assert time == pytest.approx(np.arange(30) / 30, abs=1e-9)
    assert "2 time stamps" in remarks[0]


def test_variable_stamps_are_used_and_absurd_headers_are_not():
    uneven = np.cumsum(np.where(np.arange(40) % 2, 0.02, 0.05))
    time, remarks = clean_stamps(list(range(40)), list(uneven), 30.0)
    assert time == pytest.approx(uneven)
    assert "20 to 50 ms" in remarks[0]
    time, remarks = clean_stamps([0, 1, 2], [0.0, 0.1, 0.2], 90000.0)
    assert time is None
    assert "--fps" in remarks[0]


@needs_media
def test_ping_pong_ball_with_hand_and_moving_camera_as_measured_by_others():
    """Their e = 0.761, 0.804, 0.816 from times, sigma 0.015; 20 frames/s."""
    found = measure_drop(MEDIA / "andwel11_ping_pong_ball_at_height_2-1.mp4")
    assert found.bounces.times[1:4, 0] == pytest.approx([0.761, 0.804, 0.816], abs=0.015)
    assert any("camera moves" in warning for warning in found.warnings)


@needs_media
def test_green_ball_in_a_room_as_measured_by_others():
    """Their e = 0.706, 0.719 from times, sigma 0.012; flights of 0.508, 0.359, 0.258 s; g 9.7.

    A flight of T begins and ends with g T/2: what hits the plate at the second contact and third.
    """
    found = measure_drop(MEDIA / "bounceAmeen.avi", scale="0.808 mm/px")
    assert found.bounces.times[1:3, 0] == pytest.approx([0.706, 0.719], abs=0.012)
    flights = np.diff(found.bounces.contacts[:4, 0]) / found.rate.value
    assert flights == pytest.approx([0.508, 0.359, 0.258], abs=0.004)
    assert abs(found.gravity.value - 9.7) < 2 * found.gravity.sigma < 0.6
    speeds = [found.speed(k).value for k in (1, 2)]
    assert speeds == pytest.approx([9.81 * 0.508 / 2, 9.81 * 0.359 / 2], rel=0.05)
    # the first fall is blurred: it misses the others' acceleration
    for words in ("do not share one acceleration", "own shadow", "it bounces on after frame 11"):
        assert any(words in warning for warning in found.warnings)


@needs_media
def test_ping_pong_ball_with_every_picture_twice_as_measured_by_others():
    """Their e = 0.851, 0.872, 0.871 from flights, sigma 0.006, at 30 of 60 frames/s.

    As far as they know it, and drag of so light a ball, which makes the first the lowest: 0.004.
    """
    found = measure_drop(MEDIA / "pingpongvid2.mov")
    assert found.rate.value == pytest.approx(30.016, rel=1e-3)
    assert found.bounces.times[1:4, 0] == pytest.approx([0.851, 0.872, 0.871], abs=0.008)
    assert found.restitution.sigma < np.hypot(0.006, 0.004)


@needs_media
def test_tennis_ball_with_frames_lost_is_put_right():
    """Every sixth frame is missing: steps of 19.0, 58.8, 37.5 px are 1, 2 and 1 frames of fall."""
    found = measure_drop(MEDIA / "andwel11_tennis_ball-1.mp4")
    assert found.bounces.base.dropped_frames[1:4] == [16, 21, 26]
    assert found.rate.value == pytest.approx(24)
    assert "a frame is lost before one of every 5" in found.to_dict()["time_base"]["remark"]
    assert found.restitution.sigma > 0.005
