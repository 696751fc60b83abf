"""A motion from outside the package: a parabolic wave, described, registered and run in one file.

Its acceleration is a square wave, so that its velocity is a triangle. The same goes for any other:
a named tuple with its numbers, displacement and velocity as functions of these and of time, one
that makes the tuple of a case, and one call of register_motion. A process of its own runs it, see
extended_damper.py, so that the motion is not known to the other tests.
"""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from damper3d import DamperCase, register_motion
from damper3d.engine import ENGINE
from damper3d.engine.motions import displacement, velocity
from granulab.campaign.runs.trajectory import read_trajectory
from granulab.contact.jit import extensions
from granulab.errors import InputError


class Parabolas(NamedTuple):
    """Parabolas end to end, up and down in turn."""

    acceleration: float  # [m/s2]
    period: float  # [s]
    lead: float  # [s] by which it is ahead


def place_at(motion, t):
    """Displacement [m]: up from the middle for half of a period, then down."""
    phase = (t + motion.lead) % motion.period
    half = 0.5 * motion.period
    if phase < half:
        return 0.5 * motion.acceleration * phase * (half - phase)
    return -0.5 * motion.acceleration * (phase - half) * (motion.period - phase)


def speed_at(motion, t):
    """Its derivative [m/s]."""
    phase = (t + motion.lead) % motion.period
    if phase < 0.5 * motion.period:
        return motion.acceleration * (0.25 * motion.period - phase)
    return motion.acceleration * (phase - 0.75 * motion.period)


def of_case(gamma, frequency, gravity, ramp, lead=0.0):
    """The motion of a case; `lead` is a key of its own."""
    if ramp:
        raise ValueError("ramp: this motion does not grow")
    return Parabolas(gamma * gravity, 1.0 / frequency, lead)


def register():
    """Make it known to this process."""
    register_motion("parabolas", Parabolas, place_at, speed_at, of_case, {"lead": "s"})


CASE = {"motion.kind": "parabolas", "motion.gamma": 5, "motion.lead": "1 ms"}  # 40 Hz


WRONG = {
    "this motion does not grow": {"motion.ramp": 2},
    "unit is wrong": {"motion.lead": "1 mm"},
    "unknown key 'led'; did you mean 'lead'?": {"motion.led": "1 ms"},
    "kind = 'square': must be 'sines' or 'parabolas'": {
        "motion.kind": "square", "motion.lead": None,
    },
}  # fmt: skip


def refused(change):
    """The line that refuses a case with a change; a key that is None is left out."""
    changes = {key: value for key, value in {**CASE, **change}.items() if value is not None}
    try:
        DamperCase.load("thesis", changes)
    except InputError as error:
        return str(error)
    return "nothing is wrong"


def found(case, result) -> dict[str, Any]:
    """What became of a case that is shaken by it."""
    stored = read_trajectory(result.run_folder)
    ours, sines = DamperCase.load("thesis", CASE), DamperCase.load("thesis")
    return {
        "again": DamperCase.load(Path(result.run_folder) / "case.toml").shaker == case.shaker,
        "time": stored["time"].tolist(), "displacement": stored["displacement"].tolist(),
        "asked": [displacement(case.shaker, 0.013), velocity(case.shaker, 0.013)],
        "other_folder": str(ours.identity()) != str(sines.identity()),
        "refused": [refused(change) for change in WRONG.values()],
        "extends": Path(__file__).resolve() in extensions(ENGINE),
    }  # fmt: skip


MOTION = of_case(5.0, 40.0, 9.81, 0.0, lead=1e-3)  # of the case


def test_velocity_is_the_derivative():
    h = 1e-8
    for t in np.linspace(1e-5, 0.0399, 57):
        slope = (place_at(MOTION, t + h) - place_at(MOTION, t - h)) / (2 * h)
        assert speed_at(MOTION, t) == pytest.approx(slope, rel=1e-5, abs=1e-5)


def test_a_case_is_shaken_by_it(extended_damper):
    """The enclosure moved along the parabolas, and the balance of energy closes."""
    found = extended_damper["motion"]
    expected = [place_at(MOTION, t) for t in found["time"]]
    np.testing.assert_allclose(found["displacement"], expected, rtol=1e-9, atol=1e-12)
    assert abs(extended_damper["closure"]) < 0.02
    assert found["asked"] == pytest.approx([place_at(MOTION, 0.013), speed_at(MOTION, 0.013)])


def test_the_case_is_kept_with_its_own_keys(extended_damper):
    """A run of another kind has a folder of its own."""
    found = extended_damper["motion"]
    assert found["again"]
    assert found["other_folder"]


def test_its_file_counts_as_a_source(extended_damper):
    assert extended_damper["motion"]["extends"]


def test_what_is_wrong_is_one_line(extended_damper):
    for words, line in zip(WRONG, extended_damper["motion"]["refused"], strict=True):
        assert words in line
        assert "\n" not in line
