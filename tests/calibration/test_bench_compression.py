"""Load-unload cycles: found in noise, their unloading stiffness, the modulus, and kn = E A/L."""

import numpy as np
import pytest
from bench_calls import write
from calibrating import calibrate
from numpy.typing import NDArray

from calibration.bench.cycles import line, unloading_stiffness, unloadings

STIFFNESS = 2.42e6  # N/m: 242 MPa, 100 mm2, 10 mm
BRANCH = {"upper": 0.95, "lower": 0.5, "least": 0.1}


def record(
    rng: np.random.Generator, force_noise: float = 0.0, noise: float = 0.0, hold: int = 0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Displacement [m] and load [N] of five cycles: plastic loading at 0.6 of the elastic slope.

    Each unloading follows the elastic slope down to a fifth of its peak, reloading goes back along
    it. With `hold` points of creep at each peak.
    """
    x, load = [0.0], [0.0]
    for peak in (200.0, 400.0, 600.0, 800.0, 1000.0):
        start_load = load[-1]
        back_up = np.linspace(start_load, max(peak - 200, start_load), 40)
        x += list(x[-1] + (back_up - start_load) / STIFFNESS)
        load += list(back_up)
        plastic = np.linspace(load[-1], peak, 60)
        x += list(x[-1] + (plastic - load[-1]) / (0.6 * STIFFNESS))
        load += list(plastic)
        x += list(x[-1] + np.linspace(0, 2e-6, hold))
        load += [peak] * hold
        down = np.linspace(peak, 0.2 * peak, 80)
        x += list(x[-1] - (peak - down) / STIFFNESS)
        load += list(down)
    n = len(x)
    return np.array(x) + rng.normal(0, noise, n), np.array(load) + rng.normal(0, force_noise, n)


def test_every_unloading_is_found_and_has_the_elastic_slope():
    """No noise: five cycles, the slope to rounding (1e-9), straight, and no sigma."""
    x, load = record(np.random.default_rng(1))
    found = unloading_stiffness(x, load, **BRANCH)
    assert [one.peak_load for one in found] == pytest.approx([200, 400, 600, 800, 1000])
    for one in found:
        assert one.stiffness.value == pytest.approx(STIFFNESS, rel=1e-9)
        assert one.bend == pytest.approx(1, rel=1e-9)


@pytest.mark.parametrize(("of_x", "of_load"), [(1, -1), (-1, 1), (-1, -1)])
def test_compression_may_be_written_negative(of_x, of_load):
    """Otherwise the loading branches, of 0.6 the slope here, would pass for unloading."""
    x, load = record(np.random.default_rng(1))
    found = unloading_stiffness(5e-3 + of_x * x, of_load * load, **BRANCH)
    assert [one.stiffness.value for one in found] == pytest.approx([STIFFNESS] * 5, rel=1e-9)


@pytest.mark.parametrize("hold", [0, 30])
def test_cycles_are_found_in_noise_and_after_holds(hold):
    """2 N of noise are 1 % of the smallest peak and make hundreds of small maxima."""
    rng = np.random.default_rng(2)
    for _ in range(20):
        _, load = record(rng, force_noise=2.0, hold=hold)
        assert len(unloadings(load, 0.1)) == 5


def test_a_record_that_begins_at_its_peak_or_ends_half_way_down_has_that_cycle():
    down = np.linspace(100, 40, 50)
    assert unloadings(down, 0.1) == [(0, 49)]
    up_and_down = np.concatenate([np.linspace(0, 100, 50), down])
    assert [last for _, last in unloadings(up_and_down, 0.1)] == [99]
    assert unloadings(np.linspace(0, 100, 50), 0.1) == []


@pytest.mark.parametrize(("x_noise", "y_noise"), [(0.0, 0.02), (0.02, 0.0), (0.02, 0.02)])
def test_sigma_of_a_slope_covers_the_truth_with_noise_in_either(x_noise, y_noise):
    """30 points over 1, 600 draws: at least 60 %; it may be more, for the noise's share is open."""
    rng = np.random.default_rng(3)
    u = np.linspace(0, 1, 30)
    found = [
        line(u + rng.normal(0, x_noise, 30), 2 * u + rng.normal(0, 2 * y_noise, 30))
        for _ in range(600)
    ]
    covered = np.mean([abs(one.value - 2) <= one.sigma for one in found])
    assert 0.60 <= covered <= 0.76


@pytest.mark.parametrize("points", [4, 6])
def test_sigma_of_a_slope_through_few_points_has_students_factor(points):
    """68 +- 3 x 1.5 % of 1000 draws; without the factor 57 % of four points."""
    rng = np.random.default_rng(points)
    u = np.linspace(0, 1, points)
    found = [line(u, u + rng.normal(0, 0.03, points)) for _ in range(1000)]
    assert 0.63 <= np.mean([abs(one.value - 1) <= one.sigma for one in found]) <= 0.74


def test_an_offset_of_a_whole_record_is_in_no_sigma_and_is_reported(tmp_path):
    x, load = record(np.random.default_rng(5), 2.0, 3e-7)
    table = write(tmp_path / "cube.csv", "displacement_mm;load_N", [1e3 * x, load])
    one = calibrate("compression", table, "--reading", "load=50 N", "--json").json
    said = one["unloading_stiffness_n_per_m"]["remarks"]
    assert any("uncertainty of load is in no sigma" in words for words in said)


def test_noise_in_both_does_not_flatten_the_slope():
    """Least squares of y(x) alone would give 11 % less: noise 0.1 against a spread of 0.30.

    Where the noise is the same share of both, the geometric mean has no such bias; 400 draws.
    """
    rng = np.random.default_rng(7)
    u = np.linspace(0, 1, 30)
    found = [
        line(u + rng.normal(0, 0.1, 30), 2 * u + rng.normal(0, 0.2, 30)).value for _ in range(400)
    ]
    assert np.mean(found) == pytest.approx(2, rel=0.02)


def test_modulus_and_kn_of_three_cubes_cover_what_made_them(tmp_path):
    """E = k L/A (242 MPa) and kn = E A/L (1.452e4 N/mm); three records with 2 N, 0.3 um of noise.

    Each specimen's own stiffness differs by nothing here, so three sigma must hold the truth.
    """
    rng = np.random.default_rng(4)
    files = []
    for k in range(3):
        x, load = record(rng, 2.0, 3e-7, hold=10)
        files.append(write(tmp_path / f"cube{k}.csv", "displacement_mm;load_N", [1e3 * x, load]))
    constants = ["area=100 mm2", "length=10 mm", "contact_area=1200 mm2", "contact_length=20 mm"]
    options = [part for one in constants for part in ("--constant", one)]
    result = calibrate("compression", *files, *options, "--json").json
    for one, truth in (
        (result["unloading_stiffness_n_per_m"], STIFFNESS),
        (result["youngs_modulus_pa"], 242e6),
        (result["kn_n_per_m"], 1.452e7),
    ):
        assert one["trials"] == 3
        assert abs(one["value"] - truth) < 3 * one["sigma"] < 0.1 * truth
    assert len(result["cycles"]) == 15
    assert result["cycles"][0]["peak_n"] == pytest.approx(200, abs=10)


def test_one_specimen_has_the_scatter_of_its_cycles(tmp_path):
    x, load = record(np.random.default_rng(5), 2.0, 3e-7)
    table = write(tmp_path / "cube.csv", "displacement_mm;load_N", [1e3 * x, load])
    one = calibrate("compression", table, "--json").json["unloading_stiffness_n_per_m"]
    assert one["trials"] == 1  # a specimen, however often it is loaded
    assert any("5 cycles of one specimen" in words for words in one["remarks"])
    assert abs(one["value"] - STIFFNESS) < 3 * one["sigma"]


def test_stress_against_strain_gives_the_modulus(tmp_path):
    x, load = record(np.random.default_rng(6))
    table = write(tmp_path / "t.csv", "strain_percent;stress_MPa", [1e4 * x, load / 100])
    found = calibrate("compression", table, "--json").json
    assert found["youngs_modulus_pa"]["value"] == pytest.approx(242e6, rel=1e-9)


def test_the_papers_own_numbers_give_14520_newton_per_millimetre():
    """Sec. 3.2.1: E A/L = 242 MPa x 1200 mm2/20 mm; 15 % of E are 15 % of kn; reported with 1e4."""
    options = [
        "--constant", "modulus=242 MPa +- 15 %", "--constant", "contact_area=1200 mm2",
        "--constant", "contact_length=20 mm",
    ]  # fmt: skip
    kn = calibrate("compression", *options, "--json").json["kn_n_per_m"]
    assert kn["value"] == pytest.approx(1.452e7, rel=1e-12)
    assert kn["sigma"] == pytest.approx(0.15 * 1.452e7, rel=1e-9)
    assert "the paper prints 10000 N/mm" in calibrate("compression", *options).out


@pytest.mark.parametrize(
    ("columns", "options", "line"),
    [
        ([[1, 2, 3], [1, 2, 3]], [], "no unloading: the load never falls by 10%"),
        ([[1, 2, 3, 2], [1, 2, 3, 2]], [], "at least 4 with unlike displacements"),
        ([[5, 6, 7, 8, 9, 10, 0], [10, 9, 8, 7, 6, 5, 0]], [], "does not fall with the load"),
        (
            [[*range(40), *range(39, 0, -1)], [*range(40), *range(39, 0, -1)]],
            ["--constant", "length=10 mm", "--constant", "area=100 mm2"],
            "goes over 39 mm of a specimen that is 10 mm long",
        ),
        ([[1, 2], [1, 2]], ["--range", "0.2", "0.9"], "the upper one first"),
        ([[1, 2], [1, 2]], ["--column", "load=z"], "no column 'z'"),
    ],
)
def test_what_is_no_load_unload_record_is_one_line(tmp_path, columns, options, line):
    table = write(tmp_path / "t.csv", "displacement_mm;load_N", columns)
    result = calibrate("compression", table, *options)
    assert result.code == 2
    assert line in result.err
    assert result.err.count("\n") == 1
    assert "this needs the columns modulus [Pa], contact_area" in calibrate("compression").err
