"""The linear contact law by itself: forces, the Coulomb limit, dimensions, one to three numbers."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal

from granulab.contact import laws, vectors
from granulab.contact.laws import LinearLaw, coulomb, normal_force, tangential_force
from granulab.contact.reduced import reduced_mass

LAW = LinearLaw(kn=1e7, kt=6.5e5, mu=0.38, gamma_n=6085.0, gamma_t=30.0, pulls=True)
M = 5e-3  # [kg]

# Nothing between zero and a size whose square still has all its digits.
overlaps = st.just(0.0) | st.floats(1e-12, 1e-4)
slips = st.just(0.0) | st.floats(1e-12, 1e-3) | st.floats(-1e-3, -1e-12)
rates = st.floats(-10.0, 10.0)
vectors_of_2 = st.tuples(slips, slips)
compiling = settings(deadline=None)  # the first call of a kernel compiles it


@compiling
@given(overlap=overlaps, rate=rates)
def test_normal_force_is_spring_and_dashpot(overlap, rate):
    """Wood-silo paper, eq. 2.1: f_n = kn d + m gamma_n d'. Tolerance: rounding."""
    force, damping = normal_force(LAW, M, overlap, rate)
    scale = 1e7 * overlap + M * 6085.0 * abs(rate)
    assert force == pytest.approx(1e7 * overlap + M * 6085.0 * rate, abs=1e-15 * scale)
    assert damping == pytest.approx(M * 6085.0 * rate, abs=1e-15 * scale)


@compiling
@given(overlap=overlaps, rate=rates)
def test_contact_that_ends_at_zero_force_never_pulls(overlap, rate):
    """Where the dashpot would outweigh the spring the force is zero, and the dashpot takes just
    what the spring gives."""
    pulling, _ = normal_force(LAW, M, overlap, rate)
    force, damping = normal_force(LAW._replace(pulls=False), M, overlap, rate)
    assert force == max(pulling, 0.0)
    assert damping == force - 1e7 * overlap


@compiling
@given(overlap=overlaps, slip=slips, step=slips, rate=rates)
def test_coulomb_limits_the_spring_and_leaves_the_dashpot(overlap, slip, step, rate):
    """Wood-silo paper, eqs 2.2 and 2.3: f_t = -kt s - m gamma_t s', |kt s| <= mu kn d; the
    dashpots are in neither side of the limit. Tolerance: rounding."""
    (force,), (held,), _ = tangential_force(LAW, M, overlap, (slip,), (step,), (rate,))
    limit = 0.38 * 1e7 * overlap
    spring = np.clip(6.5e5 * (slip + step), -limit, limit)
    scale = 1e-14 * (abs(spring) + M * 30.0 * abs(rate)) + 1e-300
    assert abs(6.5e5 * held) <= limit * (1 + 1e-15)
    assert 6.5e5 * held == pytest.approx(spring, abs=scale)
    assert force == pytest.approx(-spring - M * 30.0 * rate, abs=scale)


@compiling
@given(slip=vectors_of_2, step=vectors_of_2, overlap=overlaps)
def test_sliding_spring_keeps_its_direction(slip, step, overlap):
    """In space the limit shortens the slip and does not turn it. Tolerance: rounding."""
    trial = np.add(slip, step)
    _, held, _ = tangential_force(LAW, M, overlap, slip, step, (0.0, 0.0))
    limit = 0.38 * 1e7 * overlap / 6.5e5
    size = np.hypot(*trial)
    expected = trial * (limit / size) if size > limit else trial
    assert_allclose(held, expected, rtol=1e-14, atol=1e-20)


