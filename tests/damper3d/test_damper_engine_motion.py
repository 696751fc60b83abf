"""Motions with a closed form, and symmetries that the engine must have."""

import math

import numpy as np
import pytest
from damper_beds import DENSITY, LARGEST, NOWHERE, STILL, G, acrylic, at_rest, bed, lone
from scipy.integrate import solve_ivp

from damper3d.engine.enclosures import box
from damper3d.engine.motions import Sines
from damper3d.engine.simulation import Simulation
from damper3d.engine.state import YIELD
from damper3d.engine.world import build_world
from granulab.contact.files.datafile import data_file
from granulab.contact.files.table import load_table
from granulab.contact.sphere_law import yield_velocity

MASS = DENSITY * 4 / 3 * math.pi * LARGEST**3


@pytest.mark.parametrize("tangential", ["displacement", "force"])
def test_a_sphere_that_slides_ends_rolling(tangential):
    """Without spin on the floor at u0: until t_s = 2 u0/(7 mu g) it slides, then it rolls at
    5 u0/7 (closed form). The arm is the radius less the overlap, 1e-5 of it; the tangential
    spring rings for some periods of 0.1 ms at the end, by less than a thousandth."""
    u0, mu = 0.1, 0.3
    law = acrylic(mu, tangential=tangential)
    slides = 2 * u0 / (7 * mu * G)
    sim = lone(law, height=at_rest(law), velocity=(u0 * 0.6, u0 * 0.8, 0.0))
    for share in (0.25, 0.5, 0.75, 0.98):
        sim.step(round(share * slides / 1e-6) - sim.steps)
        frame = sim.frame()
        assert np.linalg.norm(frame["v"][0]) == pytest.approx(u0 - mu * G * sim.time, rel=1e-3)
        spin = 2.5 * mu * G * sim.time / LARGEST
        assert frame["spin"][0] == pytest.approx([-0.8 * spin, 0.6 * spin, 0.0], rel=1e-3, abs=1e-9)
    for share in (1.5, 2.5):
        sim.step(round(share * slides / 1e-6) - sim.steps)
        frame = sim.frame()
        speed = 5 / 7 * u0
        assert frame["v"][0] == pytest.approx([0.6 * speed, 0.8 * speed, 0.0], rel=1e-3, abs=1e-6)
        assert np.linalg.norm(frame["spin"][0]) == pytest.approx(speed / LARGEST, rel=1e-3)


@pytest.mark.parametrize(("mu", "rolls"), [(0.3, True), (0.1, False)])
def test_a_sphere_on_an_incline(mu, rolls):
    """(5/7) g sin where mu > (2/7) tan, else g (sin - mu cos) (closed form), here at 30
    degrees. It starts with the spring relaxed: the speed swings about the closed form by the way
    that the spring takes up, 1e-3 of the speed after 10 ms."""
    angle = math.radians(30.0)
    law = acrylic(mu)
    gravity = (G * math.sin(angle), 0.0, -G * math.cos(angle))
    sim = lone(law, height=at_rest(law, G * math.cos(angle)), gravity=gravity)
    sim.step(20_000)
    down = 5 / 7 * math.sin(angle) if rolls else math.sin(angle) - mu * math.cos(angle)
    assert sim.frame()["v"][0, 0] == pytest.approx(down * G * sim.time, rel=2e-3)
    turn = sim.frame()["v"][0, 0] if rolls else 2.5 * mu * G * math.cos(angle) * sim.time
    assert sim.frame()["spin"][0, 1] * LARGEST == pytest.approx(turn, rel=2e-3)


