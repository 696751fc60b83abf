"""Motion of rigid clusters: free rotation, impacts and rolling with a closed form, momenta."""

import dataclasses
import math

import numpy as np
import pytest
from cluster_beds import about, asymmetric, bed, particle, rotation, world_of
from damper_beds import DENSITY, NOWHERE, STILL, G, acrylic
from scipy.integrate import solve_ivp

from damper3d.engine.enclosures import box
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world
from damper3d.shapes.cylinder import cylinder
from damper3d.shapes.multisphere import sphere
from damper3d.shapes.oblate import oblate
from damper3d.studies.single_contact.particles import free_rotation, orientation
from damper3d.studies.single_contact.particles.free_rotation import SPIN, jacobi, triaxial

MIDDLE = [0.0, 0.0, 0.5]


def turning(cluster, spin, time_step):
    """One free cluster that begins to turn [rad/s]."""
    sim = world_of(cluster, MIDDLE, about([1, 2, 3], 0.7), time_step=time_step)
    sim.set_velocity(np.zeros((1, 3)), np.array([spin]))
    return sim


def kinetic(sim):
    return float(sim.sample()["kinetic"][0])


def test_a_free_symmetric_particle_rotates_as_in_closed_form():
    """Its axis goes round the constant angular momentum L at |L|/I_across, always at one angle; and
    w = I^-1 L. The scheme is exact there: also at 5 degrees a step, to rounding of 1000 steps."""
    cluster = particle("prolate:2")
    step = 1e-4
    sim = turning(cluster, (300.0, -500.0, 600.0), step)
    momentum, axis = (
        sim.world.particles.momentum[0, :3].copy(),
        sim.world.particles.axes[0, :3].copy(),
    )
    rate = np.linalg.norm(momentum) / (DENSITY * cluster.inertia[1])
    along = momentum / np.linalg.norm(momentum)
    assert 0.05 < rate * step < 0.3
    for _ in range(10):
        sim.step(100)
        turn = rotation(about(along, rate * sim.time))
        assert sim.world.particles.axes[0, :3] == pytest.approx(turn @ axis, abs=1e-10)
    assert np.array_equal(sim.world.particles.momentum[0, :3], momentum)
    assert np.linalg.norm(sim.world.particles.orientation[0]) == pytest.approx(1.0, abs=1e-15)


def test_a_free_asymmetric_particle_rotates_by_eulers_equations_to_second_order():
    """I w' = I w x w in the body's axes (thesis, eqs 3.24-3.30, with the errata's correction), to
    1e-12 by another integrator. Angular momentum stays to the bit, the quaternion at length 1;
    energy and orientation are off by a quarter when the step is halved."""
    cluster = asymmetric(particle("prolate:1.5"))
    spin, seconds = (400.0, 900.0, 300.0), 0.02
    inertia = DENSITY * cluster.inertia
    start = turning(cluster, spin, 1e-5)
    axes = rotation(start.world.particles.orientation[0])

    def rates(_, state):
        w, matrix = state[:3], state[3:].reshape(3, 3)
        skew = np.cross(np.eye(3), w)
        return np.concatenate([np.cross(inertia * w, w) / inertia, (matrix @ skew).ravel()])

    begin = np.concatenate([axes.T @ np.array(spin), axes.ravel()])
    exact = solve_ivp(rates, (0, seconds), begin, rtol=1e-12, atol=1e-12).y[3:, -1].reshape(3, 3)
    off, gained = [], []
    for step in (4e-5, 2e-5, 1e-5):
        sim = turning(cluster, spin, step)
        before, momentum = kinetic(sim), sim.world.particles.momentum.copy()
        energies = []
        for _ in range(10):
            sim.step(round(seconds / step) // 10)
            energies.append(kinetic(sim))
        assert np.array_equal(sim.world.particles.momentum, momentum)
        assert np.linalg.norm(sim.world.particles.orientation[0]) == pytest.approx(1.0, abs=1e-15)
        off.append(np.abs(rotation(sim.world.particles.orientation[0]) - exact).max())
        gained.append(np.abs(np.array(energies) / before - 1).max())
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.1)
    assert off[1] / off[2] == pytest.approx(4.0, rel=0.1)
    assert gained[1] / gained[2] == pytest.approx(4.0, rel=0.2)
    assert gained[2] < 1e-5


