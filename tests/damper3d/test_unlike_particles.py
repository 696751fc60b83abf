"""Beds of particles of several shapes: their contacts, momenta and energy, and runs of them."""

import dataclasses
import shutil

import numpy as np
import pytest
from analytic import damped_hertz_deepest, hertz_impact
from cluster_beds import ROOMS, about, bed, particle, rotation, touching
from damper_beds import DENSITY, DOWN, NOWHERE, SHAKEN, STILL, acrylic
from damper_runs import small_mixture
from forking import forked
from same_run import assert_same_run, results
from small_silo import the_run

from damper3d.engine import state
from damper3d.engine.enclosures import box
from damper3d.engine.laws.table import Contact, law_table
from damper3d.engine.records import CLASSES, HELD, MECHANISMS
from damper3d.engine.simulation import Simulation
from damper3d.engine.world import build_world
from damper3d.run import protocol, vibration
from damper3d.run.fill import random_start
from damper3d.shapes.multisphere import sphere
from damper3d.view.export import export
from damper3d.view.scene import read_scene
from granulab.campaign.runs.trajectory import read_trajectory

ROOM = box(1.0, 1.0, 1.0)
BALL, PROLATE = sphere(1.8e-3), particle("prolate:1.5", sub_spheres=15)


def mixture(particles, places, turns=None, *, law=None, density=DENSITY, room=ROOM, shaker=STILL,
            gravity=NOWHERE, time_step=1e-6, steps_per_sample=1,
            treatment="sum") -> Simulation:  # fmt: skip
    """Particles at rest, each with its shape, under one law."""
    m, walls = sum(len(one.radii) for one in particles), np.ones(len(room.wall_names), np.int64)
    laws = law_table([Contact(law or acrylic())], np.zeros((2, 2)), np.zeros(m, np.int64),
                     np.ones(m), walls=walls)  # fmt: skip
    world = build_world(
        np.atleast_2d(places), list(particles), None if turns is None else np.atleast_2d(turns),
        density=density, enclosure=room, pair_law=laws, wall_law=laws, shaker=shaker,
        direction=np.array([0.0, 0.0, 1.0]), gravity=np.array(gravity, float), time_step=time_step,
        treatment=treatment,
    )  # fmt: skip
    return Simulation(world, steps_per_sample)


def vigorous(shapes=(BALL, PROLATE), *, speed=0.5, **options) -> Simulation:
    """27 particles on a grid, the shapes by turns, turned and moving at random [m/s]."""
    alike = bed("box", speed=speed)
    frame, n = alike.frame(), alike.n_particles
    sim = mixture([shapes[k % len(shapes)] for k in range(n)], frame["x"], frame["orientation"],
                  room=ROOMS["box"], shaker=SHAKEN, gravity=DOWN, **options)  # fmt: skip
    sim.set_velocity(frame["v"], frame["spin"])
    return sim


def state_after(sim, steps):
    sim.step(steps)
    return sim.state_digest(), sim.world.balance.tobytes(), sim.frame()["heat"].tobytes()


# Contacts


def test_particles_that_differ_by_name_alone_move_to_the_bits_of_those_that_are_alike():
    """Rows of their own, laws by pair and keys by particle give what one shape and one law give:
    each number is calculated from the same ones in the same order."""
    alike = bed("box", PROLATE, speed=2.0)
    twins = vigorous((PROLATE, dataclasses.replace(PROLATE)), speed=2.0)
    assert len(twins.world.shape.form.offset) == 2 * len(alike.world.shape.form.offset)
    assert state_after(twins, 3000) == state_after(alike, 3000)
    assert alike.world.counts[state.INNER_SEARCHES] > 5


def brute_force(sim, particles):
    """All (particle, sphere, particle or wall, sphere) of a box that overlap now."""
    frame, found = sim.frame(), set()
    centres = [
        x + one.offsets @ rotation(q).T
        for x, q, one in zip(frame["x"], frame["orientation"], particles, strict=True)
    ]
    for i, one in enumerate(particles):
        for j in range(i + 1, len(particles)):
            gaps = np.linalg.norm(centres[i][:, None] - centres[j][None], axis=2)
            touch = gaps < one.radii[:, None] + particles[j].radii
            found |= {(i, p, j, q) for p, q in np.argwhere(touch).tolist()}
        for w, plane in enumerate(sim.world.walls.planes):
            touch = one.radii > centres[i] @ plane[:3] - plane[3]
            found |= {(i, int(p), len(particles) + w, 0) for p in np.flatnonzero(touch)}
    return found


