"""Restitution from damping and back, against the equation of motion and published values."""

import math

import numpy as np
import pytest
from analytic import (
    ENDING_AT_ZERO_FORCE,
    angular_frequency,
    damped,
    damping_of_restitution,
    restitution_at_zero_overlap,
)
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from granulab.contact.restitution import damping_for_restitution, linear_restitution

KN, M = 1e7, 5e-3  # [N/m], [kg]
OMEGA0 = angular_frequency(KN, M)

ends = st.sampled_from(["overlap", "force"])


@pytest.mark.parametrize("ratio", [0.01, 0.1, 0.25, 0.5, 0.9, 0.99])
def test_both_ends_follow_from_the_equation_of_motion(ratio):
    """The impact ends where the solution of d'' + gamma d' + omega0^2 d = 0 has no overlap, or
    no force, for the first time; found by a root search. Tolerance: the search's."""
    gamma = 2 * ratio * OMEGA0
    w = OMEGA0 * math.sqrt(1 - ratio**2)

    def force(t):
        overlap, rate = damped(OMEGA0, gamma, t)
        return OMEGA0**2 * overlap + gamma * rate

    _, leaving = damped(OMEGA0, gamma, math.pi / w)
    assert linear_restitution(gamma, KN, M) == pytest.approx(-leaving, rel=1e-12)
    assert linear_restitution(gamma, KN, M) == pytest.approx(
        restitution_at_zero_overlap(OMEGA0, gamma), rel=1e-12
    )
    # The force starts at gamma v > 0, ends below zero, and has one zero between.
    end = brentq(force, 0.0, math.pi / w, xtol=1e-18, rtol=1e-14)
    _, leaving = damped(OMEGA0, gamma, end)
    assert linear_restitution(gamma, KN, M, end="force") == pytest.approx(-leaving, rel=1e-10)


@pytest.mark.parametrize(("wanted", "higher"), ENDING_AT_ZERO_FORCE.items())
def test_cutting_the_force_raises_restitution_as_published(wanted, higher):
    """Schwager and Poeschel 2007; the values are given to three digits."""
    gamma = damping_of_restitution(OMEGA0, wanted)
    assert linear_restitution(gamma, KN, M, end="force") == pytest.approx(higher, abs=5e-4)


@pytest.mark.parametrize("ratio", [1.0, 1.5, 3.0, 30.0])
def test_overdamped_contact(ratio):
    """Overdamped, the overlap never comes back to zero; the force does, where
    exp(-(b - W) t) and exp(-(b + W) t) balance. Tolerance: cancellation in b - W."""
    gamma = 2 * ratio * OMEGA0
    assert linear_restitution(gamma, KN, M) == 0.0
    e = linear_restitution(gamma, KN, M, end="force")
    if ratio == 1.0:
        assert e == pytest.approx(math.exp(-2), rel=1e-14)
        return
    b, w = ratio * OMEGA0, OMEGA0 * math.sqrt(ratio**2 - 1)
    # d = exp(-b t) sinh(W t)/W; zero force is d'' = 0, tanh(W t) = 2 b W/(b^2 + W^2).
    t = math.atanh(2 * b * w / (b**2 + w**2)) / w
    leaving = math.exp(-b * t) * (math.cosh(w * t) - b / w * math.sinh(w * t))
    assert e == pytest.approx(-leaving, rel=1e-16 * ratio**4 + 1e-12)


def test_zero_force_is_continuous_at_critical_damping():
    """e(b) is smooth there; a step of 1e-8 in the damping ratio moves it by as little."""
    below, at, above = (
        linear_restitution(2 * ratio * OMEGA0, KN, M, end="force")
        for ratio in (1 - 1e-8, 1.0, 1 + 1e-8)
    )
    assert below == pytest.approx(at, abs=1e-7)
    assert above == pytest.approx(at, abs=1e-7)
    assert below > at > above


@given(e=st.floats(0.01, 1.0), end=ends, kn=st.floats(1e3, 1e9), m=st.floats(1e-6, 1e3))
def test_damping_for_restitution_gives_it_back(e, end, kn, m):
    """Tolerance: the root search's 1e-14 in the log of the ratio, magnified by |d ln e/d ln b|,
    at most some 5 for the end at zero force; near e = 1 by cancellation in 1 - ln."""
    gamma = damping_for_restitution(e, kn, m, end=end)
    assert linear_restitution(gamma, kn, m, end=end) == pytest.approx(e, rel=1e-12)


@given(gamma=st.floats(0.0, 1e5), end=ends, n=st.integers(1, 8))
def test_parallel_contacts_are_one_with_all_their_constants(gamma, end, n):
    """n springs and n dashpots between the same two bodies. Tolerance: rounding, which
    sqrt(1 - ratio^2) magnifies near critical damping."""
    together = linear_restitution(gamma, KN, M, end=end, contacts=n)
    assert together == pytest.approx(
        linear_restitution(n * gamma, n * KN, M, end=end), rel=1e-6, abs=1e-12
    )


@pytest.mark.parametrize(
    ("gamma", "contacts", "reduced_masses", "e"),
    [
        (6085.0, 1, 0.5, 0.80),
        (6085.0, 8, 0.5, 0.53),
        (4303.0, 1, 1.0, 0.80),
        (4303.0, 2, 1.0, 0.73),
    ],
)
def test_published_dampings(gamma, contacts, reduced_masses, e):
    """The wood-silo paper's gamma_n with its 10 mm x 20 mm x 120 mm particles of 10.8 g: one
    restitution for one contact, and what faces give that touch in several pairs. Tolerance: the
    second digit."""
    m = reduced_masses * 10.8e-3
    assert linear_restitution(gamma, 1e7, m, contacts=contacts) == pytest.approx(e, abs=0.01)


@pytest.mark.parametrize("e", [0.0, -0.1, 1.1, math.nan])
@pytest.mark.parametrize("end", ["overlap", "force"])
def test_impossible_restitution_is_refused(e, end):
    with pytest.raises(ValueError, match=r"restitution = .*: must be in \(0, 1\]"):
        damping_for_restitution(e, KN, M, end=end)


@given(ratios=st.lists(st.floats(1e-3, 10.0), min_size=2, max_size=2, unique=True), end=ends)
def test_more_damping_gives_less(ratios, end):
    low, high = sorted(ratios)
    e_low, e_high = (linear_restitution(2 * r * OMEGA0, KN, M, end=end) for r in (low, high))
    assert e_low >= e_high
    assert np.isfinite(e_low)
