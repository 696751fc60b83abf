"""What must not change: momentum, the frame of reference, and the sum of all energies."""

import math

import numpy as np
import pytest
from analytic import angular_frequency, damping_of_restitution
from fuzzing import examples
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
    inertia,
    launch,
    mass,
    position,
    simulation_of,
    velocity,
    wall,
)

from silo2d.case.shape import shape_from_outline
from silo2d.engine import state

KITE = shape_from_outline(
    "kite", [[0.0, 0.0], [14e-3, -4e-3], [22e-3, 3e-3], [8e-3, 12e-3]], 1e-3, "here"
)
SHAPES = [block(20e-3, 10e-3), KITE]
STEP = 2e-7  # [s]
G = 9.81
MODES = ("normal_damping", "tangential_damping", "friction")


def encounter(
    law, impact_parameter=3e-3, spins=(200.0, -80.0), turn=0.0, drift=(0.0, 0.0), step=STEP
):
    """A block and a kite that meet with speeds of some m/s and rotation, in a frame that is rotated
    [rad] and drifts [m/s]."""
    cos, sin = math.cos(turn), math.sin(turn)
    rotation = np.array([[cos, -sin], [sin, cos]])
    middle = np.array([0.0, LEVEL])
    positions = middle + np.array([[-13e-3, 0.0], [13e-3, impact_parameter]]) @ rotation.T
    velocities = np.array([[2.0, 0.5], [-1.5, -0.2]]) @ rotation.T + drift
    poses = [(*positions[0], 0.4 + turn), (*positions[1], -0.7 + turn)]
    simulation = simulation_of(SHAPES, poses, law=law, time_step=step)
    for particle in (0, 1):
        launch(simulation, particle, *velocities[particle], spins[particle])
    return simulation


def momenta(simulation):
    """Linear momentum [kg m/s] and angular momentum about the scene's middle [kg m2/s], with
    the velocities of the leapfrog, half a step back, for which they are kept exactly."""
    total = np.zeros(3)
    for particle in range(simulation.n_particles):
        x, y, _ = position(simulation, particle) - (0.0, LEVEL, 0.0)
        vx, vy, spin = simulation.rows[particle, [state.VX, state.VY, state.OMEGA]]
        m = mass(simulation, particle)
        total += m * vx, m * vy, m * (x * vy - y * vx) + inertia(simulation, particle) * spin
    return total


def separate(simulation):
    """Run on until nothing touches: amid a contact the energy balance lags by half a step."""
    while len(simulation.touching()):
        simulation.run(20)
    simulation.run(1)


def total_energy(simulation):
    """All that is accounted [J]."""
    return math.fsum(simulation.energies().values())


@settings(deadline=None, max_examples=examples(25))
@given(
    impact_parameter=st.floats(-12e-3, 12e-3),
    spins=st.tuples(st.floats(-500, 500), st.floats(-500, 500)),
    mu=st.sampled_from([0.0, 0.38, 2.0]),
    pulls=st.booleans(),
)
def test_oblique_encounter_keeps_momentum(impact_parameter, spins, mu, pulls):
    """Forces of a pair are opposite and act at one point, so that the arms add up to the
    distance of the centres: linear and angular momentum stay, with friction and both dashpots.
    Tolerance: 1e-12 of one body's momentum, and of that at a lever of 0.1 m, the height of the
    scene: 8000 roundings of positions there, 1e-17 m each, need not average out."""
    law = WOOD._replace(mu=mu, gamma_t=300.0, pulls=pulls)
    simulation = encounter(law, impact_parameter, spins, step=5e-7)
    before = momenta(simulation)
    simulation.run(8000)
    units = mass(simulation) * 2.0 * np.array([1.0, 1.0, LEVEL])
    assert_allclose(momenta(simulation) / units, before / units, rtol=0, atol=1e-12)