def test_a_multi_sphere_particle_of_one_moves_as_the_sphere():
    """Two spheres that meet off-centre near the floor, with friction and spins: the same path to
    rounding, of a time short enough that it does not grow (5 ms, five impacts)."""
    radius, law = 2.5e-3, acrylic()
    places = np.array([[0.0, 0.0, 1.02 * radius], [0.3 * radius, 0.1 * radius, 3.1 * radius]])
    velocity = np.array([[0.0, 0.0, -0.2], [0.1, 0.0, -1.0]])
    spin = np.array([[10.0, -40.0, 60.0], [80.0, 20.0, -30.0]])
    common = {"density": DENSITY, "enclosure": box(0.02, 0.02, 0.02), "pair_law": law,
              "wall_law": law, "shaker": STILL, "direction": np.array([0.0, 0.0, 1.0]),
              "gravity": np.array([0.0, 0.0, -G]), "time_step": 1e-6}  # fmt: skip
    balls = Simulation(build_world(places, np.full(2, radius), **common))
    clusters = Simulation(build_world(places, sphere(radius), **common))
    for sim in (balls, clusters):
        sim.steps_per_sample = 100
        sim.set_velocity(velocity, spin)
    rows = [sim.run(50) for sim in (balls, clusters)]
    frames = [sim.frame() for sim in (balls, clusters)]
    assert rows[0]["impact_speed_particle_particle"].max() > 0.5
    for name in ("x", "v", "spin"):
        scale = np.abs(frames[0][name]).max()
        assert frames[1][name] == pytest.approx(frames[0][name], abs=1e-9 * scale)
    for name in ("kinetic", "friction_particle_particle", "normal_damping_particle_wall"):
        assert rows[1][name][-1] == pytest.approx(rows[0][name][-1], rel=1e-9)


@pytest.mark.parametrize("sphere_number", [3, 14, 40])
def test_an_elastic_impact_of_a_tilted_spheroid_without_friction(sphere_number):
    """The impulse J = 2 v/(1/m + (r x n).I^-1.(r x n)) at the arm r gives v' = v - J/m and
    w' = I^-1 (r x n) J (any textbook). The tilt is such that the sphere of that number touches the
    smooth surface where it is lowest, so that r is the spheroid's own. Energy is kept to the
    scheme's error, momentum by construction; during 30 us the spheroid turns by 2e-3 rad and the
    contact moves along the axis from sphere to sphere, 0.1 mm of an arm of 1 mm: 2 %."""
    cluster = particle("prolate:1.5", 3.8e-3)
    a, b = np.sqrt(5 / (2 * cluster.volume) * (
        np.array([cluster.inertia[1] * 2 - cluster.inertia[0], cluster.inertia[0]])))  # fmt: skip
    x, radius = cluster.offsets[sphere_number, 0], cluster.radii[sphere_number]
    down = (x * a**2 / (a**2 - b**2) - x) / radius  # cosine between the axis and down
    tilt = math.asin(down)
    turn = rotation(about([0, 1, 0], tilt))
    assert turn[2, 0] == pytest.approx(-down)
    lowest = math.sqrt((a * down) ** 2 + (b * math.cos(tilt)) ** 2)
    assert -(turn @ cluster.offsets[sphere_number])[2] + radius == pytest.approx(lowest)
    arm = turn @ np.array([a**2 * down, 0.0, -(b**2) * math.cos(tilt)]) / lowest
    law, speed = acrylic(0.0, 1.0), 0.1
    sim = world_of(cluster, [0.0, 0.0, lowest + 2e-6], about([0, 1, 0], tilt), wall_law=law)
    sim.set_velocity(np.array([[0.0, 0.0, -speed]]), np.zeros((1, 3)))
    before = kinetic(sim)
    sim.step(400)
    assert len(sim.contacts()["overlap"]) == 0
    mass, inertia = DENSITY * cluster.volume, turn @ np.diag(DENSITY * cluster.inertia) @ turn.T
    moment = np.cross(arm, [0.0, 0.0, 1.0])
    spin_of_impulse = np.linalg.solve(inertia, moment)
    impulse = 2 * speed / (1 / mass + moment @ spin_of_impulse)
    frame = sim.frame()
    assert frame["v"][0, 2] == pytest.approx(impulse / mass - speed, abs=0.02 * speed)
    assert frame["spin"][0] == pytest.approx(impulse * spin_of_impulse, rel=0.02, abs=1e-6)
    assert frame["v"][0, :2] == pytest.approx(0.0, abs=1e-12)
    assert kinetic(sim) == pytest.approx(before, rel=1e-3)


