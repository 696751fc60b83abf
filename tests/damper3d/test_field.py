"""The effective field: table, interpolation, refinement, fitted powers; a small real one."""

import json
import math

import numpy as np
import pytest
from made_field import BED, made_mass, made_runs
from refusals import assert_refused, assert_refuses
from small_damper import damper3d, write_damper

from damper3d.studies.field import runs as sampling
from damper3d.studies.field.fall import falls
from damper3d.studies.field.runs import Refinement, bends, field_of, field_of_runs, unlike
from damper3d.studies.field.table import COLUMNS, Field, read_field
from damper3d.studies.map import grid as mapping
from damper3d.studies.map.grid import Grid, MapResult

GAMMAS = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0)
COARSE = Grid((20.0, 40.0), GAMMAS, packings=3)


@pytest.fixture
def made(monkeypatch):
    """Made runs in place of computed ones; the labels of each call."""
    calls = []

    def run_cases(cases, **options):
        calls.append([labels for labels, _ in cases])
        return made_runs(cases, **options)

    monkeypatch.setattr(mapping, "run_cases", run_cases)
    return calls


def made_field(tmp_path, refine=Refinement(), grid=COARSE):  # noqa: B008
    return field_of_runs("thesis", {}, grid, refine, out=tmp_path)


def furthest(field, frequency=20.0):
    """Largest error of the interpolation between the points, over the bed's mass."""
    (knots,), (force,) = field.knots(frequency)
    gamma = np.geomspace(knots[1], knots[-1], 400)
    truth = np.array([made_mass(frequency, g) for g in gamma])
    return np.abs(np.interp(gamma, knots, force) / gamma - truth).max() / BED


def test_runs_of_a_field_are_steady_with_whole_blocks_of_cycles(monkeypatch, tmp_path):
    seen = []

    def run_cases(cases, **options):
        seen.extend(case for _, case in cases)
        return made_runs(cases, **options)

    monkeypatch.setattr(mapping, "run_cases", run_cases)
    made_field(tmp_path)
    assert all(case.settings.run.steady for case in seen)
    assert len(seen) == 2 * len(GAMMAS) * 3
    assert_refuses(
        ["max_cycles = 18", "give 19 or more"], field_of_runs, "thesis",
        {"run.max_cycles": 18}, COARSE, Refinement(), out=tmp_path,
    )  # fmt: skip


def test_refinement_bounds_the_error_where_the_curve_bends_and_keeps_to_its_runs(made, tmp_path):
    """The line between neighbours is tried at the point between; the error falls below it."""
    coarse = field_of(made_field(tmp_path))
    result = made_field(tmp_path, Refinement(1000))
    fine = field_of(result)
    assert bends(fine, 0.05) == []
    assert furthest(coarse) > 0.1
    assert furthest(fine) < 0.05
    assert fine.gamma[1] > 0.7  # no closer where the bed rides along
    bounded = made_field(tmp_path, Refinement(20))
    assert len(COARSE.points) * 3 < len(bounded.rows) <= len(COARSE.points) * 3 + 20
    assert unlike(result) == pytest.approx(0.0, abs=1e-12)


def test_a_field_has_the_mass_of_its_bed_whatever_the_last_digit_of_its_means(made, tmp_path):
    """Three times 0.1 kg over three is another number than twice over two, at points where a run
    failed.
    """
    rows = [{**row, "mass_kg": 0.1} for row in made_field(tmp_path).rows]
    rows[0] = {**rows[0], "state": "failed"}
    result = MapResult.of(rows)
    assert len(set(result.mean("mass_kg"))) == 2
    assert field_of(result).bed_mass == 0.1


def test_refinement_stops_at_the_noise_of_the_packings(monkeypatch, tmp_path):
    """With three packings that scatter by a fifth of the mass, intervals cover the bends."""
    monkeypatch.setattr(
        mapping, "run_cases", lambda cases, **options: made_runs(cases, noise=0.2, **options)
    )
    noisy = made_field(tmp_path, Refinement(3000))
    monkeypatch.setattr(mapping, "run_cases", made_runs)
    assert len(noisy.gamma) < 2 * len(made_field(tmp_path, Refinement(3000)).gamma)


