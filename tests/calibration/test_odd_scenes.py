"""Films of another experiment: one line that says what was seen instead, and exit code 2."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import odd_scenes
import pytest
from calibrating import calibrate
from made_pendulums import made
from refusals import assert_refused

from calibration import measure_pendulum
from calibration.rendered.strings import Strings
from granulab.errors import InputError

STRANGERS = Path(os.environ.get("GRANULAB_MEDIA", Path(__file__).parents[3] / "shared" / "media"))


@pytest.mark.parametrize("count", [3])
def test_a_chain_of_balls_is_refused_with_their_number(tmp_path, count):
    """An impulse passes through it: neither two blocks nor a ball and a wall."""
    film = odd_scenes.film_of(odd_scenes.chain(count), tmp_path / "c.avi", strings=True)
    assert_refused(calibrate("pendulum", film, "--quiet"), f"at least {count} bodies")


def test_three_tracks_that_move_each_in_its_own_way_are_refused():
    """A third point that moves as the first does, such as its shadow, is none more."""
    first, second = made(Strings(mass_ratio=1.0)).tracks
    shadow = replace(first, x=first.x + 30, name="shadow")
    assert len(measure_pendulum([first, second, shadow]).arcs) == 2
    third = replace(second, x=300 + 40 * np.sin(0.07 * second.frame), name="third")
    with pytest.raises(InputError, match=r"at least 3 bodies .*'third'.*--track"):
        measure_pendulum([first, second, third])
    assert len(measure_pendulum([first, second, third], tracks=["1", "2"]).arcs) == 2


@pytest.mark.parametrize(
    ("places", "words"),
    [
        (odd_scenes.rolling(20), "plane, 20 degrees off the horizontal"),
        (odd_scenes.rolling(60), "plane, 60 degrees off the horizontal"),
        (odd_scenes.rolling(60, stop=110), "30 degrees off the picture's vertical"),
        (odd_scenes.falls(plate=140), "stays where it lands"),
        (odd_scenes.falls(plate=None), "not seen to come back"),
        (odd_scenes.thrown, "turns in the air"),
        (odd_scenes.slow_motion, "the camera ran far faster"),
    ],
    ids=["rolls", "rolls steeply", "meets a stop", "stays", "falls out", "thrown", "too fast"],
)
def test_what_does_not_fall_and_bounce_is_named(tmp_path, places, words):
    film = odd_scenes.film_of(places, tmp_path / "odd.avi", seconds=1.5)
    assert_refused(calibrate("drop", film, "--one-bounce", "--quiet"), words)


@pytest.mark.validation
@pytest.mark.parametrize(
    ("command", "name", "words"),
    [
        ("pendulum", "keremsirtikizil_newtons_cradle.mp4", "bodies swing side by side"),
        ("drop", "keremsirtikizil_droplet.mp4", "nothing falls"),
    ],
)
def test_a_strangers_film_of_something_else_is_refused(command, name, words):
    if not (STRANGERS / name).exists():
        pytest.skip(f"{STRANGERS / name} is not here")
    assert_refused(calibrate(command, STRANGERS / name, "--quiet"), words)