def test_a_spheroid_that_slides_across_its_axis_ends_rolling():
    """About its axis it has the sphere's moment, 2/5 m b^2: from u0 it slides until
    2 u0/(7 mu g), and then rolls at 5 u0/7 (closed form), lying on its middle sphere. The
    deepest contact alone: of several in a row each has a spring of its own."""
    cluster, mu, u0 = particle("prolate:1.5", 3.8e-3), 0.3, 0.1
    law, b = acrylic(mu), particle("prolate:1.5", 3.8e-3).radii.max()
    mass = DENSITY * cluster.volume
    height = b - (mass * G / (law.hertz * math.sqrt(b))) ** (2 / 3)
    sim = world_of(cluster, [0.0, 0.0, height], wall_law=law, gravity=(0.0, 0.0, -G),
                   treatment="deepest", time_step=2e-6)  # fmt: skip
    sim.set_velocity(np.array([[0.0, u0, 0.0]]), np.zeros((1, 3)))
    slides = 2 * u0 / (7 * mu * G)
    sim.step(round(0.5 * slides / 2e-6))
    assert sim.frame()["v"][0, 1] == pytest.approx(u0 - mu * G * sim.time, rel=2e-3)
    sim.step(round(1.0 * slides / 2e-6))
    frame = sim.frame()
    assert frame["v"][0] == pytest.approx([0.0, 5 / 7 * u0, 0.0], rel=2e-3, abs=1e-4 * u0)
    assert -frame["spin"][0, 0] * b == pytest.approx(5 / 7 * u0, rel=2e-3)


@pytest.mark.parametrize("treatment", ["sum", "deepest", "scaled"])
@pytest.mark.parametrize("shape", ["prolate:1.5", "toroid:0.2"])
def test_momenta_change_by_the_impulses_of_the_walls_only(shape, treatment):
    """Linear, and angular about the axis of a cylinder with smooth walls: arms of both sides of a
    contact end in one point. To rounding of the sums."""
    sim = bed("cylinder", particle(shape), shaker=STILL, gravity=NOWHERE, speed=1.5,
              wall_law=acrylic(0.0), treatment=treatment)  # fmt: skip
    mass, bodies = sim.mass, sim.world.particles

    def momenta():
        x, v = bodies.position[:, :3], bodies.velocity[:, :3]
        orbit = mass * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])
        return (mass[:, None] * v).sum(axis=0), orbit, bodies.momentum[:, 2].copy()

    linear, orbit, own = momenta()
    scale = np.abs(orbit).sum() + np.abs(own).sum()
    sim.steps_per_sample = 4000
    impulses = sim.run(1)["wall_force"].sum(axis=(0, 1)) * 4000 * sim.world.time_step
    after = momenta()
    assert np.abs(after[0] - linear + impulses).max() < 1e-11 * np.abs(mass * 1.5).sum()
    assert abs((after[1] + after[2] - orbit - own).sum()) < 1e-11 * scale
    assert np.abs(after[2] - own).max() > 0.01 * scale / len(mass)  # spins did change


