"""A motion from outside the package: a parabolic wave, described, registered and run in one file.

Its acceleration is a square wave, so that its velocity is a triangle. The same goes for any other:
a named tuple with its numbers, displacement and velocity as functions of these and of time, one
that makes the tuple of a case, and one call of register_motion. The file is run as a script, so
that the motion is not known to the other tests.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from damper3d import DamperCase, register_motion, run
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


CASE = {
    "enclosure.diameter": "20 mm",
    "enclosure.height": "20 mm",
    "particles.count": 12,
    "fill.settle_time": "20 ms",
    "motion.kind": "parabolas",
    "run.cycles": 2,
    "run.discard": 1,
    "output.samples": 40,
}


WRONG = {
    "this motion does not grow": {"motion.ramp": 2},
    "unit is wrong": {"motion.lead": "1 mm"},
    "unknown key 'led'; did you mean 'lead'?": {"motion.led": "1 ms"},
    "kind = 'square': must be 'sines' or 'parabolas'": {"motion.kind": "square"},
}


def refused(change):
    """The line that refuses a case with a change."""
    try:
        DamperCase.load("thesis", {**CASE, **change})
    except InputError as error:
        return str(error)
    return "nothing is wrong"


def main():
    """Shake a small damper by it, and say what became of it."""
    register_motion("parabolas", Parabolas, place_at, speed_at, of_case, {"lead": "s"})
    case = DamperCase.load("thesis", {**CASE, "motion.lead": "1 ms"})
    sines = DamperCase.load("thesis", {**CASE, "motion.kind": "sines"})
    with tempfile.TemporaryDirectory() as out:
        result = run(case, out=out)
        stored = read_trajectory(result.run_folder)
        again = DamperCase.load(Path(result.run_folder) / "case.toml").shaker == case.shaker
    found = {
        "closure": result.energy_closure, "again": again,
        "time": stored["time"].tolist(), "displacement": stored["displacement"].tolist(),
        "asked": [displacement(case.shaker, 0.013), velocity(case.shaker, 0.013)],
        "other_folder": str(case.identity()) != str(sines.identity()),
        "refused": [refused(change) for change in WRONG.values()],
        "extends": Path(__file__).resolve() in extensions(ENGINE),
    }  # fmt: skip
    print(json.dumps(found))


@pytest.fixture(scope="module")
def found():
    done = subprocess.run([sys.executable, __file__], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


MOTION = of_case(20.0, 40.0, 9.81, 0.0, lead=1e-3)  # of the case


def test_velocity_is_the_derivative():
    h = 1e-8
    for t in np.linspace(1e-5, 0.0399, 57):
        slope = (place_at(MOTION, t + h) - place_at(MOTION, t - h)) / (2 * h)
        assert speed_at(MOTION, t) == pytest.approx(slope, rel=1e-5, abs=1e-5)


def test_a_case_is_shaken_by_it(found):
    """The enclosure moved along the parabolas, and the balance of energy closes."""
    expected = [place_at(MOTION, t) for t in found["time"]]
    np.testing.assert_allclose(found["displacement"], expected, rtol=1e-9, atol=1e-12)
    assert abs(found["closure"]) < 0.02
    assert found["asked"] == pytest.approx([place_at(MOTION, 0.013), speed_at(MOTION, 0.013)])


def test_the_case_is_kept_with_its_own_keys(found):
    """A run of another kind has a folder of its own."""
    assert found["again"]
    assert found["other_folder"]


def test_its_file_counts_as_a_source(found):
    assert found["extends"]


def test_what_is_wrong_is_one_line(found):
    for words, line in zip(WRONG, found["refused"], strict=True):
        assert words in line
        assert "\n" not in line


if __name__ == "__main__":
    main()
