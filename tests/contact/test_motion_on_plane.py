"""Bodies on a plane and on an incline: sliding, rolling, resting, toppling, bouncing."""

import math

import numpy as np
import pytest
from analytic import (
    angular_frequency,
    block_creeping_down,
    block_sliding_down,
    bounce_height,
    contact_time,
    damping_of_restitution,
    disc_rolling_down,
    disc_sliding_to_rolling,
)
from scenes import (
    DISC_CONTACTS,
    HARD_LAW,
    HARD_STEP,
    LEVEL,
    SPHERORADIUS,
    SURFACE_DENSITY,
    WOOD,
    G,
    block,
    block_on_wall,
    disc,
    disc_on_wall,
    launch,
    mass,
    position,
    velocity,
)

RADIUS = 5e-3  # of the disc [m]
FLAT = block(20e-3, 10e-3)


def resting(shape, contacts, law, angle=0.0):
    """How deep [m] a body sinks in under its weight."""
    return SURFACE_DENSITY * shape.area * G * math.cos(angle) / (contacts * law.kn)


def on_incline(shape, law, angle):
    """A body at rest on an incline, its contacts carrying the weight."""
    if shape.spheroradius > SPHERORADIUS:
        overlap = resting(shape, DISC_CONTACTS, law, angle)
        return disc_on_wall(RADIUS, law, HARD_STEP, angle=angle, overlap=overlap, gravity=G)
    overlap = resting(shape, 2, law, angle)
    return block_on_wall(shape, law, HARD_STEP, angle=angle, overlap=overlap, gravity=G)


def downhill(simulation, angle):
    """Velocity [m/s] down the incline."""
    vx, vy, _ = velocity(simulation)
    return -(vx * math.cos(angle) + vy * math.sin(angle))


def test_sliding_disc_begins_to_roll():
    """u0 - mu g t and spin 2 mu g t/r until u0/(3 mu g), then 2 u0/3 without slip. Tolerance:
    friction takes one swing of the tangential springs to build up and one to die, each worth
    mu g/omega_t; the dashpots are off."""
    u0, mu = 0.3, HARD_LAW.mu
    simulation = on_incline(disc(RADIUS), HARD_LAW, 0.0)
    launch(simulation, vx=u0)
    time, rolling = disc_sliding_to_rolling(u0, mu, G)
    swing = mu * G / angular_frequency(HARD_LAW.kt, mass(simulation) / 3, DISC_CONTACTS)
    for part in (0.25, 0.5, 0.95):
        simulation.run(round(part * time / HARD_STEP) - simulation.steps)
        u, _, spin = velocity(simulation)
        assert u == pytest.approx(u0 - mu * G * simulation.time, abs=2 * swing)
        assert -spin * RADIUS == pytest.approx(2 * mu * G * simulation.time, abs=4 * swing)
    for part in (1.05, 2.0):
        simulation.run(round(part * time / HARD_STEP) - simulation.steps)
        u, _, spin = velocity(simulation)
        assert u == pytest.approx(rolling, abs=2 * swing)
        assert -spin * RADIUS == pytest.approx(rolling, abs=4 * swing)


@pytest.mark.parametrize("angle_deg", [5, 20, 40])
def test_disc_rolls_down(angle_deg):
    """(2/3) g sin where mu > tan/3. Tolerance: the springs that take up a load swing once, with
    g sin/omega_t; the rolling disc presses on the wall only by its weight."""
    angle = math.radians(angle_deg)
    law = HARD_LAW._replace(mu=1.1 * math.tan(angle) / 3 + 0.1)
    simulation = on_incline(disc(RADIUS), law, angle)
    simulation.run(round(0.1 / HARD_STEP))
    expected = disc_rolling_down(angle, G) * simulation.time
    swing = G * math.sin(angle) / angular_frequency(law.kt, mass(simulation) / 3, DISC_CONTACTS)
    assert downhill(simulation, angle) == pytest.approx(expected, abs=2 * swing)
    assert velocity(simulation)[2] * RADIUS == pytest.approx(expected, abs=4 * swing)


@pytest.mark.parametrize("angle_deg", [40, 60])
def test_disc_slides_down_where_friction_is_too_small_to_roll(angle_deg):
    """For mu < tan/3: g (sin - mu cos) and spin 2 mu g cos t/r. Tolerance: as above."""
    angle = math.radians(angle_deg)
    law = HARD_LAW._replace(mu=0.5 * math.tan(angle) / 3)
    simulation = on_incline(disc(RADIUS), law, angle)
    simulation.run(round(0.1 / HARD_STEP))
    expected = block_sliding_down(angle, law.mu, G) * simulation.time
    turning = 2 * law.mu * G * math.cos(angle) * simulation.time
    swing = G / angular_frequency(law.kt, mass(simulation) / 3, DISC_CONTACTS)
    assert downhill(simulation, angle) == pytest.approx(expected, abs=2 * swing)
    assert velocity(simulation)[2] * RADIUS == pytest.approx(turning, abs=4 * swing)


@pytest.mark.parametrize("angle_deg", [10, 22, 35])
def test_block_rests_on_an_incline(angle_deg):
    """tan <= mu: the block gives way by the stretch of its springs and stays. The springs take
    up the load in a swing that friction and the dashpots damp, and the block rocks as well.
    Tolerance: ten stretches, 1e-5 of the way of a block that slides freely."""
    angle = math.radians(angle_deg)
    law = HARD_LAW._replace(mu=1.02 * math.tan(angle), gamma_t=3000.0)
    simulation = on_incline(FLAT, law, angle)
    start = position(simulation).copy()
    simulation.run(round(0.05 / HARD_STEP))
    stretch = mass(simulation) * G * math.sin(angle) / (2 * law.kt)
    moved = position(simulation) - start
    assert math.hypot(*moved[:2]) < 10 * stretch
    assert abs(downhill(simulation, angle)) < 1e-9


