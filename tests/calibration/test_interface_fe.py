"""Two blocks in contact against closed forms: patch test, shear, Hertz, Westergaard, Cattaneo."""

import numpy as np
import pytest
from line_contacts import (
    contact_modulus,
    hertz_half_width,
    hertz_pressure,
    stick_half_width,
    westergaard_share,
)

from calibration.stiffness_fe.blocks import Block, Elastic
from calibration.stiffness_fe.protocol import Case, Load, press_and_shear
from calibration.stiffness_fe.stack import Stack

WOOD = Elastic(242e6, 0.2)
ROUNDING = 1e-9  # a solve with some thousand unknowns loses five or six digits of sixteen


def flat(case: Case, load: Load):
    zero = np.zeros(case.columns + 1)
    return press_and_shear(case, load, zero, zero)


def moved(stack: Stack, state, by, steps: int):
    for _ in range(steps):
        state = stack.move(state, np.array(by) / steps)
    return state


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_patch_of_uniform_compression_is_exact(friction):
    """Uniaxial strain: sigma = (lambda + 2 mu) d/(2 H) everywhere, whatever the mesh."""
    outcome = flat(Case(WOOD, 10e-3, 7e-3, 1.0, columns=24, steps=2), Load(friction, 1e-4, 1e-9))
    first, shear = WOOD.lame()
    pressure = outcome.state.contact[0, :-1] / (10e-3 / 24)
    exact = (first + 2 * shear) * 1e-4 / 14e-3
    np.testing.assert_allclose(pressure, exact, rtol=ROUNDING)
    block = outcome.stack.lower
    sigma = block.stress(block.displacements(outcome.state.lower))
    np.testing.assert_allclose(sigma[1], -exact, rtol=1e-7)  # the fit is a solve of its own
    assert abs(outcome.unaccounted) < ROUNDING
    assert outcome.imbalance < ROUNDING


@pytest.mark.parametrize(
    ("plane", "ratio"), [("strain", (1 - 2 * 0.2) / (2 * (1 - 0.2))), ("stress", (1 - 0.2) / 2)]
)
def test_a_long_flat_contact_that_sticks_has_the_ratio_of_the_bulk(plane, ratio):
    """kt/kn = mu/(lambda + 2 mu): shear and uniaxial strain of one homogeneous block."""
    case = Case(Elastic(242e6, 0.2, plane), 10e-3, 10e-3, 1.0, columns=16, steps=3)
    outcome = flat(case, Load(0.37, 6.8e-5, 2.5e-5))
    assert outcome.ratio == pytest.approx(ratio, rel=ROUNDING)
    assert outcome.onset == pytest.approx(ratio, rel=1e-7)  # a difference of two solves
    assert outcome.sliding == 0


def test_slender_blocks_that_stick_bend_as_a_beam():
    """Timoshenko, both ends clamped: 1/kt = L^3/(12 E I) + L/(k G A), 1/kn = L/(E A).

    Plane stress, k = 10 (1 + nu)/(12 + 11 nu) (Cowper 1966), L = 10 widths. The ends hold back
    lateral strain over about a width: 1 % of the length at most. A bilinear layer of thickness h
    is stiffer in bending by (1 - nu)/2 (h/W)^2: 1.1 % for the thickest, W/6.
    """
    width, length, nu = 2e-3, 20e-3, 0.2
    case = Case(Elastic(242e6, nu, "stress"), width, length / 2, 1.0, "free", 96, 2)
    outcome = flat(case, Load(1.0, 1e-3, 1e-5))
    inertia, shear = width**3 / 12, 242e6 / (2 * (1 + nu))
    cowper = 10 * (1 + nu) / (12 + 11 * nu)
    yields = length**3 / (12 * 242e6 * inertia) + length / (cowper * shear * width)
    ratio = length / (242e6 * width) / yields
    assert outcome.ratio == pytest.approx(ratio, rel=0.02)


def test_a_flat_contact_slides_at_coulombs_limit_and_stays_uniform():
    """T = mu N, also where the surfaces' points no longer face each other."""
    case = Case(WOOD, 10e-3, 10e-3, 1.0, columns=16, steps=10)
    outcome = flat(case, Load(0.1, 1e-4, 1e-3))  # 1.6 columns along
    drag, press = outcome.state.force
    assert drag == pytest.approx(0.1 * press, rel=ROUNDING)
    assert outcome.sliding == 1
    pressure = outcome.state.contact[0]
    np.testing.assert_allclose(pressure, pressure.mean(), rtol=1e-7)


def test_work_is_stored_or_lost_in_friction():
    """Where nothing opens or closes the energies balance exactly, and the loss is mu N x slip.

    Slip is the travel that elastic shear does not take. In the step in which sliding begins the
    mean friction is half of the limit at least: half a step too little at most.
    """
    case = Case(WOOD, 10e-3, 10e-3, 1.0, columns=16, steps=50)
    outcome = flat(case, Load(0.1, 1e-4, 1e-3))
    press = outcome.state.force[1]
    slip = 1e-3 - 0.1 * press / (0.375 * outcome.kn)
    assert abs(outcome.unaccounted) < ROUNDING
    lost = outcome.state.dissipated
    assert 0.1 * press * (slip - 1e-3 / 50 / 2) < lost < 0.1 * press * slip * (1 + ROUNDING)