def test_interpolation_is_exact_for_riding_beds_and_for_masses_that_fall_as_one_over_gamma():
    field = Field.of([20.0] * 4, [1.0, 2.0, 8.0, 32.0], [0.03, 0.03, 0.0075, 0.001875], 0.03)
    omega2 = (2 * math.pi * 20) ** 2
    for gamma, mass in ((0.01, 0.03), (1.5, 0.03), (3.0, 0.02), (20.0, 0.003)):
        assert field.at(20.0, gamma * 9.81 / omega2) == pytest.approx(mass, rel=1e-12)


def test_interpolation_passes_through_negative_masses_and_between_frequencies_in_ln_f():
    field = Field.of([20.0, 20.0, 80.0, 80.0], [1.0, 10.0] * 2, [1, -1 - 1j, 3, 1 - 2j], 1.0)
    omega2 = (2 * math.pi * 40) ** 2
    assert field.at(40.0, 10.0 * 9.81 / omega2) == pytest.approx(0 - 1.5j)
    assert field.at(20.0, 10.0 * 9.81 / (omega2 / 4)) == pytest.approx(-1 - 1j)


@pytest.mark.parametrize("of", ["gamma", "amplitude"])
def test_what_two_frequencies_share_is_found_between_them(of):
    """A bed that does not reach its lid goes by Gamma, one that does by the amplitude: m falls as a
    line of 1/Gamma or of 1/A, which the interpolation of the force meets exactly.

    At the same Gamma the first is exact, and nothing else is made of it; at the same amplitude the
    second is, where the same Gamma of 20 and 80 Hz misses it by a third.
    """
    gammas = np.array([1.0, 2, 4, 8, 16, 32, 64])

    def mass(frequency, gamma):
        return 1 + 2 / (gamma if of == "gamma" else gamma * (40 / frequency) ** 2) - 0.5j

    points = [(f, g) for f in (20.0, 80.0) for g in gammas]
    field = Field.of(*np.array(points).T, [mass(*one) for one in points], 1.0)
    shake = 8.0 * 9.81 / (2 * math.pi * 40) ** 2
    at_gamma, at_amplitude = (one.at(40.0, shake) for one in (field, field.by_amplitude()))
    true = mass(40.0, 8.0)
    exact, other = (at_gamma, at_amplitude) if of == "gamma" else (at_amplitude, at_gamma)
    assert exact == pytest.approx(true, rel=1e-3)  # g of the code is 9.80665
    if of == "gamma":
        assert other == pytest.approx(true, rel=1e-3)
    else:
        assert abs(other - true) > 0.2
    for f in (20.0, 80.0):  # at a frequency of the table both are the table
        assert field.by_amplitude().at(f, 1e-4) == field.at(f, 1e-4)


@pytest.mark.parametrize(
    ("frequency", "gamma", "expected"),
    [(56.6, 2.0, [40.0, 80.0]), (56.6, 0.9, None), (41.0, 9.0, None), (74.0, 9.0, None),
     (40.0, 9.0, None), (20.0, 9.0, None)],
)  # fmt: skip
def test_a_motion_far_between_two_frequencies_is_told(frequency, gamma, expected):
    """Where the bed leaves its floor, more than a tenth off both: the cure is a field there."""
    field = Field.of([20.0, 40.0, 80.0], [20.0] * 3, [1.0] * 3, 1.0)
    amplitude = gamma * 9.81 / (2 * math.pi * frequency) ** 2
    assert field.far_between(frequency, amplitude) == expected


def test_a_frequency_of_the_table_reaches_as_far_as_its_own_points():
    field = Field.of([20.0, 20.0, 40.0, 40.0], [1.0, 20.0, 1.0, 5.0], [1.0] * 4, 1.0)
    ends = [field.knots(f)[0][0, -1] for f in (20.0, 30.0, 40.0)]
    assert ends == [20.0, 5.0, 5.0]


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ((10.0, 1e-3), ["10 Hz", "20 to 40 Hz"]),
        ((41.0, 1e-3), ["41 Hz"]),
        ((40.0, 1.0), ["1000 mm", "above the field", "16"]),
    ],
)
def test_nothing_is_said_outside_the_table(made, tmp_path, place, words):
    assert_refuses(words, field_of(made_field(tmp_path)).at, *place)


