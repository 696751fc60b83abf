"""Restitution from heights of drop and rebound, in the layouts that laboratories write."""

import math
from pathlib import Path

import numpy as np
import pytest
from calibrating import calibrate
from refusals import assert_refused

MEDIA = Path(__file__).parents[3] / "shared" / "media"
needs_media = pytest.mark.skipif(not MEDIA.is_dir(), reason=f"no recordings in {MEDIA}")

TABLE_2 = """H0 (mm)\t18.92\t44.55\t45.48
Particle A Mean\t0.85\t0.60\t0.59
SD (%)\t2\t4\t3
Particle B Mean\t0.39\t0.42\t0.48
SD (%)\t6\t12\t7
Particle C Mean\t0.47\t0.56\t0.42
SD (%)\t10\t8\t13
Average Mean\t0.56\t0.53\t0.49
SD (%)\t35\t17\t16
"""
AS_ROWS = """particle,H0_mm,mean,sd_percent
A,18.92,0.85,2
A,44.55,0.60,4
A,45.48,0.59,3
B,18.92,0.39,6
B,44.55,0.42,12
B,45.48,0.48,7
C,18.92,0.47,10
C,44.55,0.56,8
C,45.48,0.42,13
"""
TABLE_3 = "H0 [mm];Mean;SD %;n\n69,39;0,47;18;12\n91,27;0,47;6;12\n111,14;0,41;22;12\n"


def heights(tmp_path, text, *options):
    path = tmp_path / "heights.csv"
    path.write_text(text, encoding="utf-8")
    return calibrate("heights", path, *options, "--json").json


def test_restitution_is_the_root_of_the_heights_and_takes_their_reading_errors(tmp_path):
    """sqrt(H1/H0) = 0.8; de = e/2 (dH1/H1) for a reading that each trial has of its own."""
    found = heights(tmp_path, "H0 [cm],H1 [cm]\n50,32\n", "--reading", "h1=2 mm")["restitution"]
    assert found["value"] == pytest.approx(0.8, rel=1e-14)
    assert found["sigma"] == pytest.approx(0.4 * 2 / 320, rel=1e-4)  # a difference over 2 mm
    assert found["constant_within_noise"] is None


def test_what_all_trials_share_widens_the_mean_over_particles(tmp_path):
    """Variances add: that of the particles' mean, and that of heights all read 1 mm too high."""
    text = "particle,H0 [mm],H1 [mm]\n" + "".join(
        f"{name},{h0},{share * h0 + by}\n"
        for name, share in (("A", 0.5), ("B", 0.4))
        for h0 in (20, 40)
        for by in (-0.3, 0.3)
    )
    alone = heights(tmp_path, text)["restitution"]
    found = heights(tmp_path, text, "--instrument", "h1=1 mm")["restitution"]
    shared = found["sigma_shared"]["h1"]
    # de = e/2 dH1/H1 at 0.71 and 0.63, in the mean of 20 and 40 mm; exact but for the half mm
    assert shared == pytest.approx(np.mean([0.5**0.5 / 0.5, 0.4**0.5 / 0.4]) / 2 * 0.0375, rel=0.01)
    assert found["sigma"] == pytest.approx(math.hypot(alone["sigma"], shared), rel=1e-9)


def test_pendulum_of_two_blocks_by_its_three_heights(tmp_path):
    """(sqrt(H2) - sqrt(H1))/sqrt(H0) (eq. 3.6): (sqrt(49) - sqrt(4))/sqrt(100) = 0.5."""
    found = heights(tmp_path, "H0_mm,H1_mm,H2_mm\n100,4,49\n100,0,25\n")
    assert [one["value"] for one in found["restitution"]["per_trial"]] == pytest.approx([0.5, 0.5])


@pytest.mark.parametrize("text", [TABLE_2, AS_ROWS])
def test_the_papers_table_of_means_gives_its_mean_of_all(tmp_path, text):
    """Nine means of ten: 0.53 as printed. They differ: sigma is that of nine means."""
    found = heights(tmp_path, text, "--constant", "trials=10")
    means = [0.85, 0.60, 0.59, 0.39, 0.42, 0.48, 0.47, 0.56, 0.42]
    assert found["restitution"]["value"] == pytest.approx(np.mean(means), rel=1e-12)
    assert round(found["restitution"]["value"], 2) == 0.53
    assert found["restitution"]["trials"] == 90
    assert found["restitution"]["constant_within_noise"] is False
    assert found["per_height"][1]["height_m"] == pytest.approx(44.55e-3)
    assert found["per_height"][1]["scatter"] == pytest.approx(0.04 * 0.60)