def test_the_encounter_is_one():
    """The scene of this file does collide, rotates the particles and takes energy in every way."""
    simulation = encounter(WOOD)
    before = velocity(simulation, 0).copy()
    simulation.run(20000)
    after = velocity(simulation, 0)
    assert abs(after[0] - before[0]) > 0.5
    assert abs(after[2] - before[2]) > 10.0
    assert all(simulation.energies()[f"{mode}_grain_grain"] > 0 for mode in MODES)


@pytest.mark.parametrize("turn_deg", [30.0, 90.0, 200.0])
def test_rotated_frame(turn_deg):
    """No direction is special. Tolerance: rounding of 1e-17 m at 0.1 m, which an overlap of
    1e-6 m and the sharp corners of the encounter magnify."""
    turn = math.radians(turn_deg)
    here, there = encounter(WOOD), encounter(WOOD, turn=turn)
    cos, sin = math.cos(turn), math.sin(turn)
    for simulation in (here, there):
        simulation.run(20000)
    for particle in (0, 1):
        vx, vy, spin = velocity(here, particle)
        expected = cos * vx - sin * vy, sin * vx + cos * vy, spin
        assert_allclose(velocity(there, particle), expected, rtol=1e-8, atol=1e-9)


@pytest.mark.parametrize("drift", [(3.0, 0.0), (-4.0, 7.0)])
def test_drifting_frame(drift):
    """Galilei: laws see relative velocities alone. Tolerance: as for the rotated frame."""
    here, there = encounter(WOOD), encounter(WOOD, drift=drift)
    for simulation in (here, there):
        simulation.run(20000)
    for particle in (0, 1):
        expected = velocity(here, particle) + np.array([*drift, 0.0])
        assert_allclose(velocity(there, particle), expected, rtol=1e-8, atol=1e-9)


def test_normal_damping_alone():
    """It takes (1 - e^2) m v^2/2 from a head-on impact, with the reduced mass; nothing else is
    accounted. Tolerance: the dashpot's jumps, gamma dt, and the leapfrog's (omega0 dt)^2."""
    e, v = 0.6, 1.0
    m = 1 / (1 / mass(corner_on_face(WOOD, 1.0)) + 1 / mass(corner_on_face(WOOD, 1.0), 1))
    omega0 = angular_frequency(WOOD.kn, m)
    gamma = damping_of_restitution(omega0, e)
    simulation = corner_on_face(ELASTIC._replace(gamma_n=gamma), STEP)
    launch(simulation, vy=-v)
    simulation.run(4000)
    assert_booked(
        simulation,
        "normal_damping_grain_grain",
        (1 - e**2) * m * v**2 / 2,
        rel=gamma * STEP + (omega0 * STEP) ** 2,
    )


def test_tangential_damping_alone():
    """On a floor without friction both pairs of a block brake it, v = v0 exp(-2 gamma_t t).
    Tolerance: it rocks under the brakes, by some 1e-5 of its way."""
    v, gamma_t = 0.3, 4.0  # slow enough not to tip the block over
    simulation = resting_block(ELASTIC._replace(gamma_t=gamma_t))
    launch(simulation, vx=v)
    simulation.run(20000)
    lost = 0.5 * mass(simulation) * v**2 * -math.expm1(-4 * gamma_t * simulation.time)
    assert_booked(simulation, "tangential_damping_grain_wall", lost, rel=1e-4)


def test_friction_alone():
    """A block that slides a way s on a floor: m g mu s. Tolerance: until the springs are wound up
    the block slides some hundred times less far than s."""
    mu = 0.4
    simulation = resting_block(ELASTIC._replace(mu=mu))
    launch(simulation, vx=0.3)
    simulation.run(20000)
    way = position(simulation)[0]
    assert_booked(simulation, "friction_grain_wall", mu * mass(simulation) * G * way, rel=1e-4)


