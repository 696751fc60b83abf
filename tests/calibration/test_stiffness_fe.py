"""calibrate stiffness-fe: surfaces, the paper's markers, uncertainties, the command, bad input."""

import json
from dataclasses import replace

import numpy as np
import pytest
from calibrating import calibrate
from fuzzing import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration.bench.roughness import of_profile
from calibration.statistics.uncertainty import of_trials
from calibration.stiffness_fe import assumptions, markers
from calibration.stiffness_fe.blocks import Elastic
from calibration.stiffness_fe.contact import SLIDE, STICK, solve_contact
from calibration.stiffness_fe.measure import Found, measure, one_test
from calibration.stiffness_fe.protocol import Case, Load
from calibration.stiffness_fe.result import Stiffness
from calibration.stiffness_fe.surfaces import Paths, Waves, first_touch
from granulab.errors import InputError

SMALL = ("--mesh", "40", "--wavelength", "2 mm", "--random-profiles", "2")
WIDTH = 10e-3


def draw(surface, columns: int, seed: int = 3, period: bool = True):
    x = np.linspace(0, WIDTH, columns + 1)
    return x, *surface.draw(x, period, np.random.default_rng(seed))


def test_made_surfaces_have_their_ra_and_are_the_same_on_any_mesh():
    """Ra by thesis eq. 7.1; 400 columns, 40 a wave: straight pieces miss (2 pi/40)^2/12 = 0.2 %."""
    x, lower, upper = draw(Waves(30e-6, 1e-3), 400)
    assert of_profile(x, lower).value == pytest.approx(30e-6, rel=0.01)
    assert of_profile(x, upper).value == pytest.approx(30e-6, rel=0.01)
    _, coarse, _ = draw(Waves(30e-6, 1e-3), 100)
    np.testing.assert_allclose(lower[::4], coarse, atol=1e-12)
    assert np.abs(np.fft.rfft(lower[:-1])[11:]).max() < 1e-9  # nothing shorter than 1 mm


@pytest.mark.parametrize("change", [
    {"wavelength": 0.5e-3}, {"wavelength": 2e-3}, {"longest": 2e-3}, {"ra": 60e-6},
])  # fmt: skip
def test_a_varied_surface_keeps_the_waves_of_the_one_that_it_varies(change):
    """Phases of the waves that both have, of the lower and of the upper surface."""
    base = Waves(30e-6, 1e-3)
    other = replace(base, drawn=int(base.numbers(WIDTH)[-1]), **change)
    (_, *ours), (_, *theirs) = (draw(one, 160) for one in (base, other))
    shared = np.intersect1d(base.numbers(WIDTH), other.numbers(WIDTH))
    for first, second in zip(ours, theirs, strict=True):
        phases = [np.angle(np.fft.rfft(one[:-1])[shared]) for one in (first, second)]
        np.testing.assert_allclose(*phases, atol=1e-9)


def test_a_change_whose_test_comes_to_no_end_is_left_out(monkeypatch):
    """Of nine changes one fails: the others and their sigma stand; without a base none counts."""
    load = Load(0.2, 6e-5, 6e-5)
    case = Case(Elastic(242e6, 0.2), WIDTH, WIDTH, 0.12, columns=40, steps=6)
    setting = assumptions.Setting(case, load, load, Waves(30e-6, 2e-3))

    def values(height, free):
        def found(changed, seed):
            if changed.case.height == height:
                raise InputError("no state of the contacts is found")
            return assumptions.Values(0.3, 0.2, 0.5 + free * (changed.case.sides == "free"))

        return found

    monkeypatch.setattr(assumptions, "_values", values(WIDTH / 2, 0.1))
    rows = assumptions.vary(setting, 1, lambda words: None)
    (failed,) = [row for row in rows if row.values is None]
    assert (failed.what, failed.change) == ("height of each block", "half")
    assert failed.reason == "no state of the contacts is found"
    assert assumptions.together(rows).stress == pytest.approx(0.1)
    assert "not in sigma: no state" in Stiffness(Found(case, None, None, None), rows).text()
    monkeypatch.setattr(assumptions, "_values", values(WIDTH, 0.1))
    found = Found(case, None, None, None)
    assert assumptions.applied(found, assumptions.vary(setting, 1, lambda words: None)) is found