def test_table_is_read_back_to_the_last_bit_with_its_head(made, tmp_path):
    field = field_of(made_field(tmp_path), ("a bed", "version"))
    read = read_field(field.write(tmp_path / "field.csv"))
    assert read.head == ("a bed", "version")
    for name in ("frequency", "gamma", "in_phase", "out_of_phase", "in_phase_half_width", "seeds"):
        assert np.array_equal(getattr(read, name), getattr(field, name), equal_nan=True)
    assert read.bed_mass == field.bed_mass


_LINE = "20,1,0.000621,0.03,,0.0,,0.03,1"


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ([], ["no points"]),
        ([",".join(COLUMNS)], ["no points"]),
        (["frequency_hz,gamma", "20,1"], ["column 'amplitude_m' is missing"]),
        ([",".join(COLUMNS), _LINE, _LINE], ["20 Hz, Gamma 1 stands twice"]),
        ([",".join(COLUMNS), _LINE[:-2]], ["line 2 has 8 values, its head 9"]),
        ([",".join(COLUMNS), _LINE.replace("20,", "x,", 1)], ["line 2: frequency_hz = 'x'"]),
        ([",".join(COLUMNS), _LINE.replace("20,", "-2,", 1)], ["frequency_hz = -2: must be above"]),
        ([",".join(COLUMNS), _LINE, "20,2,0.001242,0.03,,0.0,,0.04,1"], ["fields of two beds"]),
        ([",".join(COLUMNS), _LINE[:-1] + "1.5"], ["line 2: seeds = 1.5: a whole number"]),
        ([",".join(COLUMNS), _LINE.replace(",,", ",-1,", 1)], ["half_width_kg = -1: must not be"]),
        (
            [",".join(COLUMNS), _LINE.replace("0.000621", "0.621")],
            ["amplitude_m = 0.621", "0.00062"],
        ),
        (
            [",".join(COLUMNS), _LINE.replace(",0.0,", ",-0.01,")],
            ["-0.01: below 0 a bed would give"],
        ),
    ],
)
def test_tables_that_are_none_are_refused_in_one_line(tmp_path, lines, words):
    path = tmp_path / "field.csv"
    path.write_text("\n".join(lines), encoding="utf-8")
    assert_refuses(words, read_field, path)


def test_fitted_powers_are_those_of_the_law_on_the_falling_branch():
    """m' = M Gamma^-1.5 beyond the onset at 1, m'' = M/Gamma: exponents without scatter."""
    gamma = np.geomspace(0.5, 16, 11)
    mass = np.where(gamma <= 1, 1.0, gamma**-1.5) - 1j / np.maximum(gamma, 1)
    found = {fall.quantity: fall for fall in falls(Field.of([40.0] * 11, gamma, mass, 1.0))}
    assert found["in_phase"].exponent == pytest.approx(-1.5, abs=1e-9)
    assert found["in_phase"].gammas[0] == pytest.approx(gamma[gamma > 1][0])
    given = falls(Field.of([40.0] * 11, gamma, mass, 1.0), (1.5, 9.0))
    assert [fall.exponent for fall in given] == pytest.approx([-1.5, -1.0], abs=1e-9)
    assert given[0].half_width < 1e-6


def test_a_power_ends_before_the_mass_turns_negative_and_few_points_have_none():
    gamma = np.array([1.0, 2, 3, 4, 5, 6, 7])
    mass = np.array([1.0, 0.8, 0.5, 0.3, 0.2, -0.1, -0.2])
    (fall,) = falls(Field.of([40.0] * 7, gamma, mass, 1.0))
    assert (fall.gammas, fall.points) == ((2.0, 5.0), 4)
    assert falls(Field.of([40.0] * 4, gamma[:4], mass[:4], 1.0)) == []


