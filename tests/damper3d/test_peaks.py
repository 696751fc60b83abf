"""Peaks of made efficiencies whose maximum is known: found, located, bracketed, beyond noise."""

import numpy as np
import pytest
from fuzzing import examples
from hypothesis import given, settings
from hypothesis import strategies as st

from damper3d.studies.map.peaks import between, find_peaks

GAMMAS = np.array(
    [1, 1.5, 2, 3, 4, 5, 6, 7, 8, 10, 12, 15, 20, 30, 40, 50, 60, 80, 100], float
)  # thesis Table 6.1


def hump(gamma, at, height=0.4, width=0.5):
    """A parabola in ln Gamma about its peak, which it leaves at `width` for zero."""
    return height * np.maximum(1 - (np.log(np.asarray(gamma) / at) / width) ** 2, 0.0)


def onset(gamma, at):
    """The shape of a bouncing bed: steep below its peak, slow beyond (Figs 6.8, 6.9)."""
    x = np.log(np.asarray(gamma) / at)
    return np.where(x < 0, np.exp(12 * x), np.exp(-0.8 * x))


@settings(deadline=None)  # scipy is imported in the first call
@given(st.floats(2.0, 60.0))
def test_parabola_in_log_gamma_is_found_exactly(at):
    """Three points determine it, wherever its vertex lies between them. The width leaves all
    three above zero."""
    eta = hump(GAMMAS, at, width=1.0)
    (peak,) = find_peaks(GAMMAS, eta, np.zeros_like(eta))
    assert peak.gamma == pytest.approx(at, rel=1e-9)
    assert peak.efficiency == pytest.approx(0.4, rel=1e-9)
    assert peak.low == pytest.approx(peak.high, rel=1e-12)  # no noise


def test_two_ridges_are_two_peaks():
    eta = hump(GAMMAS, 3.0) + hump(GAMMAS, 22.0, height=0.7)
    peaks = find_peaks(GAMMAS, eta, np.full_like(eta, 0.02))
    assert [round(peak.gamma) for peak in peaks] == [3, 22]
    assert peaks[0].prominence == pytest.approx(eta[3], abs=1e-12)  # zero lies between them
    assert peaks[0].bracket == (2.0, 4.0)


def test_what_rises_to_the_end_of_the_grid_has_no_peak_in_it():
    for eta in (np.linspace(0, 1, 19), np.linspace(1, 0, 19)):
        assert find_peaks(GAMMAS, eta, np.zeros(19)) == []


def test_a_bump_within_the_noise_is_no_peak():
    """A difference of two values is believed beyond the root of the sum of their squares."""
    eta = np.full(19, 0.2)
    eta[9] += 0.05
    assert find_peaks(GAMMAS, eta, np.full(19, 0.036)) == []  # 0.0509 > 0.05
    assert len(find_peaks(GAMMAS, eta, np.full(19, 0.034))) == 1  # 0.0481


def drawn_peaks(width, sd=0.004, at=11.0, draws=400):
    """The highest peak of each of many noisy parabolas."""
    rng = np.random.default_rng(3)
    gamma = GAMMAS[3:15]
    for _ in range(draws):
        eta = hump(gamma, at, width=width) + rng.normal(scale=sd, size=len(gamma))
        peaks = find_peaks(gamma, eta, np.full(len(gamma), 1.96 * sd))
        yield max(peaks, key=lambda peak: peak.prominence)


@pytest.mark.parametrize("width", [1.0, 3.0])
def test_peak_of_noisy_points_lies_in_its_bracket_and_mostly_in_its_interval(width):
    """Noise of known 95 % half width on a parabola that falls by 0.9 and by 0.1 sd to the points
    next to its peak. The bracket needs one of two points to be wrong by the noise of a difference:
    at most 5 % of draws. The interval is too narrow where the noise chose the points; 75 % is
    three standard deviations of the share (0.02) below the 81 % that were found."""
    peaks = list(drawn_peaks(width))
    assert sum(p.bracket[0] <= 11.0 <= p.bracket[1] for p in peaks) >= 380
    assert sum(p.low <= 11.0 <= p.high for p in peaks) >= 300


def test_noise_widens_the_fit_until_its_points_differ():
    """Next to the top, points within the noise say nothing of where the peak is."""
    gamma = np.geomspace(10, 30, 41)
    eta = hump(gamma, 17.0, width=0.8)
    eta[21] += 0.01  # the noise puts the top off the peak
    (peak,) = find_peaks(gamma, eta, np.full(41, 0.01))
    assert peak.gamma == pytest.approx(17.0, rel=0.03)
    assert peak.bracket[0] <= peak.low < peak.high <= peak.bracket[1]


def refined(function, gammas, rounds):
    """The points, and the values there, after rounds of halving."""
    gammas = np.array(gammas, float)
    for _ in range(rounds):
        eta = function(gammas)
        gammas = np.union1d(gammas, between(gammas, eta, np.zeros_like(gammas)))
    return gammas, function(gammas)


@settings(max_examples=examples(50), deadline=None)
@given(st.floats(3.5, 70.0), st.integers(1, 6))
def test_refinement_brackets_a_planted_peak_twice_as_closely_each_round(at, rounds):
    """One steep-sided maximum: after n rounds it lies between the neighbours of the best point,
    which are 2^-n of the widest interval of the grid (ln 1.5) from it. Rounding the points to
    four digits moves each by at most 5e-4 of itself, a round."""
    gammas, eta = refined(lambda g: onset(g, at), GAMMAS, rounds)
    (peak,) = find_peaks(gammas, eta, np.zeros_like(eta))
    low, high = peak.bracket
    assert low < at < high
    widest = np.log(1.5) / 2**rounds + rounds * 1e-3
    assert np.log(high / gammas[peak.index]) <= widest
    assert np.log(gammas[peak.index] / low) <= widest


def test_refinement_adds_two_points_a_peak_and_is_deterministic():
    eta = hump(GAMMAS, 3.0) + hump(GAMMAS, 22.0, height=0.7)
    added = between(GAMMAS, eta, np.zeros_like(eta))
    assert added == [2.449, 3.464, 17.32, 24.49]  # roots of 2 3, 3 4, 15 20, 20 30
    assert added == between(GAMMAS, eta, np.zeros_like(eta))


def test_refinement_ends_where_rounding_leaves_nothing_between():
    gammas = np.array([9.999, 10.0, 10.01])
    assert between(gammas, [0.1, 0.3, 0.1], np.zeros(3)) == []
