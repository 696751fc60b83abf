"""Answers that cannot be are refused, unusual ones warned of; units wherever they stand."""

import math

import numpy as np
import pytest
from bench_calls import write
from calibrating import calibrate
from made_tracks import made_track
from refusals import assert_refused, assert_refuses

from calibration.files.track_table import read_tracks
from calibration.flow.discharge import Crossing
from calibration.flow.tracers import outlet_columns
from calibration.result import finish
from damper3d.engine.enclosures import cylinder
from damper3d.run.packing import packing_fraction
from granulab.campaign.output.ranges import judged, ranges
from granulab.errors import InputError


def test_every_range_holds_what_its_experiment_finds():
    """The experiment's range lies in that of physics; both are ranges; each says why and a cure."""
    for of in ("calibration", "silo2d", "damper3d"):
        assert ranges(of)
        for one in ranges(of):
            (low, high), (least, most) = one.physics, one.experiment
            assert low < high
            assert least < most
            if math.inf not in (high, most):
                assert low - one.slack <= least < most <= high + one.slack
            assert one.why
            assert one.cure


def restitution(value, sigma, each=(), sigmas=()):
    return {
        "restitution": {
            "value": value, "sigma": sigma, "per_collision": list(each),
            "per_collision_sigma": list(sigmas),
        }
    }  # fmt: skip


IMPOSSIBLE = [
    ("calibration", restitution(0.704, 0.041, [0.456, 0.464, 1.573], [0.02, 0.02, 0.3]),
     ["restitution.per_collision.2 = 1.573", "0 to 1"]),
    ("calibration", restitution(-0.157, 0.01), ["restitution.value = -0.157"]),
    ("calibration", restitution(1.05, 0.01), ["restitution.value = 1.05", "sigma 0.01"]),
    ("calibration", {"string_length_m": 724.0}, ["string_length_m = 724", "--fps"]),
    ("calibration", {"string_length": {"value": -3.0, "sigma": 1.0}}, ["string_length.value = -3"]),
    ("calibration", {"density_kg_m3": {"value": math.inf, "sigma": None}}, ["= inf"]),
    ("calibration", {"outlet_over_width": 1.2}, ["outlet_over_width = 1.2", "--roi"]),
    ("silo2d", {"packing_fraction": 1.18}, ["packing_fraction = 1.18", "0 to 1"]),
    ("damper3d", {"packing": {"fraction": 1.18}}, ["packing.fraction = 1.18", "0 to 1"]),
    ("damper3d", {"efficiency": 6.75}, ["efficiency = 6.75"]),
]  # fmt: skip
UNUSUAL = [
    ("calibration", restitution(1.01, 0.02), "restitution.value = 1.01 (sigma 0.02)"),
    ("calibration", {"outlet_over_width": 1.0}, "outlet_over_width = 1"),
    ("calibration", {"string_length_m": 19.0}, "string_length_m = 19"),
    ("calibration", {"bounces": [{"impact_speed_m_s": 313.1}]}, "bounces.0.impact_speed_m_s"),
    ("calibration", {"curve": {"remaining": [1.0, 1.15]}}, "curve.remaining.1 = 1.15: outside -0"),
    ("damper3d", {"law_term": 0.24}, "law_term = 0.24"),
]
USUAL = [
    ("calibration", restitution(0.53, 0.02, [0.5, 0.56], [0.03, 0.03])),
    ("calibration", {"string_length_m": None, "discharge_time_s": None}),
    ("calibration", {"curve": {"remaining": [1.001, 0.5, -0.01]}}),  # noise of a film's ends
    ("silo2d", {"packing_fraction": 0.85}),
    ("damper3d", {"efficiency": None, "law_term": 0.05, "packing": {"fraction": 0.58}}),
]


@pytest.mark.parametrize(("of", "answers", "words"), IMPOSSIBLE)
def test_an_impossible_answer_is_refused(of, answers, words):
    assert_refuses(words, judged, of, answers)


@pytest.mark.parametrize(("of", "answers", "words"), UNUSUAL)
def test_an_unusual_answer_is_warned_of(of, answers, words):
    (line,) = judged(of, answers)
    assert line.startswith(words)
    assert "\n" not in line


@pytest.mark.parametrize(("of", "answers"), USUAL)
def test_a_usual_answer_passes_without_a_word(of, answers):
    assert judged(of, answers) == []


def test_a_command_ends_without_an_impossible_answer(capsys):
    """Nothing is printed; a mere warning is, in text and JSON."""

    class Found:
        """A result of one number."""

        def __init__(self, value):
            self.value = value

        def to_dict(self):
            """It."""
            return {"string_length_m": self.value, "warnings": ["old"]}

        def text(self):
            """It in words."""
            return "string"

    with pytest.raises(InputError, match=r"a\.csv: string_length_m = 724"):
        finish(Found(724.0), as_json=True, figure_key=None, measured=["a.csv"])
    assert capsys.readouterr().out == ""
    finish(Found(19.0), as_json=True, figure_key=None)
    assert '"old",\n' in capsys.readouterr().out
    finish(Found(19.0), as_json=False, figure_key=None)
    assert "warning: string_length_m = 19" in capsys.readouterr().out


