"""Discharge rate and its error, against particles that leave at times that are known."""

import json

import numpy as np
import pytest
from moved_run import falling, write_moved_run

from granulab.campaign.output.figure import write_figure
from granulab.errors import InputError
from silo2d.case.outline import hopper
from silo2d.measures import curve, find, massflow

SILO = hopper(0.0, 0.15, name="flat")


def test_even_flow_is_steady_all_the_time():
    """One particle every 2 ms: 500 a second in every window, to the one particle at its edge.

    Windows of 79.8 ms then hold 39 or 40 particles: numbers that scatter by less than one have a
    variance of at most 1/4, and a Fano factor below 1/4/39.
    """
    times = 0.002 * (np.arange(500) + 0.5)
    steady = curve.steady_part(times, np.full(500, 0.01))
    window = curve.usual_window(times)
    assert steady.rate == pytest.approx(500, abs=1 / (steady.end - steady.start))
    assert steady.mass_flow == pytest.approx(0.01 * steady.rate)
    assert steady.end - steady.start > 1 - 2 * window
    assert steady.fano < 0.25 / 39


def test_errors_of_a_poisson_flow_are_those_of_its_rate():
    """Independent particles at 1000/s for 2 s: error sqrt(n)/n, which the rates of 200 flows have.

    The rate is taken where it is known to be steady. The sd of 200 deviations over their errors
    is 1 within 4/sqrt(400), and the error itself is known from the Fano factor of 17 windows.
    """
    rng = np.random.default_rng(3)
    off = []
    for _ in range(200):
        times = np.sort(rng.uniform(0, 2, rng.poisson(2000)))
        part = curve.part_between(times, np.ones(len(times)), 0.2, 1.9, 0.1)
        off.append((part.rate - 1000) / (part.rate * part.relative_error))
    # A Student distribution of 16 degrees of freedom has a variance of 16/14.
    assert np.std(off) == pytest.approx(np.sqrt(16 / 14), abs=0.2)
    assert abs(np.mean(off)) < 4 / np.sqrt(200)


def test_the_scatter_of_a_flow_is_not_that_of_where_it_scatters_least():
    """Independent particles have a Fano factor of 1; in the stretch whose windows lie within a
    quarter of the mean it was 0.6 of 400. The mean of 200, each from ten windows less a line
    (sd sqrt(2/8)), is 1 to four standard errors."""
    rng = np.random.default_rng(5)
    found = []
    for _ in range(200):
        times = np.sort(rng.uniform(0, 1, rng.poisson(400)))
        found.append(curve.steady_part(times, np.ones(len(times))).fano)
    assert np.mean(found) == pytest.approx(1.0, abs=4 * 0.5 / np.sqrt(200))


def test_steady_part_leaves_out_start_and_end():
    """Half the rate for 0.4 s, the full rate for 2 s, a tenth for 1 s: the middle is steady.

    Its ends are known to a window, which holds a step where it straddles one.
    """
    times = np.concatenate(
        [np.arange(0, 0.4, 1 / 200), np.arange(0.4, 2.4, 1 / 400), np.arange(2.4, 3.4, 1 / 40)]
    )
    steady = curve.steady_part(times, np.ones(len(times)))
    window = curve.usual_window(times)
    assert steady.start == pytest.approx(0.4, abs=window)
    assert steady.end == pytest.approx(2.4, abs=window)
    # At most half a window at each end is at the lower rates.
    assert steady.rate == pytest.approx(400, rel=window / (steady.end - steady.start))


@pytest.mark.parametrize("times", [[], [0.1], [0.1] * 30])
def test_no_rate_where_few_leave_or_all_at_once(times):
    """A value that does not exist is None."""
    assert curve.steady_part(np.array(times), np.ones(len(times))) is None
    assert curve.usual_window(np.array(times)) is None


def test_a_burst_that_a_gate_takes_along_has_no_steady_part(tmp_path):
    """The rate comes near its mean where a window loses the burst, and nothing leaves there."""
    burst = np.concatenate(
        [np.linspace(0.01, 0.06, 3), np.full(28, 0.06), np.linspace(0.16, 0.25, 15)]
    )
    assert curve.steady_part(burst, np.ones(len(burst))) is None
    write_moved_run(
        tmp_path, lambda s, t: falling(s, t, 0.0), silo=SILO, n_frames=5,
        out_time=lambda s: np.resize(np.append(burst, np.nan), len(s)),
    )  # fmt: skip
    numbers = curve.measure(tmp_path)
    assert numbers["steady_rate_per_s"] is None
    assert numbers["steady_note"].startswith("no steady part")
    assert write_figure(tmp_path / "burst.png", lambda: curve.draw(tmp_path)).exists()
    assert massflow.measure(tmp_path)["window_until_s"] == pytest.approx(numbers["out_times_s"][-1])


def test_moving_rate_counts_every_particle_once():
    """Windows that do not overlap hold all particles of the time that they cover."""
    times = np.sort(np.random.default_rng(1).uniform(0, 1, 300))
    middles, rate = curve.moving_rate(times, np.ones(300), 0.1)
    apart = slice(None, None, 4)  # a window is four places wide
    covered = middles[apart][-1] + 0.05
    assert rate[apart].sum() * 0.1 == pytest.approx((times < covered).sum())


def test_no_curve_where_nobody_leaves(tmp_path):
    """One line says so."""
    write_moved_run(tmp_path, lambda s, t: falling(s, t, 0.0), silo=SILO, n_frames=5)
    for ask in (curve.measure, curve.draw):
        with pytest.raises(InputError, match="0 particles left: a discharge curve needs one"):
            ask(tmp_path)


def test_curve_of_a_clogged_run_has_no_rate_but_a_picture(tmp_path):
    """Three particles leave."""
    write_moved_run(
        tmp_path, lambda s, t: falling(s, t, 0.0), silo=SILO, n_frames=5,
        out_time=lambda s: np.where(np.arange(len(s)) < 3, 0.01, np.nan),
    )  # fmt: skip
    numbers = curve.measure(tmp_path)
    assert numbers["n_out"] == 3
    assert numbers["mean_rate_per_s"] is numbers["steady_rate_per_s"] is None
    assert write_figure(tmp_path / "none.png", lambda: curve.draw(tmp_path)).exists()


def test_curve_of_a_run_is_json_and_a_picture(reference, tmp_path):
    """A real run; its steady rate is between half and twice the mean rate by definition."""
    found = find("curve")
    numbers = found.measure(reference.path)
    json.dumps(numbers, allow_nan=False)
    assert numbers["steady_rate_per_s"] == pytest.approx(numbers["mean_rate_per_s"], rel=0.5)
    assert write_figure(tmp_path / "c.png", lambda: found.draw(reference.path)).stat().st_size