def test_a_point_without_runs_is_left_out(made, tmp_path):
    rows = made_field(tmp_path).rows
    lost = [{**row, "state": "failed"} if row["gamma"] == 2.0 else row for row in rows]
    assert 2.0 not in field_of(MapResult.of(lost)).gamma
    nothing = [{**row, "state": "interrupted"} for row in rows]
    assert len(field_of(MapResult.of(nothing)).gamma) == 0
    assert sampling.states(MapResult.of(nothing))["interrupted"] == len(rows)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--frequency", "40"], "give --frequencies"),
        (["--gammas", "0"], "gammas: 0"),
        (["--packings", "0"], "packings = 0"),
        (["--more-runs", "-1"], "more runs = -1"),
        (["--within", "0"], "within = 0"),
        (["--fit", "3"], "two rising Gammas"),
        (["--steady"], "always steady"),
        (["--max-cycles", "10"], "max_cycles = 10"),
    ],
)
def test_field_refuses_bad_input_in_one_line(tmp_path, words, said):
    assert_refused(damper3d("field", *words, "--out", tmp_path, "--quiet"), said)


@pytest.mark.parametrize("there", [0, 40])
def test_an_interrupted_field_keeps_its_table_and_ends_with_code_130(monkeypatch, tmp_path, there):
    def half(cases, **options):
        rows = made_runs(cases, **options)
        lost = [{**labels, "state": "interrupted", "reason": ""} for labels, _ in cases[there:]]
        return rows[:there] + lost

    monkeypatch.setattr(mapping, "run_cases", half)
    options = ["--no-figures", "--quiet", "--more-runs", 30, "--out", tmp_path]
    ended = damper3d("field", *options)
    assert ended.code == 130
    assert "the same command goes on" in ended.err
    assert len(list((tmp_path / "fields").glob("*/field.csv"))) == (there > 0)


def test_a_small_bed_becomes_a_field_and_a_response(tmp_path):
    """Three frequencies, three Gammas, a few spheres; then a host on it, with the same command."""
    changes = {
        "particles.count": 6, "fill.settle_time": "0.1 s", "law.restitution": 0.5,
        "motion.frequency": None, "motion.gamma": None, "run.cycles": None, "run.discard": None,
        "output.frames": 0, "run.time_step": "8 us", "law.youngs_modulus": "0.3 GPa",
    }  # fmt: skip
    case = write_damper(tmp_path, changes)
    grid = ["--frequencies", "60,80,110", "--gammas", "0.3,2,6", "--packings", 1, "--workers", 1]
    made = damper3d("field", case, *grid, "--out", tmp_path, "--json", "--quiet")
    found = json.loads(made.out)
    assert (made.code, found["done"]) == (0, 9), made.err
    riding = [row for row in found["points"] if row["gamma"] == 0.3]
    for row in riding:
        assert row["m_in_phase_kg"] == pytest.approx(found["bed_mass_kg"], rel=0.02)
    assert all(row["m_out_of_phase_kg"] > 0 for row in found["points"] if row["gamma"] == 6)
    assert found["unlike_wall_work"] < 0.1  # 50 samples a cycle of a few impacts
    table = read_field(found["table"])
    assert len(table.gamma) == 9
    assert "6 particles" in table.head[0]
    host = tmp_path / "host.toml"
    host.write_text('schema = 1\n[host]\nmass = "0.2 kg"\nfrequency = 80\ndamping_ratio = 0.01\n'
                    'force = "0.01 N"\n', encoding="utf-8")  # fmt: skip
    answer = damper3d("response", host, "--field", found["table"], "--out", tmp_path, "--json")
    (level,) = json.loads(answer.out)["levels"]
    bare = 0.01 / (2 * 0.01 * 0.2 * (2 * math.pi * 80) ** 2)
    assert level["bare_peak_amplitude_m"] == pytest.approx(bare, rel=1e-3)
    rides = 80 / math.sqrt(1 + found["bed_mass_kg"] / 0.2)
    assert level["peak_frequency_hz"] == pytest.approx(rides, rel=5e-3)
    assert (tmp_path / "response-host.png").exists()
