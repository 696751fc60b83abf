"""Friction, density and kt/kn, a row a trial: closed forms, groups, and what instruments add."""

import math

import numpy as np
import pytest
from bench_calls import write
from calibrating import calibrate

from granulab.contact.files.datafile import data_root

MARKERS = data_root() / "published" / "interface_markers.csv"


def test_friction_is_the_tangent_of_the_angle_of_slip(tmp_path):
    """Paper sec. 3.1: mu = tan(alpha); floats only."""
    tilt = write(tmp_path / "t.csv", "angle_deg", [[20.0, 25.0, 30.0]])
    found = calibrate("incline", tilt, "--json").json
    mu = [math.tan(math.radians(a)) for a in (20, 25, 30)]
    assert [one["value"] for one in found["friction"]["per_trial"]] == pytest.approx(mu, rel=1e-14)
    assert found["friction"]["value"] == pytest.approx(np.mean(mu), rel=1e-14)
    assert found["friction"]["scatter"] == pytest.approx(np.std(mu, ddof=1), rel=1e-12)


@pytest.mark.parametrize(("along", "length"), [("slope", 300.0), ("base", 300.0 * math.cos(0.36))])
def test_heights_and_length_give_the_angle_they_were_made_from(tmp_path, along, length):
    """H1 - H2 = 300 mm sin(0.36) over 300 mm of slope, or 300 mm cos(0.36) of base."""
    h2 = 300 * math.sin(0.36) + 40
    table = write(tmp_path / "t.csv", "H1_mm;H2_mm;L_mm", [[40.0], [h2], [length]])
    found = calibrate(
        "incline", table, "--column", "length=L_mm [mm]", "--length-along", along, "--json"
    ).json
    assert found["friction"]["value"] == pytest.approx(math.tan(0.36), rel=1e-12)
    assert found["friction"]["sigma"] is None  # one trial, and no reading has an uncertainty
    assert f"along the {along}" in found["friction"]["remarks"][0]


def test_what_all_trials_share_is_no_smaller_for_many_trials(tmp_path):
    """d(tan a) = da/cos^2 a: 0.5 deg at 20 deg; central differences are right to da^2: 1e-3."""
    table = write(tmp_path / "t.csv", "angle_deg", [[20.0] * 40])
    found = calibrate("incline", table, "--instrument", "angle=0.5 deg", "--json").json
    expected = math.radians(0.5) / math.cos(math.radians(20)) ** 2
    assert found["friction"]["sigma"] == pytest.approx(expected, rel=1e-3)
    assert found["friction"]["sigma_shared"]["angle"] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(
    ("degrees", "share"), [([20, 20, 20], 1.0), ([19.999, 20.0, 20.001], 3**-0.5)]
)
def test_a_mean_is_no_better_known_than_by_its_readings(tmp_path, degrees, share):
    """d(tan) = (1 + tan^2) of 0.5 deg, over sqrt(3); like readings to the degree share theirs."""
    table = write(tmp_path / "t.csv", "angle_deg", [degrees])
    found = calibrate("incline", table, "--reading", "angle=0.5 deg", "--json").json["friction"]
    of_one = math.radians(0.5) / math.cos(math.radians(20)) ** 2
    assert found["sigma"] == pytest.approx(share * of_one, rel=1e-3)


def test_a_reading_is_the_sigma_of_a_single_trial(tmp_path):
    table = write(tmp_path / "t.csv", "angle_deg", [[20.0]])
    found = calibrate("incline", table, "--reading", "angle=0.5 deg", "--json").json
    expected = math.radians(0.5) / math.cos(math.radians(20)) ** 2
    assert found["friction"]["sigma"] == pytest.approx(expected, rel=1e-3)


def test_friction_covers_the_truth_in_68_percent(tmp_path):
    """Ten trials with 2 deg of scatter, an instrument 0.7 deg off: 300 tables, 68 +- 3 x 2.7 %.

    tan bends: the mean of tan is 0.06 % above the tan of the mean, far below sigma (3 %).
    """
    rng = np.random.default_rng(5)
    covered = 0
    for k in range(300):
        angles = 21 + rng.normal(0, 2, 10) + rng.normal(0, 0.7)
        table = write(tmp_path / f"{k}.csv", "angle_deg", [angles])
        one = calibrate("incline", table, "--instrument", "angle=0.7 deg", "--json").json
        covered += (
            abs(one["friction"]["value"] - math.tan(math.radians(21))) <= (one["friction"]["sigma"])
        )
    assert 0.60 <= covered / 300 <= 0.76


def test_pairings_are_distinguished_and_tested(tmp_path):
    pairings = ["a"] * 4 + ["b"] * 4
    angles = [20.0, 20.2, 19.8, 20.1, 25.0, 25.1, 24.9, 25.2]
    table = write(tmp_path / "t.csv", "pairing;angle_deg", [pairings, angles])
    found = calibrate("incline", table, "--json").json
    assert list(found["friction"]["groups"]) == ["a", "b"]
    assert found["friction"]["groups_alike"] is False
    assert found["friction"]["groups"]["a"]["trials"] == 4
    said = calibrate("incline", table).out
    assert "the groups differ: each counts once (analysis of variance: p =" in said