def test_one_rough_surface_faces_a_flat_one():
    _, lower, upper = draw(Waves(30e-6, 1e-3, None, True), 80)
    assert np.ptp(lower) > 0
    assert np.ptp(upper) == 0


@settings(deadline=None, max_examples=examples(20))
@given(st.integers(0, 1000))
def test_surfaces_touch_first_where_the_gap_is_lowest(seed):
    _, lower, upper = draw(Waves(30e-6, 2e-3), 40, seed)
    gap = first_touch(lower, upper) - lower
    assert gap.min() == pytest.approx(0, abs=1e-18)
    assert gap.max() > 0


def test_a_measured_path_is_averaged_over_the_columns():
    """A ripple with ten periods a column is not there; a wave of twenty columns keeps its mean
    over one, sinc(1/20) = 0.996 of its height."""
    x = np.linspace(0, WIDTH, 20001)
    wave = 10e-6 * np.sin(2 * np.pi * x / 2e-3)
    ripple = 5e-6 * np.sin(2 * np.pi * x / 1e-5)
    _, lower, _ = draw(Paths((("a", x, wave + ripple),)), 100, period=False)
    assert np.abs(lower).max() == pytest.approx(10e-6 * np.sinc(1 / 20), rel=0.01)


def test_periodic_stretches_of_a_path_end_where_they_begin():
    x = np.linspace(0, 3 * WIDTH, 3001)
    z = np.cumsum(np.random.default_rng(1).normal(size=3001)) * 1e-7
    for seed in range(5):
        _, lower, upper = draw(Paths((("a", x, z),)), 100, seed)
        assert lower[0] == pytest.approx(lower[-1], abs=1e-15)
        assert upper[0] == pytest.approx(upper[-1], abs=1e-15)


def test_the_printed_table_is_read_as_it_stands():
    """Means of Table 1: 0.41/6 and 0.15/6 mm, 42.64 and 4.33 MPa; kt/kn 0.285 and 0.065."""
    flat, rough = markers.printed("flat"), markers.printed("rough")
    assert flat.across == pytest.approx(0.41e-3 / 6)
    assert flat.along == pytest.approx(0.15e-3 / 6)
    assert flat.sigma_n == pytest.approx(42.64e6, rel=1e-3)
    assert flat.kt_over_kn == pytest.approx(0.285)
    assert rough.kt_over_kn == pytest.approx(0.065)
    spots = markers.positions()
    np.testing.assert_allclose(np.abs(spots[:, 1]), 2.85e-3, rtol=0.06)  # two rows, 5.7 mm apart


@settings(deadline=None, max_examples=examples(50))
@given(st.integers(0, 10**6), st.floats(0, 0.5))
def test_contacts_obey_signorini_and_coulomb(seed, friction):
    """Nearly independent contacts: W = 1 + 0.1 A A^T/n; then one solution exists."""
    rng, n = np.random.default_rng(seed), 6
    a = rng.normal(size=(2 * n, 2 * n))
    yielding = np.eye(2 * n) + 0.1 * a @ a.T / (2 * n)
    free = rng.normal(size=2 * n)
    forces, doing = solve_contact(yielding, free, friction, np.zeros(2 * n))
    gap, slip = (free + yielding @ forces).reshape(2, n)
    pressing, rubbing = forces.reshape(2, n)
    near = 1e-9
    assert pressing.min() > -near
    assert gap.min() > -near
    assert np.abs(pressing * gap).max() < near
    assert np.all(np.abs(rubbing) <= friction * pressing + near)
    assert np.abs(slip[doing == STICK]).max(initial=0) < near
    slides = np.abs(doing) == SLIDE
    assert np.all((rubbing * slip)[slides] <= near)


