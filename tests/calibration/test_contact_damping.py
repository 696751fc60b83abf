"""Restitution to damping with uncertainty: eqs 3.8 to 3.10, both ends of a contact, Tsuji."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from calibration.bench.damping import (
    damping_ratio,
    in_parallel,
    linear_damping,
    reduced_mass_of,
    tsuji_damping_ratio,
)
from granulab.contact.material import Measured
from granulab.contact.restitution import (
    damping_for_restitution,
    linear_restitution,
    restitution_of_ratio,
    slope_of_restitution,
)

KN, PARTICLE = Measured(1e7, 1.8e6), Measured(10.8e-3, 0.3e-3)
ends = st.sampled_from(["overlap", "force"])


@settings(deadline=None)
@given(ratio=st.floats(0.0, 0.9) | st.floats(1.1, 5.0) | st.just(1.0), end=ends)
def test_the_slope_is_that_of_the_restitution(ratio, end):
    """Central differences of eqs 3.8 and 5.30. Tolerance: their h^2/6 times the third derivative,
    at most some 1e4 below the ratio 0.9, with h = 1e-5; and rounding, 1e-16/h."""
    h = 1e-5
    high, low = (restitution_of_ratio(max(ratio + side * h, 0.0), end) for side in (1, -1))
    width = h + min(ratio, h)
    assert slope_of_restitution(ratio, end) == pytest.approx(
        (high - low) / width, rel=1e-4, abs=1e-9
    )


@pytest.mark.parametrize("side", [-1, 1])
def test_the_slope_is_smooth_at_critical_damping(side):
    """Where the terms cancel the limit -4/3 e takes over; it changes by some 1e-6 there."""
    for off in (1e-9, 4e-7, 6e-7, 1e-5):
        slope = slope_of_restitution(1 + side * off, "force")
        assert slope == pytest.approx(-4 / 3 * math.exp(-2), rel=1e-4)


@pytest.mark.parametrize(("e", "wall", "gamma"), [(0.45, False, 21200), (0.53, True, 12100)])
def test_measured_restitutions_of_wood_need_more_than_the_printed_damping(e, wall, gamma):
    """Errata to sec. 3.3.3: with eqs 3.9 and 3.10 and 10.8 g. Tolerance: "about", three digits."""
    mass = PARTICLE if wall else Measured(PARTICLE.value / 2)
    assert linear_damping(Measured(e), KN, mass).value == pytest.approx(gamma, rel=5e-3)


def test_the_printed_damping_is_that_of_eight_contacts():
    """spec/silo.md: two aligned faces touch in 8 pairs; gamma_n = 6085 1/s gives 0.52 there."""
    mass = Measured(PARTICLE.value / 2)
    gamma = linear_damping(Measured(0.52), KN, mass, contacts=8).value
    assert gamma == pytest.approx(6085, rel=0.03)  # 0.52 is printed to two digits
    assert in_parallel(Measured(0.45), 8).value == pytest.approx(0.05, abs=0.005)  # errata


@settings(deadline=None)
@given(e=st.floats(0.05, 1.0), end=ends, n=st.integers(1, 8), of=st.integers(1, 8))
def test_contacts_in_parallel_give_what_their_damping_says(e, end, n, of):
    """The same through gamma, kn and mass. Tolerance: the root search, see test_restitution."""
    gamma = damping_for_restitution(e, 1e7, 5e-3, end=end, contacts=of)
    direct = linear_restitution(gamma, 1e7, 5e-3, end=end, contacts=n)
    assert in_parallel(Measured(e), n, of=of, end=end).value == pytest.approx(
        direct, rel=1e-6, abs=1e-9
    )


@pytest.mark.parametrize("end", ["overlap", "force"])
@pytest.mark.parametrize("e", [0.3, 0.53, 0.86])
def test_sigma_is_the_spread_of_what_is_drawn(end, e):
    """GUM sec. 5.1 against Monte Carlo (JCGM 101). Tolerance: 4000 draws know a standard
    deviation to 1/sqrt(2 4000) = 1.1 %; 4 of these, and 1 % for the second order of widths
    of 2 %."""
    rng = np.random.default_rng(3)
    known = Measured(e, 0.02 * e), Measured(1e7, 2e5), Measured(5.4e-3, 1e-4)
    draws = np.array([rng.normal(one.value, one.sigma, 4000) for one in known]).T
    gammas = [damping_for_restitution(*draw, end=end, contacts=2) for draw in draws]
    found = linear_damping(*known, end=end, contacts=2)
    assert found.sigma == pytest.approx(np.std(gammas), rel=0.055)
    several = [in_parallel(Measured(draw), 4, of=2, end=end).value for draw in draws[:, 0]]
    assert in_parallel(known[0], 4, of=2, end=end).sigma == pytest.approx(
        np.std(several), rel=0.055
    )


@pytest.mark.parametrize("end", ["overlap", "force"])
def test_stated_intervals_cover_the_truth(end):
    """Measurements of a known impact: 68.3 % of the intervals hold its damping. Tolerance: four
    standard deviations of a share of 2000."""
    rng = np.random.default_rng(5)
    truth = damping_for_restitution(0.7, 1e7, 5.4e-3, end=end)
    sigmas, hits = (0.02, 4e5, 1e-4), 0
    for _ in range(2000):
        drawn = rng.normal((0.7, 1e7, 5.4e-3), sigmas)
        found = linear_damping(*map(Measured, drawn, sigmas), end=end)
        hits += abs(found.value - truth) < found.sigma
    assert hits / 2000 == pytest.approx(0.683, abs=4 * math.sqrt(0.683 * 0.317 / 2000))


def test_the_terms_of_the_uncertainty():
    """gamma goes with sqrt(kn/m): half the relative width of each."""
    e, kn, mass = Measured(0.5), Measured(1e7), Measured(5e-3)
    gamma = linear_damping(e, kn, mass).value
    of_kn = linear_damping(e, Measured(1e7, 1e6), mass).sigma
    of_mass = linear_damping(e, kn, Measured(5e-3, 5e-4)).sigma
    assert (of_kn, of_mass) == pytest.approx((0.05 * gamma, 0.05 * gamma), rel=1e-12)
    both = linear_damping(e, Measured(1e7, 1e6), Measured(5e-3, 5e-4)).sigma
    assert both == pytest.approx(math.hypot(of_kn, of_mass), rel=1e-12)
    assert linear_damping(e, kn, mass).sigma is None


def test_an_elastic_contact_has_no_damping_but_an_uncertainty():
    """e = 1: b = 0 and |de/db| = pi at both ends."""
    for end in ("overlap", "force"):
        found = damping_ratio(Measured(1.0, 0.01), end)
        assert found.value == 0.0
        assert found.sigma == pytest.approx(0.01 / math.pi, rel=1e-12)


def test_reduced_mass_of_two_bodies_and_of_a_wall():
    """Eqs 3.9 and 3.10 as limits; equal bodies weighed apart: sigma/sqrt(8) each way."""
    two = reduced_mass_of(PARTICLE, PARTICLE)
    assert two.value == pytest.approx(PARTICLE.value / 2, rel=1e-15)
    assert two.sigma == pytest.approx(PARTICLE.sigma / math.sqrt(8), rel=1e-12)
    assert reduced_mass_of(PARTICLE) == PARTICLE
    heavy = reduced_mass_of(PARTICLE, Measured(1e9, 1.0))
    assert heavy.value == pytest.approx(PARTICLE.value, rel=1e-10)
    assert heavy.sigma == pytest.approx(PARTICLE.sigma, rel=1e-10)


def test_tsuji_damping_ratio_is_the_thesis_formula():
    """Eq. 5.31 with its uncertainty by the chain rule."""
    e, s = 0.86, 0.02
    log = math.log(e)
    found = tsuji_damping_ratio(Measured(e, s))
    zeta = -math.sqrt(5) / 2 * log / math.hypot(log, math.pi)
    slope = math.sqrt(5) / 2 * math.pi**2 / (e * (log**2 + math.pi**2) ** 1.5)
    assert (found.value, found.sigma) == pytest.approx((zeta, slope * s), rel=1e-12)