def test_contacts_of_a_mixture_are_those_of_a_search_over_all_pairs():
    """Of three shapes in vigorous motion, with lists as old as they are."""
    shapes = (BALL, PROLATE, particle("toroid:0.2", sub_spheres=20))
    sim, rng, seen = vigorous(shapes, speed=6.0), np.random.default_rng(1), set()
    particles = [shapes[k % 3] for k in range(sim.n_particles)]
    for _ in range(20):
        sim.step(int(rng.integers(1, 1500)))
        found = touching(sim)
        assert found == brute_force(sim, particles)
        seen |= {(i % 3, j % 3) for i, _, j, _ in found if j < len(particles)}
    assert len(seen) >= 5, "hardly two shapes have met"


@pytest.mark.parametrize("treatment", ["sum", "deepest", "scaled"])
def test_no_bit_of_a_mixture_depends_on_its_lists_or_on_being_put_back(treatment):
    """Neither on skins, put to extremes every 50 steps, nor on being put back with its springs."""
    undisturbed = state_after(vigorous(speed=2.0, treatment=treatment), 3000)
    sim = vigorous(speed=2.0, treatment=treatment)
    for _ in range(60):
        sim.world.lengths[[state.INNER_SKIN, state.WALL_SKIN]] = 0.03 * BALL.radii[0], 1e-5
        sim.world.counts[[state.STALE_INNER, state.STALE_WALL]] = 1
        sim.step(50)
    assert state_after(sim, 0) == undisturbed
    assert sim.world.balance[state.FRICTION] > 0.0
    sim, other = vigorous(speed=2.0, treatment=treatment), vigorous(speed=2.0, treatment=treatment)
    sim.step(500)
    while not len(sim.save()["pairs"]):
        sim.step(10)
    other.restore(sim.save())
    assert state_after(other, 1500) == state_after(sim, 1500)


# Impacts


def test_a_sphere_of_a_mixture_moves_as_one_of_the_engine_of_spheres():
    """Two that meet off-centre near the floor, with friction and spins, and a spheroid elsewhere:
    the same path to rounding, of a time short enough that it does not grow (5 ms)."""
    radius, room, law = 2.5e-3, box(0.02, 0.02, 0.02), acrylic()
    places = np.array([[0.0, 0.0, 1.02 * radius], [0.3 * radius, 0.1 * radius, 3.1 * radius]])
    velocity = np.array([[0.0, 0.0, -0.2], [0.1, 0.0, -1.0]])
    spin = np.array([[10.0, -40.0, 60.0], [80.0, 20.0, -30.0]])
    balls = Simulation(build_world(
        places, np.full(2, radius), density=DENSITY, enclosure=room, pair_law=law, wall_law=law,
        shaker=STILL, direction=np.array([0.0, 0.0, 1.0]), gravity=np.array(DOWN), time_step=1e-6,
    ))  # fmt: skip
    mixed = mixture([sphere(radius)] * 2 + [PROLATE], [*places, [7e-3, 7e-3, 16e-3]], room=room,
                    gravity=DOWN)  # fmt: skip
    balls.set_velocity(velocity, spin)
    mixed.set_velocity(np.vstack([velocity, np.zeros(3)]), np.vstack([spin, np.zeros(3)]))
    for sim in (balls, mixed):
        sim.step(5000)
    found, expected = mixed.frame(), balls.frame()
    assert np.abs(expected["v"] - velocity).max() > 0.3
    for name in ("x", "v", "spin", "heat"):
        scale = np.abs(expected[name]).max()
        assert found[name][:2] == pytest.approx(expected[name], abs=1e-9 * scale)


