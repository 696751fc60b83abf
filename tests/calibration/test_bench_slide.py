"""Tangential damping from sliding: eqs 3.11a-c back from curves and terminal velocities."""

import math

import numpy as np
import pytest
from bench_calls import write
from calibrating import calibrate

from calibration.bench.slide import GRAVITY, fit, of_terminal_velocity

GAMMA, V0 = 3.0, 0.43
TIME = np.linspace(0, 1.5, 90)


def test_a_curve_without_noise_gives_back_what_made_it():
    """Eq. 3.11b and its general solution; the tolerance is the optimiser's 1e-8."""
    p, _ = fit(TIME, V0 * (1 - np.exp(-GAMMA * TIME)), "rest")
    assert p == pytest.approx([V0, GAMMA], rel=1e-7)
    p, _ = fit(TIME, V0 + (0.1 - V0) * np.exp(-GAMMA * TIME), "any")
    assert p == pytest.approx([V0, GAMMA, 0.1], rel=1e-6)


def test_the_curve_is_the_equation_of_motion():
    """Eq. 3.11a integrated by scipy (rtol 1e-9) for 30 deg and mu 0.4, not by its solution."""
    from scipy.integrate import solve_ivp

    driving = GRAVITY * (math.sin(math.pi / 6) - 0.4 * math.cos(math.pi / 6))
    run = solve_ivp(
        lambda _, v: -GAMMA * v + driving, (0, 1.5), [0.0], t_eval=TIME, rtol=1e-9, atol=1e-12
    )
    p, _ = fit(TIME, run.y[0], "rest")
    assert p == pytest.approx([driving / GAMMA, GAMMA], rel=1e-6)


@pytest.mark.parametrize("start", ["rest", "any"])
@pytest.mark.parametrize("noise", [0.005, 0.03])
def test_sigma_of_gamma_covers_the_truth_in_68_percent(start, noise):
    """White noise of 1 % and 7 % of v0, 400 curves: 68 +- 3 x 2.3 %; bias below sigma/4."""
    rng = np.random.default_rng(6)
    clean = V0 * (1 - np.exp(-GAMMA * TIME))
    found = [fit(TIME, clean + rng.normal(0, noise, len(TIME)), start) for _ in range(400)]
    gamma = np.array([p[1] for p, _ in found])
    sigma = np.array([math.sqrt(covariance[1, 1]) for _, covariance in found])
    assert 0.60 <= np.mean(np.abs(gamma - GAMMA) <= sigma) <= 0.76
    assert abs(gamma.mean() - GAMMA) < 0.25 * sigma.mean()


@pytest.mark.parametrize("points", [6, 8])
def test_sigma_of_gamma_of_few_points_has_students_factor(points):
    """68 +- 3 x 2.3 % of 400 curves; without the factor 60 %."""
    rng = np.random.default_rng(points)
    time = np.linspace(0.1, 2, points)
    clean = V0 * (1 - np.exp(-GAMMA * time))
    found = [fit(time, clean + rng.normal(0, 0.004, points), "rest") for _ in range(400)]
    covered = [abs(p[1] - GAMMA) <= math.sqrt(covariance[1, 1]) for p, covariance in found]
    assert 0.61 <= np.mean(covered) <= 0.75


def test_friction_while_sliding_comes_from_the_curve_and_the_slope(tmp_path):
    """tan(theta) - gamma_t v0/(g cos theta); 0.4 went in. Files are trials; both are alike."""
    driving = GRAVITY * (math.sin(math.pi / 6) - 0.4 * math.cos(math.pi / 6))
    v = driving / GAMMA * (1 - np.exp(-GAMMA * TIME))
    rng = np.random.default_rng(7)
    files = [
        write(tmp_path / f"run{k}.csv", "time_s;velocity_m_s", [TIME, v + rng.normal(0, 0.003, 90)])
        for k in range(4)
    ]
    found = calibrate("slide", *files, "--constant", "incline=30 deg +- 0.2 deg", "--json").json
    assert found["gamma_t_per_s"]["trials"] == 4
    for one, truth in (
        (found["gamma_t_per_s"], GAMMA),
        (found["terminal_velocity_m_s"], driving / GAMMA),
        (found["friction_sliding"], 0.4),
    ):
        assert abs(one["value"] - truth) < 3 * one["sigma"]
    # 0.2 deg alone moves tan(theta) - ... by (1 + tan^2 - 0.1 ...) x 3.5e-3: above 3e-3
    assert found["friction_sliding"]["sigma"] > 3e-3
    assert found["gamma_t_per_s"]["remarks"] == []


