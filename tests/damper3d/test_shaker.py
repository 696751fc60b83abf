"""The enclosure's motion: eq. 6.2 of the thesis, its derivative, its ramp, and sums of sines."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from damper3d.engine.motions import Sines, displacement, sine, velocity

G = 9.81


@pytest.mark.parametrize(("gamma", "frequency"), [(1.0, 20.0), (20.0, 40.0), (100.0, 1024.0)])
def test_one_sine_is_equation_6_2(gamma, frequency):
    """u = (Gamma g/omega^2) sin(omega t), and its largest acceleration is Gamma g.

    The second difference over h is off by (omega h)^2/12 = 8e-8 and by rounding, eps over
    (omega h)^2 = 2e-10, for omega h = 1e-3.
    """
    shaker, omega = sine(gamma, frequency, G), 2 * math.pi * frequency
    for t in np.linspace(0, 3 / frequency, 17):
        wanted = gamma * G / omega**2 * math.sin(omega * t)
        assert displacement(shaker, t) == pytest.approx(wanted, rel=1e-12, abs=1e-15)
    quarter, h = 0.25 / frequency, 1e-3 / omega
    before, at, after = (displacement(shaker, quarter + k * h) for k in (-1, 0, 1))
    assert (2 * at - before - after) / h**2 == pytest.approx(gamma * G, rel=2e-7)


def test_without_a_ramp_the_motion_begins_with_its_largest_velocity():
    """Gamma g/omega at once, as in the thesis; with one it begins at rest."""
    omega = 2 * math.pi * 40
    assert velocity(sine(20.0, 40.0, G), 0.0) == pytest.approx(20 * G / omega, rel=1e-15)
    assert displacement(sine(20.0, 40.0, G), 0.0) == 0.0
    assert velocity(sine(20.0, 40.0, G, ramp=2), 0.0) == 0.0


def sums_of_sines() -> st.SearchStrategy[Sines]:
    part = st.tuples(st.floats(1e-6, 1e-2), st.floats(10, 1e4), st.floats(0, 2 * math.pi))
    ramp = st.sampled_from([0.0, 1e-3, 0.5])
    return st.builds(
        lambda parts, ramp_time: Sines(*np.array(parts).T.copy(), ramp_time),
        st.lists(part, min_size=1, max_size=4),
        ramp,
    )


@given(sums_of_sines(), st.floats(0, 1))
def test_the_velocity_is_the_derivative_of_the_displacement(shaker, t):
    """Central difference over h: error h^2/6 of the third derivative, and rounding eps u/h."""
    fastest = shaker.omega.max() + (2 * math.pi / shaker.ramp_time if shaker.ramp_time else 0.0)
    h = 1e-4 / fastest
    if shaker.ramp_time and abs(t - shaker.ramp_time) <= 2 * h:
        return  # the curvature of the ramp jumps where it ends
    t = max(t, h)
    slope = (displacement(shaker, t + h) - displacement(shaker, t - h)) / (2 * h)
    size = shaker.amplitude.sum()
    phase_rounding = 1e-15 * size * (1 + fastest * t) / h
    assert abs(slope - velocity(shaker, t)) < h**2 * size * fastest**3 + phase_rounding


@given(sums_of_sines(), st.floats(0, 1))
def test_several_sines_add_up(shaker, t):
    """Displacement and velocity of the sum are the sums of the parts', under one ramp.

    The tolerance is rounding, of as many terms as there are sines.
    """
    parts = [
        Sines(*(column[k : k + 1] for column in shaker[:3]), shaker.ramp_time)
        for k in range(len(shaker.amplitude))
    ]
    for function, size in (
        (displacement, shaker.amplitude.sum()),
        (velocity, (shaker.amplitude * shaker.omega).sum() + 4e3 * shaker.amplitude.sum()),
    ):
        total = sum(function(part, t) for part in parts)
        assert function(shaker, t) == pytest.approx(total, abs=1e-14 * size)


@pytest.mark.parametrize("cycles", [0.5, 2.0, 3.7])
def test_a_ramp_grows_from_nothing_and_then_leaves_the_motion_alone(cycles):
    """The amplitude at a part x of the ramp is sin^2(pi x/2); displacement and velocity join."""
    full, ramped = sine(5.0, 50.0, G), sine(5.0, 50.0, G, ramp=cycles)
    end = cycles / 50.0
    for x in (0.1, 0.5, 0.9):
        wanted = math.sin(0.5 * math.pi * x) ** 2 * displacement(full, x * end)
        assert displacement(ramped, x * end) == pytest.approx(wanted, rel=1e-12)
    for t in (end, 1.3 * end):
        assert displacement(ramped, t) == displacement(full, t)
        assert velocity(ramped, t) == velocity(full, t)
    just_before = end * (1 - 1e-9)
    assert displacement(ramped, just_before) == pytest.approx(
        displacement(full, just_before), rel=1e-9
    )
    assert velocity(ramped, just_before) == pytest.approx(velocity(full, just_before), rel=1e-6)
