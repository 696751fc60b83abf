"""Excitations against their closed forms: tables, spectra, sweeps, pulses, and the empty host."""

import math
from itertools import pairwise

import numpy as np
import pytest
from damper_scenes import ball_on_a_turning_floor
from hypothesis import example, given, settings
from hypothesis import strategies as st

from damper3d.case.excitation import forms
from damper3d.case.excitation.excitation import excitation_of
from damper3d.case.excitation.forms import Lines, Size, Sweep
from damper3d.case.excitation.recorded import Signal, means_of, motion_of
from damper3d.case.host.host import bare_rows
from damper3d.case.host.modes import Modes
from damper3d.case.settings import Settings
from damper3d.engine.motions import Table, displacement, velocity
from damper3d.measures.counted import largest_sum

PSD = np.array([[20.0, 0.5], [80.0, 4.0], [500.0, 0.1]])  # (m/s2)^2/Hz


def at(motion, times) -> np.ndarray:
    return np.array([(displacement(motion, t), velocity(motion, t)) for t in times])


def test_a_table_of_a_sine_is_the_sine_to_the_error_of_hermites_polynomials():
    """(w h)^4/384 of the amplitude; its velocity to (w h)^3/(72 sqrt 3), the error's derivative."""
    omega, n = 2.0 * math.pi, 40
    h = 1.0 / n
    place = np.arange(2 * n + 1) * h
    table = Table(np.sin(omega * place), omega * np.cos(omega * place), h)
    times = np.linspace(0.0, 1.99, 997)
    off = np.abs(at(table, times) - np.column_stack([np.sin(omega * times),
                                                     omega * np.cos(omega * times)]))  # fmt: skip
    assert off[:, 0].max() < 1.01 * (omega * h) ** 4 / 384
    assert off[:, 1].max() < 1.01 * omega * (omega * h) ** 3 / (72 * math.sqrt(3))


def test_the_velocity_of_a_table_is_the_derivative_of_its_displacement():
    """By central differences, whose error is that of rounding, 1e-16 over the step."""
    rng = np.random.default_rng(3)
    table = Table(rng.normal(size=9), rng.normal(size=9), 0.25)
    times, d = rng.uniform(0.01, 2.4, 50), 1e-6
    times = times[np.abs(times / 0.25 - np.rint(times / 0.25)) > 1e-3]
    slope = (at(table, times + d)[:, 0] - at(table, times - d)[:, 0]) / (2 * d)
    assert np.allclose(slope, at(table, times)[:, 1], atol=1e-8)


def test_a_random_signal_has_the_power_of_its_density_in_each_third_octave():
    """From its lines to rounding; of the table itself by its Fourier series, over a period."""
    period = 2.0
    lines = forms.random_lines(PSD, "m/s2", 7, period)
    assert np.abs(forms.band_errors(lines, PSD, "m/s2", period)).max() < 1e-10
    table = forms.random_table(lines, period, period)
    n = round(period / table.spacing)
    series = 2.0 * np.abs(np.fft.rfft(table.rate[:n])) / n  # of velocity
    frequency = np.arange(len(series)) / period
    power = 0.5 * (series * 2.0 * math.pi * frequency) ** 2
    bands = forms.third_octaves(PSD, period)
    found = np.histogram(frequency, bands, weights=power)[0]
    assert 10 * np.abs(np.log10(found / forms.power_between(PSD, bands))).max() < 1e-6
    assert (np.histogram(frequency[power > 0], bands)[0] >= forms.LINES).all()


def test_the_power_of_a_density_is_its_integral():
    """Of log-log lines, slope -1 among them, beside a fine sum of the trapezoidal rule."""
    psd = np.array([[10.0, 1.0], [20.0, 0.5], [100.0, 3.0]])
    f = np.geomspace(10.0, 100.0, 200_001)
    whole = float(np.trapezoid(forms.density(psd, f), f))
    found = forms.power_between(psd, np.array([10.0, 14.0, 33.0, 100.0]))
    assert found.sum() == pytest.approx(whole, rel=1e-8)
    assert found[0] == pytest.approx(10.0 * math.log(1.4), rel=1e-12)  # S = 10/f


def test_seeds_change_the_phases_of_a_random_signal_and_nothing_else():
    first, second = (forms.random_lines(PSD, "m/s2", seed, 1.0) for seed in (1, 2))
    assert (first.amplitude == second.amplitude).all()
    assert not np.allclose(first.phase, second.phase)