def test_a_single_run_has_the_sigma_of_its_fit(tmp_path):
    """The diagonal of the covariance: v0, gamma_t."""
    v = V0 * (1 - np.exp(-GAMMA * TIME)) + np.random.default_rng(8).normal(0, 0.01, 90)
    table = write(tmp_path / "run.csv", "time_s;velocity_m_s", [TIME, v])
    found = calibrate("slide", table, "--json").json
    _, covariance = fit(TIME, v, "rest")
    for key, variance in zip(
        ("terminal_velocity_m_s", "gamma_t_per_s"), np.diag(covariance), strict=True
    ):
        assert found[key]["sigma"] == pytest.approx(math.sqrt(variance), rel=1e-9)


def test_terminal_velocity_gives_the_paper_its_gamma_at_30_degrees():
    """Eq. 3.11c with v0 = 0.43 m/s and mu = 0.43: 2.91 1/s at 30 deg (printed 3.0 +- 0.5)."""
    assert of_terminal_velocity(0.43, math.pi / 6, 0.43) == pytest.approx(2.91, abs=0.005)


def test_terminal_velocities_of_a_table_and_what_their_constants_add(tmp_path):
    """sigma(mu) g cos(theta)/v0 adds to the scatter; 3.11c is linear in mu: exact."""
    table = write(tmp_path / "t.csv", "terminal_velocity_m_s", [[0.43, 0.43, 0.43]])
    found = calibrate(
        "slide", table, "--constant", "incline=30 deg", "--constant", "friction=0.43 +- 0.03",
        "--json",
    ).json  # fmt: skip
    expected = 0.03 * GRAVITY * math.cos(math.pi / 6) / 0.43
    assert found["gamma_t_per_s"]["sigma"] == pytest.approx(expected, rel=1e-9)


def test_a_slide_is_one_whichever_way_velocity_counts(tmp_path):
    """Friction from eq. 3.11c needs v0 down the slope: counted upwards it is the same."""
    v = V0 * (1 - np.exp(-GAMMA * TIME)) + np.random.default_rng(9).normal(0, 0.005, 90)
    both = [
        calibrate("slide", write(tmp_path / name, "time_s;velocity_m_s", [TIME, way * v]),
                  "--constant", "incline=30 deg", "--json").json
        for name, way in (("down.csv", 1), ("up.csv", -1))
    ]  # fmt: skip
    for key in ("gamma_t_per_s", "terminal_velocity_m_s", "friction_sliding"):
        assert both[1][key]["value"] == pytest.approx(both[0][key]["value"], rel=1e-9)


@pytest.mark.parametrize("late", [0.3, -0.1])
def test_a_clock_that_does_not_start_at_the_release_is_refused(tmp_path, late):
    """Eq. 3.11b from rest would give a gamma_t of 1.2 or 4.6 1/s with a small sigma; 3 went in."""
    v = V0 * (1 - np.exp(-GAMMA * TIME)) + np.random.default_rng(10).normal(0, 0.005, 90)
    table = write(tmp_path / "t.csv", "time_s;velocity_m_s", [TIME + late, v])
    assert "m/s at t = 0, and not 0" in calibrate("slide", table).err
    found = calibrate("slide", table, "--start", "any", "--json").json["gamma_t_per_s"]
    assert abs(found["value"] - GAMMA) < 3 * found["sigma"]


def test_noise_that_is_not_white_is_reported(tmp_path):
    v = V0 * (1 - np.exp(-GAMMA * TIME)) + 0.02 * np.sin(20 * TIME)
    table = write(tmp_path / "t.csv", "time_s;velocity_m_s", [TIME, v])
    assert "neighbouring residuals go together" in calibrate("slide", table).out


@pytest.mark.parametrize(
    ("columns", "options", "line"),
    [
        (["time_s;velocity_m_s", TIME, 0.5 * TIME], [], "leave gamma_t open"),
        (["time_s;velocity_m_s", TIME[:3], TIME[:3]], [], "at least 4"),
        (["time_s;v_m_s", TIME, TIME], [], "this needs the columns time [s], velocity [m/s] or"),
        (
            ["terminal_velocity_m_s", [0.4]],
            ["--constant", "incline=20 deg", "--constant", "friction=0.43"],
            "eq. 3.11c needs tan(incline) above friction",
        ),
    ],
)
def test_bad_runs_are_one_line(tmp_path, columns, options, line):
    result = calibrate("slide", write(tmp_path / "t.csv", columns[0], columns[1:]), *options)
    assert result.code == 2
    assert line in result.err
    assert result.err.count("\n") == 1