def test_a_wave_of_pressure_yields_second_order_in_the_columns():
    """Half-plane: u = (1 - nu^2) lambda/(pi E) p cos(2 pi x/lambda) (Johnson sec. 13.2).

    Two wavelengths of height stand for the half-plane: exp(-4 pi) = 3e-6 is not seen. The layers
    grow by 15 columns a width: what that adds to the order's 2 fades as 1/columns.
    """
    nu, modulus = 0.3, 1.0
    errors = []
    for columns in (64, 128):
        x = np.linspace(0, 1, columns + 1)
        block = Block(x, 0 * x, -2.0, Elastic(modulus, nu), "periodic")
        pressure = np.cos(2 * np.pi * x)
        forces = np.zeros((2, columns + 1))
        forces[1, :-1] = -pressure[:-1] / columns
        u = block.by_point(block.displacements(forces))[1]
        top = u[np.abs(block.basis.mesh.p[1]) < 1e-12]
        found = 2 * np.mean(top[:-1] * -np.cos(2 * np.pi * x[:-1]))
        errors.append(abs(found / ((1 - nu**2) / (np.pi * modulus)) - 1))
    assert errors[1] < 0.001
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.25)


@pytest.fixture(scope="module")
def cylinder():
    """A cylinder of 2 m radius pressed on a block 1 m wide: a is 0.084 m, 6.7 columns."""
    material, columns = Elastic(1e9, 0.3), 80
    x = np.linspace(-0.5, 0.5, columns + 1)
    upper, lower = Block(x, x**2 / 4, 1.0, material), Block(x, 0 * x, -1.0, material)
    stack = Stack(upper, lower, 0.3)
    return stack, moved(stack, stack.at_rest(), [0, -0.006], 10), x, contact_modulus(material)


def test_a_cylinder_is_pressed_as_hertz_says(cylinder):
    """The pressure's second moment is P a^2/4. Half-planes: (a/W)^2 = 0.7 %; columns h/a = 1/6.7.

    The lower half's mean pressure within a point's column differs from the point's by (h/a)^2/8;
    at the rim it cannot follow the root: 1 % of the peak in the mean of squares.
    """
    _, state, x, modulus = cylinder
    load, h = state.force[1], x[1] - x[0]
    a = hertz_half_width(load, 2.0, modulus)
    assert 2 * np.sqrt((state.contact[0] * x**2).sum() / load) == pytest.approx(a, rel=0.01)
    off = state.contact[0] / h - hertz_pressure(x, load, a)
    assert np.sqrt(np.mean(off**2)) < 0.01 * hertz_pressure(np.zeros(1), load, a)[0]


def test_a_sheared_cylinder_sticks_inside_as_cattaneo_and_mindlin_say(cylinder):
    """c = a sqrt(1 - Q/(mu P)), counted in points: within one of them on each side."""
    stack, state, x, modulus = cylinder
    h = x[1] - x[0]
    shares = []
    for _ in range(6):
        state = moved(stack, state, [0.0006, 0], 3)
        drag, load = state.force
        a = hertz_half_width(load, 2.0, modulus)
        sticks = h * np.count_nonzero(state.doing == 1) / 2
        assert sticks == pytest.approx(stick_half_width(a, drag, load, 0.3), abs=h)
        shares.append(drag / (0.3 * load))
    assert shares[-1] > 0.5  # that half of the limit was passed
    assert np.abs(state.contact[1]).max() <= 0.3 * state.contact[0].max() * (1 + ROUNDING)


def test_a_wavy_surface_touches_as_westergaard_says():
    """Area against load from first touch to nearly full contact, within a column on each side.

    Blocks one wavelength high: the interface feels the platens by 2 pi exp(-2 pi) = 1.2 %.
    """
    material, columns, amplitude = Elastic(1e9, 0.3), 64, 0.004
    x = np.linspace(0, 1, columns + 1)
    wave = amplitude * (1 - np.cos(2 * np.pi * x))
    stack = Stack(
        Block(x, wave, 1.0, material, "periodic"), Block(x, 0 * x, -1.0, material, "periodic"), 0.0
    )
    state, touched = stack.at_rest(), []
    for _ in range(6):
        state = moved(stack, state, [0, -0.0025], 2)
        share = np.count_nonzero(state.contact[0, :-1]) / columns
        exact = westergaard_share(state.force[1], amplitude, 1.0, contact_modulus(material))
        assert share == pytest.approx(exact, abs=2 / columns + 0.012)
        touched.append(exact)
    assert touched[0] < 0.5
    assert touched[-1] > 0.8


def test_steps_and_mesh_do_not_decide_the_ratio_of_a_rough_contact():
    """A sheared wave that sticks here and slides there: twice of both moves it by 2 % at most."""
    ratios = []
    for columns, steps in ((32, 8), (64, 16)):
        case = Case(WOOD, 2e-3, 4e-3, 1.0, "periodic", columns, steps)
        lower = 20e-6 * np.cos(2 * np.pi * case.points() / 1e-3)
        outcome = press_and_shear(case, Load(0.2, 4e-5, 1e-5), lower, 0 * lower)
        ratios.append(outcome.ratio)
        assert 0 < outcome.sliding < 1
    assert ratios[0] == pytest.approx(ratios[1], rel=0.02)