def track_table(head, units="", factor=1.0):
    """A bouncing ball at 240 frames/s; lengths of 1 mm a pixel; times in s times a factor."""
    track = made_track([0.7, 0.7, 0.7]).track
    rows = zip(track.frame / 240 * factor, track.x, track.y, strict=True)
    lines = [head, *([units] if units else []), *(f"{t:.6f},{x:.4f},{y:.4f}" for t, x, y in rows)]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("text", "options"),
    [
        (track_table("time [ms],x [mm],y [mm]", factor=1e3), ()),
        (track_table("time,x,y", "ms,mm,mm", factor=1e3), ()),
        (track_table("time,x,y", "[ms],[mm],[mm]", factor=1e3), ()),
        (track_table("time,x,y", factor=1e3),
         ("--unit", "time=ms", "--unit", "x=mm", "--unit", "y=mm")),
        (track_table("time_s,x_mm,y_mm"), ()),
    ],
)  # fmt: skip
def test_units_of_a_track_are_read_wherever_they_stand(tmp_path, text, options):
    (tmp_path / "t.csv").write_text(text, encoding="utf-8")
    found = calibrate("drop", tmp_path / "t.csv", "--json", *options).json
    assert found["fps_used"] == pytest.approx(240, rel=1e-4)
    assert found["bounces"][0]["impact_speed_m_s"] == pytest.approx(
        1e-3 * 2 * 500 / 40.3 * 240, rel=0.01
    )
    assert not any("without a unit" in warning for warning in found["warnings"])


def test_a_track_without_units_says_what_was_assumed(tmp_path):
    (tmp_path / "t.csv").write_text(track_table("time,x,y"), encoding="utf-8")
    (track,) = read_tracks(tmp_path / "t.csv")
    assert track.remarks == (
        "times without a unit: read as seconds", "x and y without a unit of length: read as pixels",
    )  # fmt: skip
    text = track_table("time [s],x [mm],y")
    (tmp_path / "t.csv").write_text(text, encoding="utf-8")
    assert_refuses(["x and y"], read_tracks, tmp_path / "t.csv")
    assert_refused(calibrate("drop", tmp_path / "t.csv", "--unit", "time=kg"), "unit is wrong")
    assert_refused(calibrate("drop", tmp_path / "t.csv", "--unit", "z=mm"), "no such column")
    assert_refused(calibrate("drop", tmp_path / "t.csv", "--unit", "x=nan"), "--unit = 'x=nan'")


@pytest.mark.parametrize("field", ["1e308", "-1e308", "1e31"])
def test_a_sample_that_no_instrument_writes_is_refused(tmp_path, field):
    time = [k / 1000 for k in range(200)]
    force = [0.0] * 100 + [field] + [0.0] * 99
    table = write(tmp_path / "s.csv", "time [s];force [N]", [time, force])
    assert_refused(calibrate("impacts", table), "no instrument")
    moved = [math.sin(k) for k in range(200)]
    table = write(
        tmp_path / "s.csv", "time [s];force [N];acceleration [m/s2]", [time, force, moved]
    )
    assert_refused(calibrate("shaker", table), "no shaker")


def test_an_outlying_x_of_a_profile_is_remarked(tmp_path):
    x = np.linspace(0, 2, 400)
    z = 5 * np.sin(40 * x)
    even = write(tmp_path / "even.csv", "x [mm];z [um]", [x, z])
    x[200] = 3.0
    odd = write(tmp_path / "odd.csv", "x [mm];z [um]", [x, z])
    remarks = [
        calibrate("roughness", table, "--json").json["ra_m"]["remarks"] for table in (even, odd)
    ]
    assert not any("slip in x" in line for line in remarks[0])
    assert any("between x = 0.002 m and 0.003 m" in line for line in remarks[1])


@pytest.mark.parametrize("n", [1, 4, 8, 30])
def test_a_few_spheres_on_a_floor_do_not_fill_more_than_the_space_they_have(n):
    """Side by side, in one layer: of each the cap below the level counts, and no more."""
    radius = 2.5e-3
    side = math.ceil(math.sqrt(n))
    spots = np.array([(i, j) for i in range(side) for j in range(side)][:n], float)
    centres = np.column_stack([2 * radius * (spots - (side - 1) / 2), np.full(n, radius)])
    box = cylinder(2.0 * side * radius * math.sqrt(2), 0.04)
    volume = 4 / 3 * math.pi * radius**3
    found = packing_fraction(centres, volume, box, np.array([0.0, 0.0, 1.0]))
    # half spheres over a slice as high as their radius: 2/3 of the area that they cover
    covered = n * radius**2 / (side * radius * math.sqrt(2)) ** 2
    assert found == pytest.approx(2 / 3 * covered, rel=0.03)  # 64 cells a side at the round wall


def test_nothing_at_the_outlet_is_refused_and_is_no_outlet_of_full_width():
    class Silo:
        """Ten by ten pixels."""

        box = slice(0, 10), slice(0, 10)

    with pytest.raises(InputError, match="--roi"):
        outlet_columns(np.zeros((10, 10), bool), Silo(), 2.0)


def test_what_crosses_in_the_last_frame_is_not_over():
    crossing = Crossing(10.0)
    assert not crossing.over(0.0)
    crossing.see(3.0, np.ones(20, bool), np.ones(1))
    assert not crossing.over(3.0)
    crossing.see(4.0, np.zeros(20, bool), np.ones(1))
    assert crossing.over(4.0)