def test_the_papers_pendulum_gives_its_mean_of_all(tmp_path):
    found = heights(tmp_path, TABLE_3)
    assert round(found["restitution"]["value"], 2) == 0.45
    assert found["restitution"]["constant_within_noise"] is True


def test_a_column_a_drop_height_is_the_same_as_a_row_a_trial(tmp_path):
    wide = heights(tmp_path, "H0 [cm];65;55\n;49,6;42,7\n;49,0;43\nmean;49,3;42,9\n")
    rows = "drop height [cm];rebound height [cm]\n65;49,6\n65;49,0\n55;42,7\n55;43\n"
    long = heights(tmp_path, rows)
    assert [one["n"] for one in wide["per_height"]] == [2, 2]
    for one, other in zip(wide["per_height"], long["per_height"], strict=True):
        assert one["value"] == pytest.approx(other["value"], rel=1e-12)
        assert one["group"] == other["group"]


@needs_media
def test_rebounds_read_by_eye_agree_with_what_others_found():
    """Ten rebounds at each of five heights, +- 0.008 each; one number does not describe them."""
    found = calibrate("heights", MEDIA / "heights_blue_ball.csv", "--json").json
    reference = {0.65: 0.874, 0.55: 0.874, 0.45: 0.913, 0.35: 0.893, 0.25: 0.861}
    for one in found["per_height"]:
        wanted = reference[round(one["height_m"], 3)]
        assert one["value"] == pytest.approx(wanted, abs=0.001)
        assert one["scatter"] == pytest.approx(0.008, abs=0.003)
        assert one["n"] == 10
    assert found["restitution"]["constant_within_noise"] is False


PARTICLES = "H0 [mm];650;450;250\nA;500;330;180\nA;505;335;182\n"
OTHERS = "B;300;200;110\nB;310;205;112\n"


@pytest.mark.parametrize(
    "below",
    [
        "Mittelwert;502,5;332,5;181\nStandardabweichung;3,5;3,5;1,4\n", "std [mm];4;4;1\n",
        "mean;502;332;181\nSD;4;4;1\n", "n;2;2;2\n", "max:;505;335;182\n", "Notes: by hand\n",
    ],
)  # fmt: skip
def test_what_is_made_of_the_trials_above_it_is_no_trial(tmp_path, below):
    """The mean of the six trials alone; a standard deviation of 4 mm would be an e of 0.08."""
    alone = heights(tmp_path, PARTICLES)["restitution"]
    found = heights(tmp_path, PARTICLES + below)["restitution"]
    assert found["value"] == alone["value"]
    assert found["trials"] == 6
    assert sum("left out, a note or made" in one for one in found["remarks"]) == below.count("\n")


def test_only_one_particle_of_a_line_of_heights_is_evaluated(tmp_path):
    alone = heights(tmp_path, PARTICLES)["restitution"]
    found = heights(tmp_path, PARTICLES + OTHERS, "--only", "A")["restitution"]
    assert (found["value"], found["trials"]) == (alone["value"], 6)


def test_labels_that_differ_in_a_number_alone_are_trials(tmp_path):
    """As numbers alone are. Of ten particles of a trial each sigma would be 3.7 times smaller."""
    rows = "500;330;180\n", "505;335;182\n", "495;334;181\n"
    head = "H0 [mm];650;450;250\n"
    plain, named, apart = (
        heights(tmp_path, head + "".join(f"{name}{k};{row}" for k, row in enumerate(rows, 1)))
        for name in ("", "trial ", "particle ")
    )
    assert named["restitution"]["sigma"] == plain["restitution"]["sigma"]
    assert any("of one particle" in words for words in named["restitution"]["remarks"])
    assert any("each label is a particle" in one for one in apart["restitution"]["remarks"])


@pytest.mark.parametrize(
    "head", ["sd [%]", "std [%]", "SD %", "sd_percent", "Standardabweichung [%]"]
)
def test_a_standard_deviation_in_per_cent_is_one_of_the_mean(tmp_path, head):
    """17 % of 0.53 are 0.0901."""
    found = heights(tmp_path, f"H0 [mm];mean;{head};n\n650;0.53;17;10\n")["restitution"]
    assert found["scatter"] == pytest.approx(0.17 * 0.53, rel=1e-12)