def test_a_bouncing_sphere_of_period_one():
    """A lone sphere with e = 0.5 at Gamma 1.3 (closed form: stable from 1.05 to 1.53), started
    on its orbit, takes m g^2 T^2 (1 - e)/(2 (1 + e)) a cycle from the floor. An impact at
    0.4 m/s takes 40 us, 1e-3 of the period, in which floor and gravity act on: so much is open."""
    e, gamma, frequency = 0.5, 1.3, 25.0
    omega, period = 2 * math.pi * frequency, 1 / frequency
    phase = math.acos(math.pi * (1 - e) / ((1 + e) * gamma))
    amplitude = gamma * G / omega**2
    floor = Sines(np.array([amplitude]), np.array([omega]), np.array([phase]), 0.0)
    sim = lone(
        acrylic(0.0, e), height=amplitude * math.sin(phase) + LARGEST,
        velocity=(0.0, 0.0, G * period / 2), shaker=floor, time_step=2.5e-7,
        steps_per_sample=160_000,
    )  # fmt: skip
    sim.step(80_000)  # in the middle of its flight
    speed = G * period / (1 + e)
    sim.world.impacts[1, YIELD] = 0.99 * speed
    rows = sim.run(6)
    expected = MASS * G**2 * period**2 * (1 - e) / (2 * (1 + e))
    assert np.diff(rows["wall_work"])[-3:] == pytest.approx(expected, rel=5e-3)
    assert np.diff(rows["normal_damping_particle_wall"])[-3:] == pytest.approx(expected, rel=5e-3)
    assert rows["impact_speed_particle_wall"][-1] == pytest.approx(speed, rel=5e-3)
    assert rows["impacts_particle_wall"][1:].tolist() == [1] * 5  # one a cycle, beyond 0.99 of it
    assert rows["impacts_beyond_yield_particle_wall"][1:].tolist() == [1] * 5
    sim.world.impacts[1, YIELD] = 1.01 * speed
    assert sim.run(1)["impacts_beyond_yield_particle_wall"].tolist() == [0]


@pytest.mark.parametrize("restitution", [1.0, 0.7])
def test_stacked_spheres_squeezed_between_walls(restitution):
    """As MFiX DEM03, with Hertz: two spheres that are always squeezed between
    floor and lid follow their two coupled equations, eqs 5.32 and 5.6 written once more.

    The leapfrog's phase error is (2 pi dt/T)^2/24 of the phase; in ten periods of some 300 steps
    1e-3 of the amplitude. With dashpots as much."""
    law, r, dt = acrylic(0.0, restitution), LARGEST, 1e-7
    height, start, speed = 3.97 * r, np.array([0.992 * r, 2.979 * r]), np.array([0.3, 0.0])
    sim = Simulation(
        build_world(
            np.column_stack([np.zeros((2, 2)), start]), np.full(2, r), density=DENSITY,
            enclosure=box(0.1, 0.1, height), pair_law=law, wall_law=law, shaker=STILL,
            direction=np.array([0.0, 0, 1]), gravity=np.zeros(3), time_step=dt,
        )
    )  # fmt: skip
    sim.set_velocity(np.array([[0, 0, speed[0]], [0, 0, speed[1]]]))

    def push(overlap, rate, radius, mass):
        stiffness = law.hertz * math.sqrt(radius * overlap)
        dashpot = math.sqrt(5.0) * law.damping * math.sqrt(stiffness * mass)
        return stiffness * overlap + dashpot * rate

    def rates(_, state):
        (a, b), (v_a, v_b) = state[:2], state[2:]
        floor = push(r - a, -v_a, r, MASS)
        lid = push(b + r - height, v_b, r, MASS)
        middle = push(2 * r - (b - a), v_a - v_b, r / 2, MASS / 2)
        return [v_a, v_b, (floor - middle) / MASS, (middle - lid) / MASS]

    # The engine's velocities are half a step behind the positions.
    sim.world.particles.velocity[:, 2] -= dt / 2 * np.array(rates(0.0, [*start, *speed])[2:])
    times = np.arange(1, 11) * 300
    exact = solve_ivp(rates, (0, times[-1] * dt), [*start, *speed], t_eval=times * dt, rtol=1e-10,
                      atol=1e-14)  # fmt: skip
    found = []
    for _ in times:
        sim.step(300)
        found.append(sim.frame()["v"][:, 2])
    assert np.abs(np.array(found) - exact.y[2:].T).max() < 2e-3 * speed[0]


def moved(sim):
    frame = sim.frame()
    return frame["x"], frame["v"], frame["spin"]


# Steps: some impacts a sphere, through which rounding grows to 1e-10. What breaks a symmetry is of
# order one, or of the overlaps, 1e-3.
SHORT, ROUNDING = 3000, 1e-7