def resting_block(law):
    """A block that lies on a floor under its weight."""
    shape = block(20e-3, 10e-3)
    overlap = SURFACE_DENSITY * shape.area * G / (2 * law.kn)
    return block_on_wall(shape, law, 1e-6, overlap=overlap, gravity=G)


def assert_booked(simulation, entry, expected, rel):
    """One entry of the dissipation is as expected, all others are zero."""
    energies = simulation.energies()
    assert energies[entry] == pytest.approx(expected, rel=rel)
    for mode in MODES:
        for pair in ("grain_grain", "grain_wall"):
            if f"{mode}_{pair}" != entry:
                assert energies[f"{mode}_{pair}"] == 0.0


LAWS = {
    "springs": ELASTIC,
    "normal damping": ELASTIC._replace(gamma_n=6085.0),
    "tangential damping": ELASTIC._replace(gamma_t=3000.0),
    "friction": ELASTIC._replace(mu=0.38),
    "all": WOOD._replace(gamma_t=300.0),
    "no tension": WOOD._replace(gamma_t=300.0, pulls=False),
}


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_energy_balance_closes_with_the_square_of_the_step(law):
    """What is in motion, in springs and dissipated adds up; what is missing comes from the steps
    that contacts begin and end in, so it scatters: the root mean square over many encounters.
    A quarter of the step leaves a sixteenth; tolerance: the scatter of such a mean."""
    missing = []
    for step in (8e-7, 2e-7):
        errors = []
        for impact_parameter in np.linspace(-9e-3, 9e-3, 40):
            simulation = encounter(law, impact_parameter, step=step)
            before = total_energy(simulation)
            simulation.run(round(4e-3 / step))
            separate(simulation)
            errors.append((total_energy(simulation) - before) / before)
        missing.append(math.sqrt(np.mean(np.square(errors))))
    assert missing[0] < 1e-3
    assert 12 < missing[0] / missing[1] < 22


def test_a_discharged_particle_takes_its_energy_along():
    """A particle that falls out is out at sqrt(2 h/g), and what it had is carried out."""
    h, step = 0.05, 1e-5
    simulation = simulation_of([KITE], [(0.0, h, 0.3)], time_step=step, gravity=G)
    launch(simulation, vy=0.5 * G * step)  # half a step back
    simulation.run(1)
    before = total_energy(simulation)
    while len(simulation.live):
        simulation.run(100)
        assert total_energy(simulation) == pytest.approx(before, rel=1e-12)
    assert simulation.n_out == 1
    assert simulation.energies()["carried_out"] == pytest.approx(before, rel=1e-12)
    out = simulation.world.bodies.out_time[0]
    assert out == pytest.approx(math.sqrt(2 * h / G), abs=step**2 * G)


@settings(deadline=None, max_examples=examples(20))
@given(
    angle=st.floats(0, 2 * math.pi),
    vx=st.floats(-2, 2),
    spin=st.floats(-300, 300),
    mu=st.sampled_from([0.05, 0.38, 1.0, 5.0]),
    kt_over_kn=st.sampled_from([0.065, 2 / 7, 1.0]),
)
def test_a_thrown_block_gains_no_energy(angle, vx, spin, mu, kt_over_kn):
    """However a block hits a floor, with whatever friction: from flight to flight kinetic
    energy never rises. Tolerance: the leapfrog's (omega dt)^2, where a face of four pairs rocks."""
    law = ELASTIC._replace(mu=mu, kt=kt_over_kn * ELASTIC.kn)
    simulation = simulation_of(
        [KITE], [(0.0, LEVEL + 0.016, angle)], walls=[wall()], law=law, time_step=STEP
    )
    launch(simulation, vx=vx, vy=-1.0, spin=spin)
    now = simulation.energies()["kinetic"]
    allowed = 16 * law.kn / mass(simulation) * STEP**2 * now
    for _ in range(10):
        simulation.run(6000)
        separate(simulation)
        before, now = now, simulation.energies()["kinetic"]
        assert now <= before + allowed
