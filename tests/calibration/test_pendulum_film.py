"""Restitution of objects on strings from films: the sample, rendered, and a stranger's."""

import json
import os
import tomllib
from pathlib import Path

import numpy as np
import pytest
from calibrating import calibrate
from refusals import assert_refused

from calibration import measure_pendulum
from calibration.pendulum.colours import by_colour
from calibration.rendered.camera import Camera, write_film
from calibration.rendered.pendulum import PendulumScene, film_pendulum
from calibration.rendered.strings import Strings
from calibration.tracking.film.reader import Film, open_film

SAMPLE = Path(__file__).parents[2] / "data" / "media" / "pendulum.mp4"
STRANGERS = Path(os.environ.get("GRANULAB_MEDIA", Path(__file__).parents[3] / "shared" / "media"))


def test_the_sample_gives_its_truth():
    """Two equal blocks that touch at each contact: 0.45, and their tracks do not swap.

    Tolerance of the contacts: 0.1 px of the tracking at 8 px/frame, tenfold for the third contact.
    """
    truth = tomllib.loads(SAMPLE.with_suffix(".toml").read_text())
    done = calibrate("pendulum", SAMPLE, "--json", "--quiet")
    assert done.code == 0, done.err
    said = json.loads(done.out)
    e = said["restitution"]
    assert abs(e["value"] - truth["restitution"]) < 4 * e["sigma"] < 0.005
    n = len(said["contact_frames"])
    assert n >= 3
    assert said["contact_frames"] == pytest.approx(truth["contact_frames"][:n], abs=0.2)
    assert said["planar"] is True
    assert said["things"] == "two blocks"
    assert said["mass_ratio"] == pytest.approx(truth["mass_ratio"], abs=0.02)
    assert not any("camera" in line for line in said["warnings"])  # corners of its noise do move
    assert SAMPLE.stat().st_size < 300_000


def test_a_rendered_ball_against_a_wall_is_placed_and_measured(tmp_path):
    """30 frames/s, blurred, noisy, a green ball: places to 0.2 px but for what is common to all."""
    scene = PendulumScene(
        Strings(length=0.3, restitution=0.7, contacts=3), width=160, height=120, scale=2e-3,
        size=0.05, pivot=-60.0, colours=((0.2, 0.6, 0.25),),
    )  # fmt: skip
    path = tmp_path / "wall.mp4"
    truth = film_pendulum(scene, Camera(30, exposure=0.3, noise=4), path, codec="MJPG")
    (track,) = by_colour(open_film(path))
    off = track.x - truth.path[0, track.frame.astype(int), 0]
    assert len(off) > 0.9 * truth.path.shape[1]
    assert np.std(off) < 0.2
    found = measure_pendulum(path)
    assert len(found.arcs) == 1
    assert found.restitution.value == pytest.approx(0.7, abs=0.03)
    assert found.times[:2, 0] == pytest.approx(truth.frame[:2], abs=0.1)


def test_a_film_in_which_nothing_swings_is_refused_in_one_line(tmp_path):
    noise = np.random.default_rng(1).integers(90, 110, (20, 64, 64, 3)).astype(np.uint8)
    path = write_film(iter(noise), tmp_path / "still.avi", 30, "MJPG")
    for file in (path, tmp_path / "none.mp4"):
        done = calibrate("pendulum", file, "--quiet")
        assert done.code == 2
        assert done.err.count("\n") == 1


@pytest.mark.parametrize("command", ["drop", "pendulum"])
def test_a_folder_that_cannot_be_written_is_refused_before_the_film_is_read(
    tmp_path, monkeypatch, command
):
    """A film may take minutes to follow: none of its frames is read. A file is no folder."""
    monkeypatch.setattr(Film, "frames", lambda self: pytest.fail("the film was read"))
    (tmp_path / "file").touch()
    done = calibrate(command, SAMPLE, "--out", tmp_path / "file" / "sheets")
    assert_refused(done, "--out")


def test_progress_is_lines_where_stderr_is_no_terminal(tmp_path):
    """No carriage returns or escapes in a log; a line each ten seconds, the first at once."""
    grey = np.full((64, 64, 3), 90, np.uint8)
    path = write_film([grey] * 20, tmp_path / "still.avi", 30, "MJPG")
    lines = calibrate("pendulum", path).err.splitlines()
    assert lines[0].startswith("still.avi: ")
    assert not any("\r" in line or "\033" in line for line in lines)


@pytest.mark.validation
def test_a_strangers_ball_on_a_string_gives_its_reference():
    """Reference of another's measurement: e = 0.79 (0.03), not planar, eight contacts.

    Contacts to 0.4 frame: two ways of tracking a blurred ball that turns, at 30 px/frame.
    Amplitudes to 5 px: the place of contact, from which they are seen, moves by that.
    """
    file = STRANGERS / "necrosskull_ball_on_string_wall.mp4"
    if not file.exists():
        pytest.skip(f"{file} is not there: recordings of strangers are not part of the project")
    found = measure_pendulum(file)
    frames = [found.frame(time) for time in found.times[:8, 0]]
    assert frames == pytest.approx([18.6, 40.5, 61.9, 82.9, 103.6, 123.4, 142.6, 161.2], abs=0.4)
    amplitudes = [190, 146.7, 116.4, 89.6, 73.0, 58.3, 48.3, 37.3]
    assert found.amplitudes()[1][0, :8] == pytest.approx(amplitudes, abs=5)
    assert found.planar is False
    e = found.restitution
    assert abs(e.value - 0.79) < 2 * np.hypot(e.sigma, 0.03)
    assert np.mean(found.from_amplitudes()[1:8]) == pytest.approx(0.79, abs=0.03)