@pytest.mark.parametrize("shape", ["cylinder", "box"])
def test_a_uniform_motion_of_all_changes_nothing(shape):
    """Galilei: enclosure and bed at a constant velocity. The motion is the beginning of a sine so
    slow that after 3 ms its velocity has changed by 1e-15."""
    along, speed = np.array([0.6, 0.0, 0.8]), 2.0
    slow = 1e-5
    uniform = Sines(np.array([speed / slow]), np.array([slow]), np.zeros(1), 0.0)
    still = bed(shape, shaker=STILL, speed=1.5)
    carried = bed(shape, shaker=uniform, direction=along, speed=1.5, drift=speed * along)
    for sim in (still, carried):
        sim.step(SHORT)
    (x, v, w), (x_c, v_c, w_c) = moved(still), moved(carried)
    assert np.abs(x_c - x).max() < ROUNDING * LARGEST
    assert np.abs(v_c - speed * along - v).max() < ROUNDING
    assert np.abs(w_c - w).max() < ROUNDING * np.abs(w).max()
    assert still.sample()["friction_particle_wall"][0] > 0.0
    for kind in ("friction", "normal_damping", "tangential_damping", "law_term"):
        for c in ("particle_particle", "particle_wall"):
            name = f"{kind}_{c}"
            assert carried.sample()[name] == pytest.approx(still.sample()[name], rel=ROUNDING)


@pytest.mark.parametrize("turn", [0.4, 2.0, 4.0])
def test_a_bed_rotated_about_the_axis_moves_rotated(turn):
    """A cylinder shaken along its axis; other cells, other normals, the same motion."""
    first, second = bed(speed=1.5), bed(speed=1.5, turn=turn)
    c, s = math.cos(turn), math.sin(turn)
    about = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    for sim in (first, second):
        sim.step(SHORT)
    for a, b in zip(moved(first), moved(second), strict=True):
        assert np.abs(a @ about.T - b).max() < ROUNDING * np.abs(a).max()
    assert np.allclose(first.world.balance, second.world.balance, rtol=ROUNDING, atol=0.0)


@pytest.mark.parametrize("pair", [False, True])
@pytest.mark.parametrize("times", [0.5, 2.0, 4.0])
def test_restitution_falls_above_the_yield_velocity(times, pair):
    """With law.yielding a head-on impact at so many times v_y (eq. 5.26) has e = e0 (v_y/v)^(1/4)
    above it, and e0 below. Tolerance: steps per contact, some 40."""
    acryl = load_table(data_file("materials", "acrylic")).materials["acrylic"]
    share = 0.5 if pair else 1.0
    v_y = yield_velocity(acryl, acryl, radius=share * LARGEST, mass=share * MASS)
    law, v = acrylic(0.0, 0.86, yielding=True), times * v_y
    if not pair:
        sim = lone(law, height=LARGEST * 1.001, velocity=(0.0, 0.0, -v), gravity=NOWHERE)
        sim.world = sim.world._replace(time_step=2e-7)
        sim.step(800)
        left = sim.frame()["v"][0, 2]
    else:
        middle = bed(n=2, pair_law=law, wall_law=law, shaker=STILL, gravity=NOWHERE, smallest=1.0,
                     time_step=2e-7)  # fmt: skip
        middle.world.spheres.position[:2, :3] = [
            [-1.001 * LARGEST, 0, 0.01],
            [1.001 * LARGEST, 0, 0.01],
        ]
        middle.set_velocity(np.array([[v / 2, 0, 0], [-v / 2, 0, 0]]), np.zeros((2, 3)))
        middle.step(800)
        left = np.ptp(middle.frame()["v"][:, 0])
    expected = 0.86 * min(1.0, times**-0.25)
    assert left / v == pytest.approx(expected, rel=3e-3)


def test_a_cooling_gas_follows_haff():
    """A weak test: without friction and gravity, between elastic walls, T = T0/(1 + t/tau)^2
    (Haff 1983), so that 1/sqrt(T) rises evenly: over each half of the run by the same, within what
    the few spheres scatter."""
    law, wall = acrylic(0.0, 0.9), acrylic(0.0, 1.0)
    sim = bed("box", pair_law=law, wall_law=wall, shaker=STILL, gravity=NOWHERE, speed=1.0,
              smallest=1.0, steps_per_sample=10_000)  # fmt: skip
    sim.set_velocity(sim.frame()["v"], np.zeros((sim.n_particles, 3)))
    sim.run(1)
    slowness = 1.0 / np.sqrt(sim.run(20)["kinetic"])
    first, second = slowness[10] - slowness[0], slowness[-1] - slowness[10]
    assert slowness[-1] > 3 * slowness[0]
    assert second * 10 / 9 == pytest.approx(first, rel=0.3)