def test_markers_of_table_1_within_the_rounding_of_their_displacements():
    """Eq. 3.3. Displacements are printed to 0.01 mm, so each may be 0.005 mm off: the printed ratio
    (to 0.01, 0.005 off) lies between the extremes. The means are 0.28 +- 0.09 and 0.065 +- 0.04.
    """
    found = calibrate("interface", MARKERS, "--group", "surface", "--json").json
    lines = [line for line in MARKERS.read_text().splitlines() if line[:4] in ("flat", "roug")]
    for line, one in zip(lines, found["kt_over_kn"]["per_trial"], strict=True):
        dx_t, dx_n, sigma_t, sigma_n, _, _, printed = (abs(float(v)) for v in line.split(",")[2:])
        assert one["value"] == pytest.approx(sigma_t / sigma_n * dx_n / dx_t, rel=1e-12)
        low = sigma_t / sigma_n * (dx_n - 0.005) / (dx_t + 0.005) - 0.005
        high = sigma_t / sigma_n * (dx_n + 0.005) / (dx_t - 0.005) + 0.005
        assert low <= printed <= high, line
    flat, rough = found["kt_over_kn"]["groups"]["flat"], found["kt_over_kn"]["groups"]["rough"]
    assert (round(flat["value"], 2), round(flat["scatter"], 2)) == (0.28, 0.09)
    assert (round(rough["value"], 3), round(rough["scatter"], 2)) == (0.065, 0.04)


@pytest.mark.parametrize(
    ("head", "sizes"),
    [
        ("volume_cm3", [6.0]),
        ("area_mm2;length_mm", [50.0, 120.0]),
        ("length_mm;width_mm;height_mm", [120.0, 5.0, 10.0]),
        ("diameter_mm;length_mm", [math.sqrt(4 * 50 / math.pi), 120.0]),
        ("diameter_mm", [(6 * 6000 / math.pi) ** (1 / 3)]),
    ],
)
def test_density_is_mass_over_volume(tmp_path, head, sizes):
    """2.7 g in 6 cm3 are 450 kg/m3, as a prism, cylinder, sphere or volume; floats only."""
    table = write(tmp_path / "t.csv", f"mass_g;{head}", [[2.7], *([v] for v in sizes)])
    found = calibrate("density", table, "--json").json
    assert found["density_kg_m3"]["value"] == pytest.approx(450, rel=1e-12)


def test_shares_of_mass_and_volume_add_as_squares(tmp_path):
    """rho = m/V: sigma/rho = hypot(1 %, 2 %); the quotient's bend is 4e-4 of it."""
    table = write(tmp_path / "t.csv", "mass_g;volume_cm3", [[2.7] * 5, [6.0] * 5])
    found = calibrate(
        "density",
        table,
        "--instrument",
        "mass=0.027 g",
        "--instrument",
        "volume=0.12 cm3",
        "--json",
    ).json
    assert found["density_kg_m3"]["sigma"] == pytest.approx(450 * math.hypot(0.01, 0.02), rel=1e-3)


def test_a_column_that_the_method_does_not_use_leaves_no_row_out(tmp_path):
    """Mass over a known volume: 0.5, 0.54, 0.56 g/cm3, whether a diameter is noted or not."""
    table = write(
        tmp_path / "t.csv", "mass_g;volume_cm3;diameter_mm",
        [[5.0, 5.4, 5.6], [10, 10, 10], [20, "", ""]],
    )  # fmt: skip
    found = calibrate("density", table, "--json").json["density_kg_m3"]
    assert found["trials"] == 3
    assert found["value"] == pytest.approx(np.mean([500, 540, 560]), rel=1e-12)
    assert any("diameter is not used" in words for words in found["remarks"])


def test_a_column_of_kn_gives_kt(tmp_path):
    """kt = kn sigma_t/sigma_n dx_n/dx_t = 3 x 1/2 x 2/3 N/mm."""
    head = "dx_t_um;dx_n_um;sigma_t_MPa;sigma_n_MPa;kn_N_mm"
    table = write(tmp_path / "t.csv", head, [[3], [2], [1], [2], [3]])
    found = calibrate("interface", table, "--reading", "dx_t=3 um", "--json").json
    assert found["kt_n_per_m"]["value"] == pytest.approx(1000, rel=1e-12)
    # at dx_t + 3 um it is half: a displacement of 0 gives no ratio, and no second side
    assert found["kt_n_per_m"]["sigma"] == pytest.approx(500, rel=1e-9)