def test_rebound_and_deepest_overlap_of_a_sphere_of_a_mixture():
    """e v and the damped Hertz oscillator's deepest point, on the floor and on another sphere of
    three times the density: contact lasts some 300 steps, and they are off by a step, 3e-3."""
    e, speed, radius = 0.86, 1.0, 2.5e-3
    law = acrylic(restitution=e)
    masses = 4.0 / 3.0 * np.pi * radius**3 * np.array([DENSITY, 3.0 * DENSITY])
    density = np.array([DENSITY, 3.0 * DENSITY, DENSITY])
    for places in (
        [[0.0, 0.0, radius + 1e-7], [0.1, 0.0, 0.5], [0.3, 0.3, 0.3]],
        [[0.0, 0.0, 0.5 + 2.0 * radius + 1e-7], [0.0, 0.0, 0.5], [0.3, 0.3, 0.3]],
    ):
        sim = mixture([sphere(radius), sphere(radius), PROLATE], places, law=law, density=density,
                      time_step=2e-7)  # fmt: skip
        on_floor = places[0][2] < 0.1
        sim.set_velocity(np.array([[0.0, 0.0, -speed], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
        deepest = 0.0
        for _ in range(600):
            sim.step(1)
            now = sim.contacts()["overlap"]
            deepest = max(deepest, *now) if len(now) else deepest
        mass = masses[0] if on_floor else masses.prod() / masses.sum()
        own = radius if on_floor else 0.5 * radius
        elastic, _, _ = hertz_impact(0.75 * law.hertz, own, mass, speed)
        v = sim.frame()["v"][:, 2]
        assert v[0] - (0.0 if on_floor else v[1]) == pytest.approx(e * speed, rel=3e-3)
        assert deepest == pytest.approx(damped_hertz_deepest(elastic, e), rel=3e-3)


def test_a_sphere_and_a_spheroid_that_meet_centrally_part_with_the_restitution():
    """Along the line of the centroids, where one sub-sphere touches: v' = (m1 v + m2 0 - e m2 v)/M
    and (1 + e) m1 v/M, with M = m1 + m2; contact lasts some 300 steps, to 3e-3."""
    e, speed, blunt = 0.86, 1.0, particle("prolate:1.5", sub_spheres=3)
    light, heavy = DENSITY * BALL.volume, 2.0 * DENSITY * blunt.volume
    height = 0.5 + blunt.radii.max() + BALL.radii[0] + 1e-7
    sim = mixture([blunt, BALL], [[0.0, 0.0, 0.5], [0.0, 0.0, height]], law=acrylic(restitution=e),
                  density=np.array([2.0 * DENSITY, DENSITY]), time_step=2e-7)  # fmt: skip
    sim.set_velocity(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -speed]]))
    sim.step(600)
    both = light + heavy
    expected = [-(1 + e) * light / both * speed, (e * heavy - light) / both * speed]
    assert sim.frame()["v"][:, 2] == pytest.approx(expected, rel=3e-3)
    assert np.abs(sim.frame()["spin"]).max() < 1e-6


@pytest.mark.parametrize("treatment", ["sum", "deepest", "scaled"])
def test_an_off_centre_impact_of_a_spheroid_with_a_sphere_keeps_momenta_to_rounding(treatment):
    """sum m v and sum (x x m v + L), without gravity: both get the same force at one point, which
    friction turns too; what moved by itself now moves and turns the other. Velocities are rounded
    to 2e-16 of 2 m/s, places to 6e-17 m in each step."""
    particles, density = [PROLATE, BALL], np.array([DENSITY, 4.0 * DENSITY])
    mass = density * [one.volume for one in particles]
    above = 0.6 * PROLATE.bounding_radius
    sim = mixture(particles, [[0.0, 0.0, 0.5], [above, 0.3e-3, 0.5 + 4.2e-3]],
                  [about([1, 2, 3], 0.3), about([0, 0, 1], 0.0)], density=density,
                  treatment=treatment)  # fmt: skip
    sim.set_velocity(np.array([[0.0, 0.0, 0.0], [0.2, -0.1, -2.0]]),
                     np.array([[0.0, 0.0, 0.0], [50.0, 300.0, -80.0]]))  # fmt: skip
    bodies = sim.world.particles

    def sums():
        x, v = bodies.position[:, :3] - [0.0, 0.0, 0.5], bodies.velocity[:, :3]
        return mass @ v, (np.cross(x, mass[:, None] * v) + bodies.momentum[:, :3]).sum(axis=0)

    before, size = sums(), mass[1] * 2.0
    sim.step(2000)
    after = sums()
    assert np.abs(bodies.velocity[0]).max() > 0.3
    assert np.abs(sim.frame()["spin"][0]).max() > 50.0
    assert after[0] == pytest.approx(before[0], abs=1e-12 * size)
    assert after[1] == pytest.approx(before[1], abs=2000 * 6e-17 * size)