def set_rolling(shape, mu, *, slope=0.0, speed=0.0, time_step=2e-6):
    """(simulation, k, R): a body on the floor that can roll along x, of k = I/(m R^2) about its
    axis and the radius R: a lying prolate, or a toroid of 1000 sub-spheres on its rim."""
    if shape == "prolate":
        cluster, turn = particle("prolate:1.5", 3.8e-3), about([0, 0, 1], math.pi / 2)
        radius, moment = cluster.radii.max(), cluster.inertia[0]
    else:  # its axis z to -y, a sub-sphere at the bottom: x to -z
        cluster = particle("toroid:0.2", 3.5e-3, sub_spheres=1000)
        turn = about([1, 1, -1], 2 * math.pi / 3)
        radius, moment = cluster.bounding_radius, cluster.inertia[2]
    law, mass = acrylic(mu), DENSITY * cluster.volume
    pressed = mass * G * math.cos(slope) / (law.hertz * math.sqrt(cluster.radii.max()))
    sim = world_of(cluster, [0.0, 0.0, radius - pressed ** (2 / 3)], turn, wall_law=law,
                   gravity=(G * math.sin(slope), 0.0, -G * math.cos(slope)), treatment="deepest",
                   time_step=time_step)  # fmt: skip
    sim.set_velocity(np.array([[speed, 0.0, 0.0]]), np.zeros((1, 3)))
    return sim, cluster.volume * radius**2 / moment, radius


def test_a_toroid_that_slides_on_its_rim_ends_rolling():
    """While it slides v = u0 - mu g t, R w = (mu g/k) t, k = I/(m R^2); they are equal at
    t = u0/(mu g (1 + 1/k)), and v = u0/(1 + k) from then on. The grooves between 1000 sub-spheres
    are 0.03 um deep; the contact stands to either side by up to 14 um then, over which the weight
    turns the body by 1 % of what friction does, forth and back."""
    mu, u0 = 0.3, 0.1
    sim, inverse, radius = set_rolling("toroid", mu, speed=u0)
    slides = u0 / (mu * G * (1 + inverse))
    sim.step(round(0.5 * slides / 2e-6))
    frame = sim.frame()
    assert frame["v"][0, 0] == pytest.approx(u0 - mu * G * sim.time, rel=1e-3)
    assert frame["spin"][0, 1] * radius == pytest.approx(inverse * mu * G * sim.time, rel=0.01)
    sim.step(round(1.0 * slides / 2e-6))
    frame = sim.frame()
    assert frame["v"][0, 0] == pytest.approx(u0 / (1 + 1 / inverse), rel=2e-3)
    assert frame["spin"][0, 1] * radius == pytest.approx(frame["v"][0, 0], rel=2e-3)


@pytest.mark.parametrize("shape", ["prolate", "toroid"])
@pytest.mark.parametrize("mu", [0.5, 0.05])
def test_rolling_and_sliding_down_an_incline(shape, mu):
    """From rest at 15 degrees: where mu > tan/(1 + m R^2/I) it rolls, v = g sin t/(1 + k), 5/7 of
    g sin for a prolate that lies across; else it slides, v = g (sin - mu cos) t and
    R w = (mu g cos/k) t. Of a toroid the weight turns it about the contact beside, see
    above, by 6 % of what friction of 0.05 does, forth and back."""
    slope, seconds = math.radians(15), 0.02
    sim, inverse, radius = set_rolling(shape, mu, slope=slope)
    sim.step(round(seconds / 2e-6))
    speed, rim = sim.frame()["v"][0, 0], sim.frame()["spin"][0, 1] * radius
    rolling = G * math.sin(slope) * seconds / (1 + 1 / inverse)
    if shape == "prolate":
        assert rolling == pytest.approx(5 / 7 * G * math.sin(slope) * seconds, rel=1e-9)
    rolls = mu > math.tan(slope) / (1 + inverse)
    assert rolls == (mu == 0.5)
    push = mu * G * math.cos(slope) * seconds
    assert speed == pytest.approx(
        rolling if rolls else G * math.sin(slope) * seconds - push, rel=5e-3
    )
    assert rim == pytest.approx(speed if rolls else inverse * push, rel=0.01)