def test_sigma_has_its_parts_added_as_squares():
    load = Load(0.2, 6e-5, 6e-5)
    case = Case(Elastic(242e6, 0.2), WIDTH, WIDTH, 0.12, columns=40, steps=6)
    found = measure(case, load, (load, Waves(30e-6, 2e-3)), profiles=3, seed=1, sigma_e=0.15)
    kn = found.rough.kn
    parts = (kn.mesh, kn.profiles, 0.15 * kn.whole.value)
    assert kn.whole.sigma == pytest.approx(np.hypot.reduce(parts))
    assert found.rough.ratio.whole.trials == 3
    assert found.stress.whole.value == pytest.approx(
        found.rough.kn.whole.value / found.flat.kn.whole.value
    )
    assumed = found.rough.ratio.with_assumed(0.1)
    assert assumed.whole.sigma == pytest.approx(np.hypot(found.rough.ratio.whole.sigma, 0.1))


def test_the_flat_contact_alone_is_the_bulk_and_goes_into_the_file(tmp_path):
    """kt = mu A/(2 H) of 242 MPa, nu 0.2, 10 mm x 120 mm and 20 mm: 6050 N/mm, kn 16133 N/mm.

    With a measured kn, kt = 0.375 kn: 3750 N/mm of 1e4.
    """
    file = tmp_path / "wood.toml"
    got = calibrate(
        "stiffness-fe", "--surface", "flat", "--mesh", "16", "--json", "--quiet",
        "--kn", "1e4 N/mm +- 18 %", "--into", file, "--pair", "wood-wood",
    )  # fmt: skip
    assert got.code == 0, got.err
    result = json.loads(got.out)
    assert result["rough"] is None
    assert result["normal_stress_rough_over_flat"] is None
    flat = result["flat"]
    assert flat["kt_over_kn"]["value"] == pytest.approx(0.375)
    assert flat["kn_n_per_m"]["value"] == pytest.approx(242e6 / 0.9 * 0.0012 / 0.02)
    assert flat["kt_n_per_m"]["value"] == pytest.approx(242e6 / 2.4 * 0.0012 / 0.02)
    assert flat["kt_over_kn"]["printed"] == 0.28
    assert result["kt_n_per_m"]["value"] == pytest.approx(3.75e6)
    assert result["kt_n_per_m"]["sigma"] >= 0.18 * 3.75e6 * (1 - 1e-9)  # that of kn at least
    assert "3750 N/mm" in file.read_text() or "3.75e" in file.read_text().lower()


def test_a_measured_profile_and_a_diagnostic_figure(tmp_path):
    x = np.linspace(0, 30, 1501)
    z = 30 * np.sin(2 * np.pi * x / 2.3) + 10 * np.sin(2 * np.pi * x / 3.1)
    file = tmp_path / "profile.csv"
    rows = "\n".join(f"{a:.4f};{b:.4f}" for a, b in zip(x, z, strict=True))
    file.write_text(f"Weg [mm];z [um]\n{rows}\n")
    got = calibrate(
        "stiffness-fe", "--profile", file, "--column", "x=Weg [mm]", "--mesh", "40",
        "--random-profiles", "2", "--no-assumptions", "--out", tmp_path / "sheets", "--quiet",
    )  # fmt: skip
    assert got.code == 0, got.err
    assert "kt/kn rough" in got.out
    assert "0.065 +- 0.04" in got.out
    assert (tmp_path / "sheets" / "stiffness-fe.png").stat().st_size > 10_000


