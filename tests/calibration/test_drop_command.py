"""The command calibrate drop on tracks: report, JSON, figure, refusals; recordings of strangers."""

import json
import os
import tomllib
from pathlib import Path

import calibrating
import numpy as np
import pytest
from made_tracks import made_track

MEDIA = Path(os.environ.get("GRANULAB_MEDIA") or Path(__file__).parents[3] / "shared" / "media")
needs_media = pytest.mark.skipif(not MEDIA.is_dir(), reason=f"no recordings in {MEDIA}")
KEYS = {
    "restitution", "bounces", "contact_times_s", "fps_header", "fps_used", "time_base",
    "scale_m_per_px", "gravity_check_m_s2", "plate_drift_px", "warnings", "sheet",
}  # fmt: skip
BOUNCE_KEYS = {
    "contact_time_s", "contact_frame", "from_times", "from_velocities", "from_heights", "sigma",
    "impact_speed_m_s",
}  # fmt: skip


def calibrate(*arguments):
    """Exit code, stdout, stderr; a traceback fails the test."""
    found = calibrating.calibrate(*arguments)
    return found.code, found.out, found.err


def write(path, track, head="frame,x,y"):
    rows = np.stack([track.frame, track.x, track.y], axis=1)
    lines = [",".join(f"{value:.5f}" for value in row) for row in rows]
    path.write_text("\n".join([head, *lines]), encoding="utf-8")
    return path


def test_one_json_object_with_the_keys_that_scripts_rely_on(tmp_path):
    made = made_track([0.7] * 4)
    path = write(tmp_path / "ball.csv", made.track)
    code, out, err = calibrate("drop", path, "--fps", 240, "--json", "-o", tmp_path / "sheets")
    assert (code, err) == (0, "")
    result = json.loads(out)
    assert result.keys() >= KEYS
    assert all(bounce.keys() >= BOUNCE_KEYS for bounce in result["bounces"])
    assert len(result["bounces"]) == len(result["contact_times_s"]) == 4
    assert result["restitution"]["value"] == pytest.approx(0.7, abs=0.01)
    assert result["restitution"]["constant_within_noise"] is True
    assert result["contact_times_s"] == pytest.approx(made.contacts / 240, abs=1e-3)
    times = np.diff(result["contact_times_s"])
    # T(k+1)/T(k) stands with the bounce between the two flights
    assert result["bounces"][1]["from_times"] == pytest.approx(times[1] / times[0], rel=1e-9)
    assert result["bounces"][0]["from_times"] is None
    assert result["fps_header"] is None
    assert result["fps_used"] == 240
    assert result["gravity_check_m_s2"] is None
    figure = Path(result["sheet"])
    assert figure.parent == tmp_path / "sheets"
    assert figure.read_bytes()[:4] == b"\x89PNG"


def test_the_report_says_value_sigma_and_every_bounce(tmp_path):
    code, out, err = calibrate("drop", write(tmp_path / "a.csv", made_track([0.7] * 4).track))
    assert (code, err) == (0, "")
    assert out.startswith("restitution 0.70")
    assert "one number describes the clip" in out
    assert out.count("+-") > 8
    assert "neither rate nor scale" in out


def test_seconds_in_the_table_are_the_rate(tmp_path):
    track = made_track([0.7] * 4).track
    path = tmp_path / "t.csv"
    lines = [
        f"{f / 120:.6f};{y:.4f}".replace(".", ",")
        for f, y in zip(track.frame, track.y, strict=True)
    ]
    path.write_text("\n".join(["t [s];y", *lines]), encoding="utf-8")
    result = json.loads(calibrate("drop", path, "--json")[1])
    assert result["fps_header"] == pytest.approx(120, rel=1e-3)
    assert result["scale_m_per_px"] > 0
    doubled = json.loads(calibrate("drop", path, "--json", "--fps", 240)[1])
    assert doubled["fps_used"] == 240
    assert doubled["scale_m_per_px"] == pytest.approx(result["scale_m_per_px"] / 4, rel=1e-2)


def test_the_pooled_value_goes_into_a_parameter_file(tmp_path):
    path = write(tmp_path / "ball.csv", made_track([0.7] * 4).track)
    wood = tmp_path / "wood.toml"
    code, out, err = calibrate("drop", path, "--json", "--into", wood, "--pair", "wood-acrylic")
    assert code == 0, err
    (stored,) = tomllib.loads(wood.read_text(encoding="utf-8"))["pair"].values()
    value = json.loads(out)["restitution"]["value"]
    assert stored["restitution"]["value"] == pytest.approx(value, abs=1e-3)
    assert stored["restitution"]["method"] == "drop test"
    assert stored["restitution"]["source"] == "ball.csv"