def test_a_triaxial_particle_rotates_by_jacobi_s_elliptic_functions():
    """Landau and Lifshitz, Mechanics, sec. 37: w in the body's axes, which obeys Euler's equations
    (by differences), and what the engine gives, to second order; in both senses about the axis."""
    moments = np.array([1.0, 1.5, 2.0])
    times = np.linspace(0.0, 3.0, 3001)
    for spin in ((0.3, 2.0, 0.9), (-0.3, 0.5, -1.1)):
        w = jacobi(moments, np.array(spin), times)
        assert w[0] == pytest.approx(spin, abs=1e-12)
        rates = np.cross(moments * w, w) / moments
        assert np.gradient(w, times, axis=0)[1:-1] == pytest.approx(rates[1:-1], abs=1e-5)
    body = triaxial()
    exact = jacobi(DENSITY * body.inertia, np.array(SPIN), np.array([0.02]))[0]
    off = []
    for step in (2e-4, 1e-4):
        sim = free_rotation.turning(body, SPIN, step)
        sim.step(round(0.02 / step))
        off.append(np.abs(free_rotation.own_spin(sim) - exact).max())
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.1)
    assert off[1] < 2e-4 * np.abs(exact).max()


def test_rebound_by_orientation_against_the_rigid_body(monkeypatch):
    """Elastic, one contact: the contact point leaves as fast as it came at every tilt, and the
    centroid as the impulse has it; the spheroid turns and its contact moves on while they touch:
    2 %. With e = 0.86 the dashpot of the whole mass acts on 1/(1/m + (r x n).I^-1.(r x n)), and
    the damping ratio is larger by the root of their ratio (eq. 5.29); also to 2 %."""
    monkeypatch.setattr(orientation, "N_TILTS", 7)
    for shape, radius in (("prolate:1.5", 3.8e-3), ("toroid:0.2", 3.5e-3)):
        cluster = particle(shape, radius)
        elastic = orientation.rebounds(cluster, acrylic(0.0, 1.0), "deepest", DENSITY, 1.0)
        damped = orientation.rebounds(cluster, acrylic(0.0, 0.86), "deepest", DENSITY, 0.86)
        for row, slower in zip(elastic, damped, strict=True):
            assert row["restitution"] == pytest.approx(1.0, abs=0.02)
            assert row["rebound"] == pytest.approx(row["rigid_rebound"], abs=0.02)
            assert row["energy_lost"] == pytest.approx(0.0, abs=2e-3)
            wanted = slower["one_contact_restitution"]
            assert slower["restitution"] == pytest.approx(wanted, abs=0.02)
        assert min(row["one_contact_restitution"] for row in damped) < 0.845


def without_filling(shape):
    """A particle whose smooth shape alone counts, of 1 m."""
    if shape.startswith(("prolate", "toroid")):
        return particle(shape, 1.0)
    solid = oblate(0.7) if shape == "oblate:0.7" else cylinder(1.5, 0.2)
    return dataclasses.replace(
        sphere(1.0), name=shape, kind=shape.partition(":")[0], surface=solid.surface,
        volume=solid.volume, inertia=solid.inertia,
    )  # fmt: skip


@pytest.mark.parametrize("shape", orientation.SHAPES)
def test_the_arm_of_an_impact_ends_at_the_lowest_point_of_the_smooth_body(shape):
    """None of the surface's triangles reaches lower, and some corner as low but for their size:
    0.3 % of the equal-volume radius for the coarsest, of a toroid's tube (1 - cos(pi/32) of b)."""
    cluster = without_filling(shape)
    for tilt in np.radians([10.0, 35.0, 60.0, 85.0]):
        turned = orientation.matrix(orientation.orientation(cluster.kind, tilt, 0.4))
        arm = orientation.arm(cluster, turned)
        lowest = (cluster.surface.vertices @ turned.T)[:, 2].min()
        assert arm[2] <= lowest + 1e-9
        assert arm[2] == pytest.approx(lowest, abs=3e-3)
