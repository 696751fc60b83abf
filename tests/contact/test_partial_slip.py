"""The tangential laws at a contact that is held: Mindlin's stiffness, partial slip, vibration."""

import math

import numpy as np
import pytest
from analytic import mindlin_ratio
from numpy.testing import assert_allclose

from granulab.contact import load_table
from granulab.contact.hertz import hertz_force, mindlin_force
from granulab.contact.mindlin_deresiewicz import (
    N_SPRINGS,
    loading_force,
    partial_slip_force,
    turned_force,
)
from granulab.contact.sphere_law import sphere_law

STEEL = load_table("steel").material("steel")
RADIUS, OVERLAP, MASS = 1.5e-3, 2e-6, 1e-4  # reduced radius [m], [m], reduced mass [kg]
NORMAL = 0.0, 0.0, 1.0
LAW = sphere_law(STEEL, STEEL, friction=0.4, restitution=1.0)
HERTZ = LAW.hertz * math.sqrt(RADIUS)


def held(law=LAW, overlap=OVERLAP):
    """(secant stiffness, dashpot, normal force) of a contact whose overlap rests."""
    return hertz_force(law, HERTZ, MASS, law.damping, overlap, 0.0)[:3]


def exact_forces(path, law=LAW, overlaps=None):
    """Tangential forces [N] of the springs along a path of displacements [m] from nothing."""
    springs = np.zeros((N_SPRINGS, 3))
    overlaps = np.full(len(path), OVERLAP) if overlaps is None else overlaps
    reach = 1.1 * math.sqrt(RADIUS * overlaps.max())
    forces, lost, last, ahead = [], 0.0, 0.0, 0.0
    for displacement, overlap in zip(path, overlaps, strict=True):
        # A history is half the last step ahead; this step brings the rest.
        half = displacement - last - ahead
        stiffness, dashpot, f_n = held(law, overlap)
        force, _, friction, energy = partial_slip_force(
            law, stiffness, dashpot, f_n, NORMAL, overlap, math.sqrt(RADIUS * overlap), springs,
            reach, (half, 0.0, 0.0), (0.0, 0.0, 0.0),
        )  # fmt: skip
        last, ahead = displacement, half
        forces.append(-force[0])
        lost += friction
    return np.array(forces), lost, energy


def curves():
    """(kt [N/m], mu N [N], displacement at which all slides [m])."""
    stiffness, _, f_n = held()
    kt, limit = LAW.tangential * stiffness, LAW.mu * f_n
    return kt, limit, 1.5 * limit / kt


def test_tangential_over_normal_stiffness():
    """Mindlin: kt/(d Fn/d overlap) = 2 (1 - nu)/(2 - nu), from forces of both laws. Tolerance: the
    differences' second order, (step/overlap)^2; for the springs their slip at the rim."""
    step = 1e-4 * OVERLAP
    slope = (held(overlap=OVERLAP + step)[2] - held(overlap=OVERLAP - step)[2]) / (2 * step)
    stiffness, dashpot, f_n = held()
    nothing = (0.0, 0.0, 0.0)
    simple = mindlin_force(LAW, stiffness, dashpot, f_n, (step, 0.0, 0.0), nothing)[0][0]
    assert -simple / step / slope == pytest.approx(mindlin_ratio(0.3), rel=1e-7)
    (exact,), _, _ = exact_forces(np.array([step]))
    assert exact / step / slope == pytest.approx(mindlin_ratio(0.3), rel=1e-3)


def test_loading_curve_is_equation_5_13_summed():
    """Thesis, eq. 5.13 with its erratum, in small steps. Tolerance: first order in the step."""
    kt, limit, slides = curves()
    s = np.linspace(0, slides, 20001)
    bracket = kt * np.sqrt(1 - 2 * kt * s[1:] / (3 * limit))
    summed = np.cumsum(bracket * np.diff(s))
    assert_allclose(loading_force(kt, limit, s[1:]), summed, atol=1e-4 * limit)