def test_two_objects_that_bounce_are_distinguished_by_name(tmp_path):
    a, b = made_track([0.7] * 4).track, made_track([0.5] * 3, seed=2).track
    n = min(len(a.frame), len(b.frame))
    rows = np.stack([a.frame[:n], a.x[:n], a.y[:n], 300 + b.x[:n], b.y[:n]], axis=1)
    lines = [",".join(f"{value:.4f}" for value in row) for row in rows]
    path = tmp_path / "two.csv"
    path.write_text("\n".join(["frame,x1,y1,x2,y2", *lines]), encoding="utf-8")
    code, out, err = calibrate("drop", path)
    assert (code, out) == (2, "")
    assert "2 objects bounce: choose one with --track ('1': 0.700" in err
    result = json.loads(calibrate("drop", path, "--track", "2", "--json")[1])
    assert result["restitution"]["value"] == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--fps", "0"], "--fps = 0.0"),
        (["--fps", "0 kHz"], "--fps = 0.0"),
        (["--fps", "nan"], "--fps = nan"),
        (["--fps", "fast"], "--fps = 'fast': not a quantity"),
        (["--scale", "0.8 mm"], "a length per pixel"),
        (["--scale", "0.8 s/px"], "the unit is wrong"),
        (["--scale", "-1 mm/px"], "must be positive"),
        (["--track", "9"], "no track '9'"),
        (["--roi", "0,0,9,9"], "--roi is of a film's pictures"),
        (["--at", "0,1,2"], "--at is of a film's pictures"),
    ],
)
def test_bad_options_are_refused_in_one_line(tmp_path, options, words):
    path = write(tmp_path / "ball.csv", made_track([0.7] * 4).track)
    code, out, err = calibrate("drop", path, *options)
    assert (code, out) == (2, "")
    assert err.startswith("calibrate: ")
    assert words in err
    assert err.count("\n") == 1


def test_no_film_and_a_single_bounce_are_refused_in_one_line(tmp_path):
    film = tmp_path / "film.mp4"
    film.write_bytes(b"\x00\x00\x00\x18ftypmp42\xff\xfe" * 20)
    once = write(tmp_path / "once.csv", made_track([0.7]).track)
    for path, words in ((film, "no film"), (once, "--one-bounce")):
        code, out, err = calibrate("drop", path)
        assert (code, out) == (2, "")
        assert words in err
        assert err.count("\n") == 1
    assert calibrate("drop", once, "--one-bounce")[0] == 0


def test_a_folder_of_track_tables_is_a_test_of_several_trials(tmp_path):
    for k in range(2):
        write(tmp_path / f"{k}.csv", made_track([0.7] * 4, seed=k).track)
    found = json.loads(calibrate("drop", tmp_path, "--json")[1])["restitution"]
    assert found["trials"] == 2
    assert found["value"] == pytest.approx(0.7, abs=0.01)


@needs_media
def test_marble_on_sixty_sheets_as_measured_by_others():
    """A4_1-60: contacts 80.72, 147.36, 182.63, e = 0.529, their sigma 0.01.

    Contacts to 0.15 frame: their own fit of each flight differs from ours in what it leaves out.
    """
    result = json.loads(calibrate("drop", MEDIA / "A4_1-60-M.csv", "--json")[1])
    frames = [bounce["contact_frame"] for bounce in result["bounces"]]
    assert frames[:3] == pytest.approx([80.72, 147.36, 182.63], abs=0.15)
    assert result["bounces"][1]["from_times"] == pytest.approx(0.529, abs=0.01)
    assert result["restitution"]["value"] == pytest.approx(0.529, abs=0.01)


@needs_media
def test_marble_on_a_hundred_sheets_as_measured_by_others():
    """V_100: contacts 231.31, 282.46, 317.50, 342.77, e = 0.685, 0.721, their sigma 0.01."""
    result = json.loads(calibrate("drop", MEDIA / "V_18-7_Results_100_1018.csv", "--json")[1])
    frames = [bounce["contact_frame"] for bounce in result["bounces"]]
    assert frames == pytest.approx([231.31, 282.46, 317.50, 342.77], abs=0.15)
    e = [bounce["from_times"] for bounce in result["bounces"][1:3]]
    assert e == pytest.approx([0.685, 0.721], abs=0.01)
    assert result["restitution"]["constant_within_noise"] is False


@needs_media
def test_a_marble_among_flickering_spots_is_found_and_its_lost_time_said():
    """A4_1-1: pairs change places among six columns; three frame numbers took no time."""
    result = json.loads(calibrate("drop", MEDIA / "A4_1-1-M.csv", "--json")[1])
    assert len(result["bounces"]) == 3
    assert len(result["time_base"]["duplicated_frames"]) == 3
    assert any("linked" in line for line in result["warnings"])