def left_open(time_step):
    """What the energy balance of 3 ms of vigorous motion leaves open, of what was dissipated."""
    sim = vigorous(speed=1.0, time_step=time_step, steps_per_sample=round(3e-3 / time_step))
    first, last = sim.sample(), sim.run(1)
    change = {name: float(last[name][-1] - first[name][-1]) for name in first
              if first[name].ndim == 1}  # fmt: skip
    lost = sum(change[f"{kind}_{c}"] for c in CLASSES for kind in MECHANISMS)
    gained = change["wall_work"] + sum(change[f"law_term_{c}"] for c in CLASSES)
    return abs(gained - sum(change[name] for name in HELD) - lost) / lost


def test_the_energy_balance_of_a_mixture_closes_to_second_order():
    """As those of beds of one shape: 0.5 % at 1 us, and each halving of the step leaves at most a
    third open, over a few impacts, before chaos makes of each step another bed."""
    errors = [left_open(step) for step in (4e-6, 2e-6, 1e-6)]
    assert errors[2] < 0.005
    assert errors[2] < errors[0] / 9


# Runs


@pytest.fixture(scope="module")
def run_of_mixture(tmp_path_factory):
    root = tmp_path_factory.mktemp("mixture")
    protocol.run(small_mixture(), out=root)
    return the_run(root)


def test_the_random_start_of_a_mixture_has_no_overlap_and_lies_inside():
    case = small_mixture()
    centres, turns = random_start(case, case.count)
    spheres = [
        x + one.offsets @ rotation(q).T
        for x, q, one in zip(centres, turns, case.bed.particles, strict=True)
    ]
    for i, first in enumerate(case.bed.particles):
        away = np.hypot(spheres[i][:, 0], spheres[i][:, 1]) + first.radii
        assert (away < 0.01).all()
        assert (np.abs(spheres[i][:, 2] - 0.01) + first.radii < 0.01).all()
        for j in range(i):
            gap = np.linalg.norm(spheres[i][:, None] - spheres[j][None], axis=2)
            assert (gap > first.radii[:, None] + case.bed.particles[j].radii[None]).all()


def test_a_run_of_a_mixture_closes_and_its_folder_knows_each_particle(run_of_mixture, tmp_path):
    """Balance at 2 us: four times the 0.5 % of 1 us. Pictures and tables have each particle's own
    spheres, where its quaternion, in single precision, turns them: 10 mm to 1e-8 m."""
    summary, case = results(run_of_mixture), small_mixture()
    assert abs(summary["energy_closure"]) < 0.02
    assert [(kind["count"], kind["sub_spheres"]) for kind in summary["kinds"]] == [
        (12, 1),
        (14, 15),
    ]
    masses = read_trajectory(run_of_mixture.path).static["mass"]
    assert masses.sum() == pytest.approx(summary["mass_kg"], rel=1e-12)
    scene = read_scene(run_of_mixture.path)
    last = len(scene.frame_sample) - 1
    arm, radius, whose = scene.spheres(last)
    assert np.bincount(whose).tolist() == [1] * 12 + [15] * 14
    for n in (3, 12, 25):
        own, turn = case.bed.particles[n], rotation(scene.orientation(last)[n])
        assert arm[whose == n] == pytest.approx(own.offsets @ turn.T, abs=1e-8)
        assert np.array_equal(radius[whose == n], own.radii)
    export(run_of_mixture.path, "csv", tmp_path)
    rows = np.loadtxt(tmp_path / "spheres.csv", delimiter=",", skiprows=1)
    assert (rows[:, 0] == whose).all()
    assert rows[12 + 15 : 12 + 30, 1].tolist() == list(range(15))


@pytest.mark.parametrize("write", [4, 9])
def test_a_run_of_a_mixture_that_is_killed_goes_on_to_the_same_bits(
    run_of_mixture, tmp_path, monkeypatch, write
):
    """Killed at its so many-th write, with a checkpoint every three samples."""
    monkeypatch.setattr(vibration, "CHECKPOINT_WORK", 3 * 26 * 315 + 1)
    shutil.copytree(run_of_mixture.path.parent / "packings", tmp_path / "packings")
    assert forked(lambda: protocol.run(small_mixture(), out=tmp_path), kill_at_write=write) == -9
    protocol.run(small_mixture(), out=tmp_path)
    assert_same_run(the_run(tmp_path), run_of_mixture)