def test_what_was_assumed_is_varied_and_counts(tmp_path):
    got = calibrate("stiffness-fe", *SMALL, "--json", "--quiet")
    assert got.code == 0, got.err
    result = json.loads(got.out)
    rows = result["assumptions"]
    assert rows[0]["what"] == "as stated"
    free = next(row for row in rows if row["what"] == "sides")
    assert free["kt_over_kn_flat"] < 0.5 * rows[0]["kt_over_kn_flat"]  # blocks that bend
    flat = result["flat"]["kt_over_kn"]
    assert flat["sigma_assumed"] > 0.2
    assert flat["sigma"] >= flat["sigma_assumed"]
    assert len(result["rough"]["markers"]["dx_t_m"]) == 6
    assert result["rough"]["force_imbalance"] < 1e-9


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--width", "10"], "--width = '10': the unit is missing"),
        (["--height", "-1 mm"], "--height = -0.001 m: must be more than 0"),
        (["--E", "242 mm"], "--E = '242 mm': the unit is wrong here"),
        (["--nu", "0.5"], "--nu = 0.5: Poisson's ratio lies between"),
        (["--friction", "-0.1"], "--friction = -0.1: a number from 0 to 2"),
        (["--across", "5 mm"], "--across = 0.005 m: blocks of together 0.02 m"),
        (["--along", "5 mm"], "--along = 0.005 m: at most a quarter of the width"),
        (["--roughness", "2 mm"], "--roughness = 0.002 m: at most a tenth"),
        (["--wavelength", "0.1 mm"], "160 columns on 0.01 m show waves from 0.0005 m on"),
        (["--wavelength", "20 mm"], "fits on 0.01 m; a shorter one would do"),
        (["--profile", "none.csv"], "none.csv"),
        (["--profile", "a.csv", "--roughness", "10 um"], "--roughness is of a made surface"),
        (["--kn", "0 N/mm"], "--kn = 0 N/m: must be more than 0"),
        *(
            (["--surface", "flat", option, value], f"{option}: of rough surfaces")
            for option, value in (
                ("--roughness", "30 um"), ("--wavelength", "1 mm"), ("--profile", "p.csv"),
                ("--random-profiles", "8"), ("--column", "z=Height [um]"),
            )
        ),
        (["--column", "z=Height [um]"], "--column: names one of a measured profile"),
        (["--pair", "wood-wood"], "--into wood.toml"),
        (["--into", "new.toml", "--pair", "wood-wood"], "--into: kt = (kt/kn) kn: give kn"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line(arguments, words):
    got = calibrate("stiffness-fe", *arguments, "--quiet")
    assert got.code == 2
    assert words in got.err
    assert got.err.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x [mm];z [um]\n0;1\n1;2\n", "2 points of a profile: at least 50"),
        ("a;b\n1;2\n", "none of the columns x, z"),
        ("x;z\n" + "\n".join(f"{k};1" for k in range(60)), "the unit is missing"),
        ("x [mm];z [um]\n" + "\n".join(f"{k / 10};1" for k in range(60)), "is shorter than"),
    ],
)
def test_profiles_that_will_not_do(tmp_path, text, words):
    file = tmp_path / "p.csv"
    file.write_text(text)
    got = calibrate("stiffness-fe", "--profile", file, "--mesh", "16", "--quiet")
    assert got.code == 2
    assert words in got.err
    assert got.err.count("\n") == 1


@pytest.mark.validation
def test_sigma_of_profiles_covers_the_mean_of_many():
    """Four profiles' Student interval holds the mean of 400 in 68 % of 100 such groups.

    100 groups count to within 5 %: 60 to 76 %.
    """
    load = Load(0.2, 6e-5, 6e-5)
    case = Case(Elastic(242e6, 0.2), WIDTH, WIDTH, 0.12, columns=40, steps=6)
    values = [one_test(case, load, Waves(30e-6, 2e-3), k, 1).ratio for k in range(400)]
    groups = [of_trials(values[k : k + 4]) for k in range(0, 400, 4)]
    inside = [abs(one.value - np.mean(values)) < one.sigma for one in groups]
    assert 0.60 <= np.mean(inside) <= 0.76