def test_columns_of_a_summary_leave_no_trial_out(tmp_path):
    """Mean and SD that a spreadsheet has in the first row are not of that row."""
    rows = [180, 190, 200, 185, 210]
    text = "H0 [mm];H1 [mm];mean;SD\n" + "".join(
        f"500;{h};{'0.62;0.02' if h == 180 else ';'}\n" for h in rows
    )
    found = heights(tmp_path, text)["restitution"]
    assert found["trials"] == 5
    assert found["value"] == pytest.approx(np.mean([math.sqrt(h / 500) for h in rows]))


def test_a_mean_over_particles_is_no_better_known_than_by_its_readings(tmp_path):
    """Like trials share the error of their reading, de = e/2 (2 mm/H1); six cells of it."""
    text = "particle;H0 [mm];H1 [mm]\n" + "".join(
        f"{name};{h0};{h1}\n" * 3 for name in "ABC" for h0, h1 in ((50, 12), (30, 8))
    )
    found = heights(tmp_path, text, "--reading", "h1=2 mm")["restitution"]
    each = [math.sqrt(h1 / h0) / h1 for h0, h1 in ((50, 12), (30, 8))]
    assert found["sigma"] == pytest.approx(math.sqrt(3 * sum(e**2 for e in each)) / 6, rel=0.01)


def test_a_reading_as_large_as_what_it_reads_moves_it_to_one_side(tmp_path):
    """(sqrt(81) - sqrt(0))/sqrt(100) of H1 = 0: 1 mm more makes it less by sqrt(1)/10."""
    text = "H0 [mm];H1 [mm];H2 [mm]\n100;0;81\n"
    found = heights(tmp_path, text, "--reading", "h1=1 mm")["restitution"]
    assert found["sigma"] == pytest.approx(0.1, rel=1e-9)


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        (PARTICLES, ("--group", "H0"), ["line of drop heights", "--group does not go with it"]),
        (PARTICLES, ("--only", "C"), ["--only C"]),
        (TABLE_3, ("--reading", "mean=0.2"), ["do not go with means"]),
        (TABLE_3, ("--constant", "trials=3 +- 1"), ["do not go with means"]),
        ("H0 [mm];H1 [mm]\n50;32\n", ("--instrument", "h2=1 mm"), ["no trial has h2"]),
    ],
)  # fmt: skip
def test_options_that_a_table_has_no_use_for_are_refused(tmp_path, text, options, words):
    path = tmp_path / "t.csv"
    path.write_text(text)
    assert_refused(calibrate("heights", path, *options), *words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (PARTICLES + "A;5O5;330;180\n", ["line 4", "'5O5' is no number"]),
        (PARTICLES + "A;1.250,5;330,5;180\n", ["'1.250,5' is no number"]),
        (PARTICLES + "A;501,5;330.5;180\n", ["decimal comma", "thousands"]),
        ("H0 [cm],H1 [cm]\n32,50\n", ["H1 = 500 mm is above H0 = 320 mm", "swapped"]),
        ("H0 [cm],H1 [cm]\n32,-5\n", ["H1 = -50 mm", "above 0"]),
        ("H0,H1\n32,5\n", ["the unit is missing", "[m]"]),
        ("H0,50,40\nA,32,20\n", ["H0 has no unit", "H0 [mm]"]),
        ("H0 [mm],H1 [mm],H2 [mm]\n100,49,4\n", ["H2 = 4 mm is below H1", "swap"]),
        ("H0 [mm],mean,sd,trials\n50,1.2,0.1,3\n", ["mean = 1.2", "at most 1"]),
        ("H0 [mm],mean,sd\n50,0.5,0.1\n", ["this needs the columns", "trials"]),
        ("H0 [mm],mean,sd,trials\n50,.5,.1,3\n50,.5,.1,3\n", ["50 mm stands twice", "--group"]),
    ],
)
def test_heights_that_are_none_are_refused(tmp_path, text, words):
    path = tmp_path / "t.csv"
    path.write_text(text)
    assert_refused(calibrate("heights", path), *words)


def test_heights_go_into_a_materials_file(tmp_path):
    table, into = tmp_path / "t.csv", tmp_path / "m.toml"
    table.write_text("H0 [cm],H1 [cm]\n50,32\n50,30\n50,31\n")
    calibrate("heights", table, "--into", into, "--pair", "wood-steel")
    mean = np.mean([math.sqrt(h / 50) for h in (32, 30, 31)])
    assert f"value = {mean:.4g}"[:14] in into.read_text()
