"""What must not change: momentum, the frame of reference, and the sum of all energies."""

import math

import numpy as np
import pytest
from analytic import angular_frequency, damping_of_restitution
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from scenes import (
    ELASTIC,
    LEVEL,
    SURFACE_DENSITY,
    WOOD,
    block,
    block_on_wall,
    corner_on_face,
    disc,
    inertia,
    launch,
    mass,
    position,
    simulation_of,
    squeezed,
    velocity,
)

from silo2d import state
from silo2d.shape import shape_from_outline

KITE = shape_from_outline(
    "kite", [[0.0, 0.0], [14e-3, -4e-3], [22e-3, 3e-3], [8e-3, 12e-3]], 1e-3, "here"
)
SHAPES = [block(20e-3, 10e-3), KITE]
STEP = 2e-7  # [s]
MODES = ("normal_damping", "tangential_damping", "friction")


def encounter(law, impact_parameter=3e-3, spins=(200.0, -80.0), turn=0.0, drift=(0.0, 0.0)):
    """A block and a kite that meet with speeds of some m/s and spin, in a frame that is turned
    [rad] and drifts [m/s]."""
    cos, sin = math.cos(turn), math.sin(turn)
    turned = np.array([[cos, -sin], [sin, cos]])
    middle = np.array([0.0, LEVEL])
    places = middle + np.array([[-13e-3, 0.0], [13e-3, impact_parameter]]) @ turned.T
    velocities = np.array([[2.0, 0.5], [-1.5, -0.2]]) @ turned.T + drift
    poses = [(*places[0], 0.4 + turn), (*places[1], -0.7 + turn)]
    simulation = simulation_of(SHAPES, poses, law=law, time_step=STEP)
    for grain in (0, 1):
        launch(simulation, grain, *velocities[grain], spins[grain])
    return simulation


def momenta(simulation):
    """Linear momentum [kg m/s] and angular momentum about the scene's middle [kg m2/s], with
    the velocities of the leapfrog, half a step back, for which they are kept exactly."""
    total = np.zeros(3)
    for grain in range(simulation.n_grains):
        x, y, _ = position(simulation, grain) - (0.0, LEVEL, 0.0)
        vx, vy, spin = simulation.rows[grain, [state.VX, state.VY, state.SPIN]]
        m = mass(simulation, grain)
        total += m * vx, m * vy, m * (x * vy - y * vx) + inertia(simulation, grain) * spin
    return total


def total_energy(simulation):
    """All that the books know of [J]."""
    return math.fsum(simulation.energies().values())


@settings(deadline=None, max_examples=25)
@given(
    impact_parameter=st.floats(-12e-3, 12e-3),
    spins=st.tuples(st.floats(-500, 500), st.floats(-500, 500)),
    mu=st.sampled_from([0.0, 0.38, 2.0]),
    pulls=st.booleans(),
)
def test_oblique_encounter_keeps_momentum(impact_parameter, spins, mu, pulls):
    """Forces of a pair are opposite and act at one point, so that the arms add up to the
    distance of the centres: linear and angular momentum stay, with friction and both dashpots.
    Tolerance: 1e-12 of the momentum of one body."""
    law = WOOD._replace(mu=mu, gamma_t=300.0, pulls=pulls)
    simulation = encounter(law, impact_parameter, spins)
    before = momenta(simulation)
    simulation.run(40000)
    p = mass(simulation) * 2.0
    assert_allclose(momenta(simulation), before, rtol=0, atol=1e-12 * p * np.array([1, 1, 10e-3]))


def test_the_encounter_is_one():
    """The scene of this file does collide, at several pairs, turns the bodies and takes energy."""
    simulation = encounter(WOOD)
    before = velocity(simulation, 0).copy()
    simulation.run(40000)
    after = velocity(simulation, 0)
    assert abs(after[0] - before[0]) > 1.0
    assert abs(after[2] - before[2]) > 50.0
    assert all(simulation.energies()[f"{mode}_grain_grain"] > 0 for mode in MODES)


@pytest.mark.parametrize("turn_deg", [30.0, 90.0, 200.0])
def test_turned_frame(turn_deg):
    """No direction is special. Tolerance: rounding of 1e-17 m at 0.1 m, which an overlap of
    1e-6 m and the sharp corners of the encounter magnify."""
    turn = math.radians(turn_deg)
    here, there = encounter(WOOD), encounter(WOOD, turn=turn)
    cos, sin = math.cos(turn), math.sin(turn)
    for simulation in (here, there):
        simulation.run(40000)
    for grain in (0, 1):
        vx, vy, spin = velocity(here, grain)
        expected = cos * vx - sin * vy, sin * vx + cos * vy, spin
        assert_allclose(velocity(there, grain), expected, rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("drift", [(3.0, 0.0), (-4.0, 7.0)])
def test_drifting_frame(drift):
    """Galilei: laws see relative velocities alone. Tolerance: as for the turned frame."""
    here, there = encounter(WOOD), encounter(WOOD, drift=drift)
    for simulation in (here, there):
        simulation.run(40000)
    for grain in (0, 1):
        expected = velocity(here, grain) + (*drift, 0.0)
        assert_allclose(velocity(there, grain), expected, rtol=1e-8, atol=1e-9)


def test_a_turning_pair_does_not_slip():
    """Two discs pressed together by their spin about each other as one rigid body would: the
    slip is measured along the turning tangent, and none arises. Tolerance: slip of one step."""
    r, rate, law = 5e-3, 50.0, WOOD._replace(mu=1e3, gamma_t=0.0, gamma_n=0.0)
    # Pulled apart by m rate^2 r, they are held together by a third body's place: two walls are
    # none here, so the discs fly apart and must do so without torque.
    simulation = simulation_of(
        [disc(r), disc(r)],
        [(-r + 1e-6, LEVEL, 0.0), (r - 1e-6, LEVEL, 0.0)],
        law=law,
        time_step=1e-8,
    )
    launch(simulation, 0, vy=-rate * (r - 1e-6), spin=rate)
    launch(simulation, 1, vy=rate * (r - 1e-6), spin=rate)
    simulation.run(10000)
    assert_allclose([velocity(simulation, k)[2] for k in (0, 1)], rate, rtol=1e-6)