def test_a_merged_cell_names_all_trials_next_to_it(tmp_path):
    table = tmp_path / "t.csv"
    table.write_text("pairing,angle_deg\nA,20\n,21\n,22\nB,25\n,26\n,27\n")
    found = calibrate("incline", table, "--json").json["friction"]
    assert {name: one["trials"] for name, one in found["groups"].items()} == {"A": 3, "B": 3}
    assert any("4 empty fields of pairing" in words for words in found["remarks"])


def test_trials_that_do_not_differ_give_no_sigma(tmp_path):
    """Three readings of 20 deg to the degree are not exact: 1 deg wide, sigma 1/sqrt(12) deg."""
    table = write(tmp_path / "t.csv", "angle_deg", [[20, 20, 20]])
    found = calibrate("incline", table, "--json").json["friction"]
    assert found["sigma"] is None
    assert any("too coarse" in words for words in found["remarks"])
    known = calibrate("incline", table, "--instrument", "angle=0.29 deg", "--json").json["friction"]
    slope = math.radians(0.29) / math.cos(math.radians(20)) ** 2
    assert known["sigma"] == pytest.approx(slope, rel=1e-4)


def test_radians_called_degrees_are_doubted(tmp_path):
    said = calibrate("incline", write(tmp_path / "t.csv", "angle_deg", [[0.36, 0.37]])).out
    assert "if they are in radians" in said


def test_a_row_with_an_empty_field_is_left_out_and_reported(tmp_path):
    table = write(tmp_path / "t.csv", "mass_g;volume_cm3", [[2.7, "", 2.8], [6.0, 6.0, 6.0]])
    found = calibrate("density", table, "--json").json
    assert found["density_kg_m3"]["trials"] == 2
    assert "1 of 3 rows left out" in found["density_kg_m3"]["remarks"][0]


@pytest.mark.parametrize(
    ("command", "head", "values", "options", "line"),
    [
        ("incline", "angle", [20], [], "the unit is missing; write it into the head"),
        ("incline", "angle_deg", [95], [], "line 2: angle = 95 deg: takes 0 to below 90 deg"),
        ("incline", "tilt_deg", [20], [], "it has tilt_deg; say which is which: --column 'angle"),
        ("incline", "h1_mm", [20], [], "this needs the columns angle [rad] or h1 [m], h2"),
        ("incline", "angle_deg", [20], ["--group", "pair"], "no column 'pair'"),
        ("incline", "angle_deg", ["steep"], [], "no column of numbers"),
        ("incline", "angle_deg;n", ["x", 1], [], "line 2: angle_deg = 'x' is no number"),
        ("incline", "angle_deg", [20], ["--constant", "angel=3 deg"], "did you mean 'angle'"),
        ("incline", "angle_deg", [20], ["--instrument", "angle=3"], "the unit is missing"),
        ("incline", "angle_deg", [20], ["--reading", "angle=-3 deg"], "is not negative"),
        ("incline", "angle_deg", [20], ["--column", "angle"], "write it as 'angle=...'"),
        ("incline", "angle_deg", [20], ["--instrument", "h1=5 mm"], "no trial has h1"),
        ("incline", "angle_deg", [20], ["--reading", "h1=5 mm"], "no trial has h1"),
        (
            "incline",
            "angle_deg",
            [20],
            ["--start-angle", "5 deg"],
            "with films: --start-angle",
        ),
        ("incline", "angle_deg", [20], ["--length-along", "base"], "no trial has heights"),
        (
            "slide",
            "time_s;velocity_m_s",
            [0, 0],
            ["--scale", "1 mm/px"],
            "with films: --scale",
        ),
        ("incline", "h1_mm;h2_mm;length_mm", [9, 0, 8], [], "no slope"),
        ("interface", "dx_t_mm;dx_n_mm;sigma_t_MPa;sigma_n_MPa", [0, 1, 1, 1], [], "may be 0"),
        ("density", "mass_g;volume_cm3", [1, 0], [], "both are above 0"),
        ("density", "mass_kg;volume_cm3", [2.7, 6], [], "denser than any solid; check the units"),
        ("incline", "pairing;angle_deg", ["", 20], [], "line 2: pairing is empty"),
        ("density", "mass_g;volume_cm3", ["", 1], [], "no row in which mass, volume is there"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(tmp_path, command, head, values, options, line):
    table = write(tmp_path / "t.csv", head, [[v] for v in values])
    result = calibrate(command, table, *options)
    assert result.code == 2
    assert line in result.err
    assert result.err.count("\n") == 1


def test_a_file_given_twice_is_refused(tmp_path):
    table = write(tmp_path / "t.csv", "angle_deg", [[20, 21]])
    assert "given twice" in calibrate("incline", table, tmp_path / "." / "t.csv").err


def test_a_missing_file_is_reported():
    result = calibrate("incline", "nowhere.csv")
    assert (result.code, result.err) == (
        2, "calibrate: nowhere.csv: cannot be read (No such file or directory)\n",
    )  # fmt: skip