@pytest.mark.parametrize("logarithmic", [True, False])
def test_a_sweep_has_its_amplitude_and_as_many_cycles_as_its_frequency_says(logarithmic):
    """Cycles: the integral of f, T (f1 - f0)/ln(f1/f0) or T (f0 + f1)/2."""
    sweep = Sweep(10.0, 40.0, 8.0, logarithmic, 0, False)
    table = sweep.table(Size(5.0, "m/s2"))
    mean = 30.0 / math.log(4.0) if logarithmic else 25.0
    crossings = np.count_nonzero(np.diff(np.sign(table.place[1:])))
    assert abs(crossings - 2 * 8.0 * mean) < 2
    # A' and A'' of a/omega^2 add 2 f'/(pi f^2) at most: 1 % of the acceleration at 10 Hz.
    inside = np.diff(table.rate)[: int(8.0 / table.spacing)] / table.spacing
    assert np.abs(inside).max() == pytest.approx(5.0, rel=0.01)


def test_a_sweep_back_has_the_frequencies_of_the_way_there():
    sweep = Sweep(10.0, 40.0, 8.0, True, 0, True)
    time = np.linspace(0.0, 8.0, 33)
    assert np.allclose(sweep.frequency(time), sweep.frequency(16.0 - time))
    steps = Sweep(10.0, 40.0, 8.0, True, 4, False).frequency(time)
    assert np.allclose(np.unique(steps), np.geomspace(10.0, 40.0, 4))


@pytest.mark.parametrize("ends", [(20.0, 80.0), (80.0, 20.0)])
@pytest.mark.parametrize("steps", [2, 12, 40])
def test_a_stepped_sweep_keeps_its_level_where_the_frequency_changes(steps, ends):
    """The change takes two cycles at least, in which A' and A'' add 3 % at most; 5 % are asked."""
    table = Sweep(*ends, 8.0, True, steps, True).table(Size(20.0, "m/s2"))
    inside = np.diff(table.rate)[: int(16.0 / table.spacing)] / table.spacing
    assert np.abs(inside).max() == pytest.approx(20.0, rel=0.05)
    moved = np.diff(table.place) / table.spacing  # by its velocity: the displacement never jumps
    mean = 0.5 * (table.rate[1:] + table.rate[:-1])
    assert np.abs(moved - mean).max() < 0.01 * np.abs(table.rate).max()


@pytest.mark.parametrize(("form", "change"), [("half_sine", 2 / math.pi), ("terminal_peak", 0.5)])
def test_a_pulse_changes_the_velocity_by_its_area_which_stays(form, change):
    pulse = forms.pulse(form, Size(300.0, "m/s2"), 0.011)
    assert velocity(pulse, 0.02) == pytest.approx(change * 300.0 * 0.011, rel=1e-12)
    assert displacement(pulse, 0.021) - displacement(pulse, 0.02) == pytest.approx(
        0.001 * velocity(pulse, 0.02)
    )
    accelerations = np.diff(pulse.rate) / pulse.spacing
    assert accelerations.max() == pytest.approx(300.0, rel=2e-3)  # means over 1/800 of it
    force = forms.pulse(form, Size(7.0, "N"), 0.011)
    assert displacement(force, 0.03) == 0.0
    assert np.abs(force.place).max() == pytest.approx(7.0)


def test_a_measured_acceleration_gives_back_the_motion_it_was_measured_on():
    """By the trapezoidal rule: (w h)^2/12 of the velocity, twice of the displacement."""
    omega, h = 2.0 * math.pi * 5.0, 1e-3
    time = h * np.arange(2001)  # ten cycles
    signal = Signal(-(omega**2) * 1e-3 * np.sin(omega * time) + 2.0, "m/s2", h)  # an offset too
    motion = motion_of(signal, balanced=True)
    wanted = 1e-3 * np.sin(omega * time)
    assert np.allclose(motion.place - motion.place.mean(), wanted, atol=1e-3 * (omega * h) ** 2)
    off = means_of(signal, balanced=True)
    assert off.acceleration == pytest.approx(2.0, rel=1e-12)
    assert -off.velocity == pytest.approx(1e-3 * omega, rel=1e-3) == motion.rate[0]
    as_measured = motion_of(signal, balanced=False)
    assert as_measured.rate[-1] == pytest.approx(2.0 * 2.0, rel=1e-3)  # the offset's velocity


def host_under(motion, on: str, lines: Lines | None, time_step: float, n: int, every: int):
    from damper3d.case.excitation.excitation import Excitation

    modes = Modes.single(0.5, 2.0 * math.pi * 30.0, 0.02)
    excitation = Excitation("sines", on, motion, 0.1, 1, 0, 100.0, lines)
    return modes, bare_rows(modes, excitation, time_step, n, every)[0]