@compiling
@given(overlap=overlaps, slip=slips, step=slips, rate=rates)
def test_tangent_spaces_of_one_two_and_three_numbers_agree(overlap, slip, step, rate):
    """A law in the plane is the law in space with the other components zero, bit for bit but for
    the root and the quotient that shorten a vector. Tolerance: their rounding."""
    rest = 0.0, 0.0
    line = tangential_force(LAW, M, overlap, (slip,), (step,), (rate,))
    for n in (1, 2):
        more = rest[:n]
        space = tangential_force(LAW, M, overlap, (slip, *more), (step, *more), (rate, *more))
        for part in (0, 1):
            assert space[part][0] == pytest.approx(line[part][0], rel=1e-14, abs=1e-25)
            assert_array_equal(space[part][1:], np.zeros(n))
        assert space[2] == pytest.approx(line[2], rel=1e-12, abs=1e-25)


@compiling
@given(limit=overlaps, trial=vectors_of_2)
def test_coulomb_limit_is_a_projection(limit, trial):
    """Projecting twice is projecting once; what is short enough stays the same bits. Tolerance:
    a shortened vector may be a rounding error too long."""
    held = coulomb(trial, limit)
    assert vectors.norm(held) <= limit * (1 + 1e-14) or held == trial
    assert_allclose(coulomb(held, limit), held, rtol=1e-14, atol=0)
    if vectors.norm(trial) <= limit:
        assert held == trial


@compiling
@given(slip=slips, step=slips, overlap=overlaps)
def test_a_spring_that_holds_dissipates_nothing(slip, step, overlap):
    """Friction dissipates only while it slides, and then takes energy, never gives it."""
    limit = 0.38 * 1e7 * overlap / 6.5e5
    slip = float(np.clip(slip, -limit, limit))
    _, (held,), friction = tangential_force(LAW, M, overlap, (slip,), (step,), (0.0,))
    if held == slip + step:
        assert friction == 0.0
    elif slip * held >= 0:  # a step over the middle would count partly against its direction
        assert friction >= 0.0


@compiling
@given(m_i=st.floats(1e-4, 1.0), m_j=st.floats(1e-4, 1.0))
def test_reduced_mass(m_i, m_j):
    """m_i m_j/(m_i + m_j); a wall has no inverse mass and leaves the particle's own."""
    assert reduced_mass(1 / m_i, 1 / m_j) == pytest.approx(m_i * m_j / (m_i + m_j), rel=1e-14)
    assert reduced_mass(1 / m_i, 0.0) == pytest.approx(m_i, rel=1e-15)


@pytest.fixture
def uncompiled(monkeypatch):
    """The law's functions as Python, which take numbers with units."""

    def python(function):
        return getattr(function, "py_func", function)

    for name in ("add", "scale", "dot", "norm"):
        monkeypatch.setattr(laws, name, python(getattr(vectors, name)))
    monkeypatch.setattr(vectors, "dot", python(vectors.dot))
    monkeypatch.setattr(laws, "coulomb", python(laws.coulomb))
    return python


@pytest.mark.parametrize("pulls", [True, False])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_dimensions(uncompiled, pulls, n):
    """Forces are forces, slips lengths, and friction's dissipation is an energy, sliding or
    holding, in every number of tangential components."""
    import pint

    unit = pint.UnitRegistry()
    law = LinearLaw(
        kn=1e7 * unit("N/m"),
        kt=6.5e5 * unit("N/m"),
        mu=0.38 * unit(""),
        gamma_n=6085.0 * unit("1/s"),
        gamma_t=3.0 * unit("1/s"),
        pulls=pulls,
    )
    m, overlap, rate = 5.0 * unit.gram, 1e-2 * unit.mm, 0.1 * unit("m/s")
    for part in uncompiled(normal_force)(law, m, overlap, rate):
        assert part.check("[force]")
    for step in (1e-3 * unit.mm, 1.0 * unit.mm):  # holds; slides
        force, held, friction = uncompiled(tangential_force)(
            law, m, overlap, n * (0.0 * unit.m,), n * (step,), n * (rate,)
        )
        assert len(force) == len(held) == n
        assert all(f.check("[force]") for f in force)
        assert all(s.check("[length]") for s in held)
        assert friction.check("[energy]")
    masses = uncompiled(reduced_mass)(1 / m, 0.0 / unit.kg)
    assert masses.check("[mass]")