@pytest.mark.parametrize("angle_deg", [10, 22, 35])
@pytest.mark.parametrize("mu_over_tan", [0.0, 0.5, 0.98])
def test_block_slides_down(angle_deg, mu_over_tan):
    """tan > mu: g (sin - mu cos). Tolerance: friction takes a swing of the springs to build up,
    worth g sin/omega_t."""
    angle = math.radians(angle_deg)
    law = HARD_LAW._replace(mu=mu_over_tan * math.tan(angle))
    simulation = on_incline(FLAT, law, angle)
    simulation.run(round(0.1 / HARD_STEP))
    expected = block_sliding_down(angle, law.mu, G) * simulation.time
    swing = G * math.sin(angle) / angular_frequency(law.kt, mass(simulation), 2)
    assert downhill(simulation, angle) == pytest.approx(expected, abs=2 * swing)


@pytest.mark.parametrize("gamma_t", [3.0, 30.0])
def test_block_reaches_a_terminal_velocity(gamma_t):
    """v0 (1 - exp(-n gamma_t t)), v0 = g (sin - mu cos)/(n gamma_t), n = 2: each of the two
    pairs has the dashpot. (The wood-silo paper's eq. 3.11 has n = 1.) Tolerance: as above."""
    angle = math.radians(25)
    law = HARD_LAW._replace(gamma_t=gamma_t)
    simulation = on_incline(FLAT, law, angle)
    swing = G * math.sin(angle) / angular_frequency(law.kt, mass(simulation), 2)
    for time in (0.25 / gamma_t, 1.0 / gamma_t):
        simulation.run(round(time / HARD_STEP) - simulation.steps)
        v = block_creeping_down(angle, law.mu, G, gamma_t, 2, simulation.time)
        assert downhill(simulation, angle) == pytest.approx(v, abs=2 * swing)


@pytest.mark.parametrize(("over_limit", "topples"), [(0.95, False), (1.05, True)])
def test_tall_block_topples(over_limit, topples):
    """It topples for tan > b/h: b half the distance of the lowest core corners (a rounded corner
    touches below its middle), h the height of the centroid, friction larger than b/h."""
    shape = block(10e-3, 30e-3)
    b, h = shape.core[:, 0].max(), 15e-3
    angle = math.atan(over_limit * b / h)
    simulation = on_incline(shape, HARD_LAW._replace(mu=1.0, gamma_t=300.0), angle)
    start = position(simulation)[2]
    simulation.run(round(0.25 / HARD_STEP))
    turned = position(simulation)[2] - start
    if topples:
        assert turned > 0.3  # downhill is to the left, so anticlockwise
    else:  # the springs give way by m g sin h/(2 kn b^2), and swing
        rocked = mass(simulation) * G * math.sin(angle) * h / (2 * HARD_LAW.kn * b**2)
        assert abs(turned) < 3 * rocked


def test_free_fall():
    """y = h - g t^2/2, exact for the leapfrog started half a step back. Tolerance: rounding of
    the sum over the steps."""
    h, time = 0.08, 0.1
    simulation = disc_on_wall(RADIUS, HARD_LAW, 1e-5, overlap=-h, gravity=G)
    launch(simulation, vy=0.5 * G * 1e-5)
    start = position(simulation)[1]
    simulation.run(round(time / 1e-5))
    assert position(simulation)[1] == pytest.approx(start - G * time**2 / 2, abs=1e-13)
    simulation.run(1)
    assert velocity(simulation)[1] == pytest.approx(-G * (time + 1e-5), rel=1e-12)


def bounces(k, e, n_bounces, h0=0.5, r=0.1):
    """Heights [m] of the centre after each bounce of MFiX DEM02's ball on a spring k [N/m]."""
    m = 2600 * 4 / 3 * math.pi * r**3
    omega0 = angular_frequency(k, m)
    gamma = damping_of_restitution(omega0, e)
    law = WOOD._replace(kn=k / DISC_CONTACTS, gamma_n=gamma / DISC_CONTACTS)
    step = contact_time(omega0, gamma) / 2500  # a dashpot's jumps are gamma dt
    simulation = disc_on_wall(
        r, law, step, overlap=r - h0, gravity=G, surface_density=m / (math.pi * r**2)
    )
    heights = []
    while len(heights) < n_bounces:
        while velocity(simulation)[1] <= 0:
            simulation.run(500)
        while velocity(simulation)[1] > 0:
            simulation.run(500)
        _, y, _ = position(simulation)
        heights.append(y - LEVEL + velocity(simulation)[1] ** 2 / (2 * G))
    return np.array(heights)


@pytest.mark.parametrize("e", [0.9, 0.7])
def test_bouncing_disc_tends_to_the_rigid_one(e):
    """MFiX DEM02: a ball of 0.2 m and 2600 kg/m3 from 0.5 m; h_k -> (h0 - r) e^(2k) + r as the
    spring grows, here 0.5e5, 5e5, 50e5 N/m. Gravity acts during the contact as well, which
    changes e by a part of g/(omega0 v), so the error falls by sqrt(10) each time; the softest
    also by higher orders."""
    hard = np.array([bounce_height(0.5, 0.1, e, k) for k in (1, 2, 3)])
    errors = np.array([np.abs(bounces(k, e, 3) - hard) for k in (0.5e5, 5e5, 50e5)])
    assert (errors[2] < 0.02 * 0.4).all()
    assert errors[1] / errors[2] == pytest.approx(math.sqrt(10), rel=0.15)
    assert (errors[0] > 2 * errors[1]).all()