@pytest.mark.parametrize("on", ["force", "base"])
def test_an_empty_host_under_sines_moves_as_the_closed_form_says(on):
    """To (w h)^2/24 of each line's response, the error of kicks; w the line's or the host's."""
    omega = 2.0 * math.pi * np.array([22.0, 47.0])
    size = np.array([3.0, 2.0]) if on == "force" else np.array([1e-3, 4e-4])
    lines = Lines(size, omega, np.array([0.3, 1.1]))
    h, every, n = 1e-5, 20, 2000
    modes, found = host_under(lines.motion(), on, lines, h, n, every)
    time = h * every * np.arange(n + 1)
    wanted = np.zeros(n + 1)
    for a, w, p in zip(size, omega, lines.phase, strict=True):
        k, c, m = 0.5 * modes.omega[0] ** 2, 2 * 0.02 * modes.omega[0] * 0.5, 0.5
        above = a if on == "force" else (k + 1j * w * c) * a
        x = above / (k - w**2 * m + 1j * w * c) * np.exp(1j * p)
        wanted += (x * np.exp(1j * w * time)).imag
    bound = (omega.max() * h) ** 2 / 24
    assert np.abs(found - wanted).max() < 4 * bound * np.abs(wanted).max()


def test_an_empty_host_under_random_force_has_the_spectrum_of_its_receptance():
    """|H|^2 S, line by line over the period of the signal, in which the response repeats."""
    period = 1.0
    psd = np.array([[10.0, 0.4], [100.0, 0.4]])  # N^2/Hz
    lines = forms.random_lines(psd, "N", 5, period)
    table = forms.random_table(lines, period, 1.1 * period)
    h, every = 2.5e-5, 40
    n = round(period / (h * every))
    modes, found = host_under(table, "force", lines, h, n, every)
    series = 2.0 * np.abs(np.fft.rfft(found[:n])) / n
    at_lines = np.rint(lines.omega * period / (2 * math.pi)).astype(int)
    q = modes.receptance(lines.omega, lines.amplitude * modes.force_shape[0])
    assert np.allclose(series[at_lines], np.abs(modes.shape[0] * q), rtol=1e-4, atol=1e-9)


@settings(deadline=None, max_examples=30)
@given(st.lists(st.floats(-3, 3), min_size=3, max_size=8))
@example([1.0, 5e-324, 0.0, 0.5])
def test_the_largest_sum_is_that_of_the_best_choice_of_times(speeds):
    """Beside all subsets of them; each lasts, so that no parabola rounds it."""
    v = np.repeat(np.array(speeds), 3)
    best = 0.0
    for chosen in range(1, 2 ** len(speeds)):
        picked = [s for k, s in enumerate(speeds) if chosen >> k & 1]
        best = max(best, float(sum((b - a) ** 2 for a, b in pairwise(picked))))
    assert largest_sum(v, len(v) - 1)[-1] == pytest.approx(best, abs=1e-9)


def test_the_most_energy_of_a_sine_is_4_v_squared_a_cycle():
    """(M/2) times twice (2 V)^2; cos has its extremes at samples."""
    v = np.cos(2.0 * np.pi * np.arange(5 * 100 + 1) / 100)
    assert np.diff(largest_sum(v, 100)) == pytest.approx(np.full(5, 8.0), rel=1e-12)
    shifted = np.cos(2.0 * np.pi * (np.arange(501) + 0.37) / 100)
    assert np.diff(largest_sum(shifted, 100))[1:-1] == pytest.approx(np.full(3, 8.0), rel=1e-6)


def test_common_periods_of_sines():
    assert forms.common_period([20.0, 30.0]) == pytest.approx(0.1)
    assert forms.common_period([40.0]) == pytest.approx(0.025)
    assert forms.common_period([20.0, 20.0 * math.sqrt(2)]) is None


def test_without_keys_there_is_no_excitation(tmp_path):
    assert excitation_of(Settings(), False, 0.0, 0.0, tmp_path, "case") is None


@pytest.mark.validation  # compiles kernels of its own
def test_a_wall_that_turns_drags_what_touches_it_along():
    """A ball on the floor of a spinning cylinder, 8 mm off the axis, is pushed as the floor moves.

    Friction mu m g acts until it rolls or moves along: the speed after a time t is mu g t, along
    (0, w x), for t far below the time w x/(mu g) that the floor's speed takes.
    """
    speed, sliding = ball_on_a_turning_floor(rate=200.0, off=8e-3, time=4e-3)
    assert speed[1] == pytest.approx(sliding, rel=0.02)  # the contact settles in some 1e-5 s
    assert abs(speed[0]) < 0.05 * sliding  # the floor turns away by w t x mu g t^2/2