def test_loading_unloading_reloading_at_constant_normal_force():
    """Mindlin and Deresiewicz 1953: the springs follow the closed curves. Tolerance: the sum over
    springs, 1/N^2, and the slip of a spring within a step."""
    kt, limit, slides = curves()
    top, bottom = 0.8 * slides, -0.3 * slides
    out, back, again = (np.linspace(a, b, 200) for a, b in ((0, top), (top, bottom), (bottom, top)))
    forces, _, _ = exact_forces(np.concatenate([out, back, again]))
    loading = loading_force(kt, limit, out)
    unloading = turned_force(kt, limit, back, top, loading[-1])
    reloading = turned_force(kt, limit, again, bottom, unloading[-1])
    expected = np.concatenate([loading, unloading, reloading])
    assert_allclose(forces, expected, atol=1e-4 * limit)
    assert reloading[-1] == pytest.approx(loading[-1], rel=1e-12)  # a closed loop


def test_loop_loses_its_area():
    """What friction takes in a closed loop is the area between the closed curves; what the springs
    hold is what is left of the work."""
    top = 0.8 * curves()[2]
    path = np.concatenate([np.linspace(0, top, 400), np.linspace(top, 0, 400)])
    forces, lost, energy = exact_forces(path)
    work = np.sum(0.5 * (forces[1:] + forces[:-1]) * np.diff(path))
    assert work == pytest.approx(lost + energy, rel=1e-3)


def test_normal_force_that_grows_with_the_tangential_one():
    """Mindlin and Deresiewicz 1953: where dT < mu dN all along, nothing slips: the force is
    integral of 8 G a ds, and no energy is lost. Here s goes with the overlap, so that
    T = (2/3) kt s."""
    overlaps = np.linspace(0, OVERLAP, 2001)[1:]
    path = 0.3 * overlaps  # mu d Fn/ds = mu 2 E a 1/0.3 > 8 G a
    forces, lost, energy = exact_forces(path, overlaps=overlaps)
    kt, _, _ = curves()
    assert forces[-1] == pytest.approx(2 / 3 * kt * path[-1], rel=2e-3)
    assert lost < 1e-3 * energy


@pytest.mark.parametrize("stored_force", [False, True])
def test_tangential_vibration_decays_as_its_dashpot_says(stored_force):
    """At a constant overlap eqs 5.24 and 5.33 make a linear oscillator of damping ratio
    sqrt(10/3) b/2: free vibration of the reduced mass loses so much in a period. Tolerance: second
    order in the step, (omega dt)^2."""
    law = sphere_law(STEEL, STEEL, friction=1e6, restitution=0.7)
    law = law._replace(stored_force=stored_force)
    stiffness, dashpot, f_n = held(law)
    kt = law.tangential * stiffness
    omega = math.sqrt(kt / MASS)
    ratio = 0.5 * math.sqrt(10 / 3) * law.damping
    dt = 2 * math.pi / (omega * math.sqrt(1 - ratio**2)) / 400
    v, dv, ahead = 1.0, 0.0, 0.0
    for _ in range(400):
        u = v + 0.5 * dv
        half = 0.5 * dt * u * (kt if stored_force else 1.0)
        trial = (ahead + half, 0.0, 0.0)
        force, kept, _, _ = mindlin_force(law, stiffness, dashpot, f_n, trial, (u, 0.0, 0.0))
        ahead = kept[0] + half
        dv = dt * force[0] / MASS
        v += dv
    expected = math.exp(-2 * math.pi * ratio / math.sqrt(1 - ratio**2))
    assert v - 0.5 * dv == pytest.approx(expected, rel=2 * (omega * dt) ** 2 + omega * dt)


def test_dashpot_stays_within_coulomb():
    """Springs and dashpot together never exceed mu Fn."""
    law = sphere_law(STEEL, STEEL, friction=0.05, restitution=0.3)
    stiffness, dashpot, f_n = held(law)
    springs = np.zeros((N_SPRINGS, 3))
    for step in range(50):
        force, power, _, _ = partial_slip_force(
            law, stiffness, dashpot, f_n, NORMAL, OVERLAP, math.sqrt(RADIUS * OVERLAP), springs,
            math.sqrt(RADIUS * OVERLAP), (2e-9, 1e-9, 0.0), (1.0, 0.5 * (-1) ** step, 0.0),
        )  # fmt: skip
        assert math.hypot(*force) <= law.mu * f_n * (1 + 1e-12)
        assert power >= 0.0
