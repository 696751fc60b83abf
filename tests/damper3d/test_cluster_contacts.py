"""Contacts of clusters: found as by brute force, whatever the lists; energy; several of a pair."""

import math

import numpy as np
import pytest
from cluster_beds import bed, particle, spheres_of, touching, world_of
from damper_beds import DENSITY, acrylic

from damper3d.engine import state
from damper3d.engine.multisphere import contact_models
from damper3d.engine.records import CLASSES, HELD, MECHANISMS
from damper3d.engine.world import empty_contacts, with_capacities
from damper3d.shapes.particle import parse_particle
from damper3d.studies.single_contact.particles import shape_force, shape_shear
from damper3d.studies.single_contact.particles.held import AS_IT_IS, matrix, pressed, sheared
from damper3d.studies.single_contact.particles.smooth_body import Elastic, ellipse
from damper3d.studies.single_contact.particles.steel_shapes import settings, steel

SHAPES = ["prolate:1.5", "toroid:0.2"]
STEPS = 4000


def brute_force(sim, cluster):
    """All (body, sphere, body or wall, sphere) that overlap now, of all pairs of spheres."""
    centres, n, found = spheres_of(sim, cluster), sim.n_particles, set()
    reach = cluster.radii[:, None] + cluster.radii[None, :]
    for i in range(n):
        for j in range(i + 1, n):
            gaps = np.linalg.norm(centres[i][:, None] - centres[j][None], axis=2) - reach
            found |= {(i, p, j, q) for p, q in np.argwhere(gaps < 0.0).tolist()}
    walls = sim.world.walls
    depths = [cluster.radii - (centres @ plane[:3] - plane[3]) for plane in walls.planes]
    if walls.surface.radius > 0.0:
        depths.append(
            cluster.radii - walls.surface.radius + np.hypot(centres[..., 0], centres[..., 1])
        )
    for w, depth in enumerate(depths):
        found |= {(i, p, n + w, 0) for i, p in np.argwhere(depth > 0.0).tolist()}
    return found


@pytest.mark.parametrize("room", ["cylinder", "box"])
@pytest.mark.parametrize("shape", SHAPES)
def test_contacts_are_those_of_a_search_over_all_pairs(shape, room):
    """In vigorous motion, with lists as old as they are."""
    cluster = particle(shape)
    sim = bed(room, cluster, speed=6.0)
    seen, rng = set(), np.random.default_rng(1)
    for _ in range(20):
        sim.step(int(rng.integers(1, 1500)))
        found = touching(sim)
        assert found == brute_force(sim, cluster)
        seen |= found
    assert len({(i, j) for i, _, j, _ in seen}) >= 4  # that were met in the act
    assert sim.world.counts[state.OUTER_SEARCHES] > 3
    assert sim.world.counts[state.INNER_SEARCHES] > 3 * sim.world.counts[state.OUTER_SEARCHES]


def state_after(sim, steps=STEPS):
    sim.step(steps)
    return sim.state_digest(), sim.world.balance.copy()


@pytest.mark.parametrize("treatment", ["sum", "deepest", "scaled"])
def test_no_bit_depends_on_the_lists(treatment):
    """Neither on their skins, put to extremes every 50 steps, nor on their room, which begins with
    next to none: histories go over to the new lists, and springs that hold friction with them."""
    undisturbed = state_after(bed(treatment=treatment))
    for pairs, walls in ((0.001, 0.03), (0.03, 0.001)):
        sim = bed(treatment=treatment)
        for _ in range(STEPS // 50):
            skins = np.array([pairs, walls]) * sim.world.cells.largest
            sim.world.lengths[[state.INNER_SKIN, state.WALL_SKIN]] = skins
            sim.world.counts[[state.STALE_INNER, state.STALE_WALL]] = 1
            sim.step(50)
        digest, books = state_after(sim, 0)
        assert digest == undisturbed[0]
        assert np.array_equal(books, undisturbed[1])
    sim = bed(treatment=treatment)
    sim.world = with_capacities(sim.world, outer=1, inner=9, wall=9)
    assert state_after(sim)[0] == undisturbed[0]


@pytest.mark.parametrize("known", [None, 0, 1, 2])
def test_the_spring_of_a_pair_goes_to_its_deepest_contact(known):
    """Of three contacts of one pair, the second is the deepest; `known` is the one that acted."""
    contacts, spring = empty_contacts(9), np.arange(1.0, 1.0 + state.N_HISTORY)
    listed, depth = np.array([1, 4, 5]), np.array([1e-6, 3e-6, 2e-6])
    contacts.touching[:3] = listed
    if known is not None:
        contacts.history[listed[known]] = spring
    assert contact_models.keep_deepest.py_func(contacts, depth, 0, 3) == listed[1]
    expected = empty_contacts(9).history
    if known is not None:
        expected[listed[1]] = spring
    assert np.array_equal(contacts.history, expected)


@pytest.mark.parametrize("treatment", ["sum", "deepest", "scaled"])
def test_a_state_that_was_put_back_goes_on_to_the_same_bits(treatment):
    sim, other = bed(treatment=treatment), bed(treatment=treatment)
    sim.step(STEPS)
    other.restore(sim.save())
    assert other.state_digest() == sim.state_digest()
    assert state_after(sim, 2000)[0] == state_after(other, 2000)[0]


# Of numbers(bed(...)) below, computed once. A change of the engine that is not meant to change what
# it computes leaves them; one that is meant to puts its own here, and says why.
REFERENCE = {
    ("prolate:1.5", "sum"): [
        -0.000827462538711,
        0.00367369797692,
        0.00557279243902,
        0.698266037882,
        -0.649330533102,
        1.49263444358,
        388.800060836,
        353.747861202,
        121.33747859,
        0.320016793064,
        -1.26204330371,
        -0.333993560056,
        0.282889170968,
        0.000227066775138,
        3.84894489059e-05,
    ],
    ("toroid:0.2", "sum"): [
        -0.000180576522592,
        0.00348925206094,
        0.00674981250727,
        2.14251979428,
        -1.52322418216,
        1.21641868091,
        100.826015654,
        110.029015157,
        9.11279444605,
        0.185500248164,
        -1.05580628333,
        -0.51411672208,
        0.181413350063,
        0.000314933352669,
        0.00016530700751,
    ],
    ("prolate:1.5", "scaled"): [
        -0.000884798959027,
        0.00366893565275,
        0.00562100428269,
        0.543872680365,
        -0.65707725995,
        1.68777770696,
        313.070040313,
        349.223491398,
        110.553836828,
        0.309211909094,
        -1.26314086802,
        -0.332722548707,
        0.294676269804,
        0.000240090235747,
        3.8231346415e-05,
    ],
}


def numbers(sim):
    """Sums over bodies, of which no two count alike; work of the walls and friction [SI]."""
    first, last = sim.sample(), sim.run(1)
    assert float(first["wall_work"][-1]) == 0.0
    now = sim.frame()
    weight = np.cos(np.arange(sim.n_particles))
    sums = [weight @ now[name] for name in ("x", "v", "spin", "orientation")]
    friction = sum(float(last[f"friction_{pair}"][-1]) for pair in CLASSES)
    return [*np.concatenate(sums).tolist(), float(last["wall_work"][-1]), friction]


@pytest.mark.parametrize(("shape", "treatment"), REFERENCE)
def test_a_short_run_is_what_it_was(shape, treatment):
    """1 ms at 1 m/s, before chaos grows: moved by 1e-15 the numbers change by 1e-11 at most, as
    they may on another processor; what a change of the physics changes is far more than 1e-9."""
    found = numbers(bed(cluster=particle(shape), speed=1.0, treatment=treatment,
                        steps_per_sample=1000))  # fmt: skip
    assert found == pytest.approx(REFERENCE[shape, treatment], rel=1e-9), found


@pytest.mark.parametrize("treatment", ["sum", "deepest", "scaled"])
def test_multi_sphere_particles_that_meet_keep_momentum_and_angular_momentum(treatment):
    """Eight that fly together, no walls, no gravity: sum m v and sum (x x m v + L), to rounding.
    Both of a pair get the same force at the same point, and x goes on along v alone, so that no
    step changes either sum."""
    cluster, rng = particle("prolate:3"), np.random.default_rng(8)
    corners = np.array([[a, b, c] for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)], float)
    turns = rng.normal(size=(8, 4))
    places = 0.75 * cluster.bounding_radius * corners + rng.uniform(-1e-4, 1e-4, (8, 3))
    places = 1.5 * places + np.array([0.0, 0.0, 0.5])
    sim = world_of(cluster, places, turns / np.linalg.norm(turns, axis=1)[:, None],
                   treatment=treatment)  # fmt: skip
    sim.set_velocity(-2.0 * corners, 300.0 * rng.uniform(-1.0, 1.0, (8, 3)))
    mass, bodies = DENSITY * cluster.volume, sim.world.particles

    def sums():
        x, v = bodies.position[:, :3], bodies.velocity[:, :3]
        turning = mass * np.cross(x - [0.0, 0.0, 0.5], v) + bodies.momentum[:, :3]
        return mass * v.sum(axis=0), turning.sum(axis=0)

    before, (speed, met) = sums(), (mass * np.abs(bodies.velocity).sum(), 0)
    for _ in range(30):
        sim.step(100)
        met += len(sim.contacts()["overlap"])
    after = sums()
    assert met > 5
    assert bodies.velocity[:, :3] != pytest.approx(-2.0 * corners, abs=0.1)
    assert after[0] == pytest.approx(before[0], abs=1e-12 * speed)
    assert after[1] == pytest.approx(before[1], abs=1e-12 * speed * cluster.bounding_radius)


def left_open(time_step, **options):
    """What the books of 3 ms of vigorous motion leave open, of what was dissipated."""
    sim = bed(time_step=time_step, speed=1.0, steps_per_sample=round(3e-3 / time_step), **options)
    first, last = sim.sample(), sim.run(1)
    change = {name: float(last[name][-1] - first[name][-1]) for name in first
              if first[name].ndim == 1}  # fmt: skip
    lost = sum(change[f"{kind}_{c}"] for c in CLASSES for kind in MECHANISMS)
    gained = change["wall_work"] + sum(change[f"law_term_{c}"] for c in CLASSES)
    return abs(gained - sum(change[name] for name in HELD) - lost) / lost


@pytest.mark.parametrize(("treatment", "most"), [("sum", 0.005), ("scaled", 0.005)])
def test_the_energy_balance_closes_to_second_order(treatment, most):
    """As those of spheres: each halving of the step leaves at most a third open (second order
    would be a quarter), over a few impacts, before chaos makes of each step another bed."""
    errors = [left_open(step, treatment=treatment) for step in (4e-6, 2e-6, 1e-6)]
    assert errors[2] < most
    assert errors[2] < errors[0] / 9


# Several contacts of one pair against the smooth body


def landing(treatment, speed, restitution=1.0):
    """A spheroid a/b = 1.5 of 3.8 mm that lands flat: deepest overlap [m], rebound over speed."""
    cluster, law = particle("prolate:1.5", 3.8e-3), acrylic(0.0, restitution)
    b = cluster.radii.max()
    sim = world_of(cluster, [0.0, 0.0, b + 1e-6], wall_law=law, treatment=treatment,
                   time_step=2e-7)  # fmt: skip
    sim.set_velocity(np.array([[0.0, 0.0, -speed]]), np.zeros((1, 3)))
    deepest = 0.0
    while sim.frame()["v"][0, 2] <= 0.0 or len(sim.contacts()["overlap"]):
        sim.step(5)
        deepest = max(deepest, b - float(sim.frame()["x"][0, 2]))
    return deepest, float(sim.frame()["v"][0, 2]) / speed


def test_stiffness_of_a_landing_spheroid_against_the_smooth_one():
    """Deepest overlap (5 m v^2/(4 K))^(2/5) of a Hertz contact F = K d^1.5, K of the smooth body by
    Johnson's ellipse of contact (test_smooth_body). The deepest sphere has
    the body's radius b across, and not the larger one along: it is softer than the smooth body,
    by 19 % in K at a/b = 1.5. The sum stiffens with the number of spheres that touch."""
    law, cluster = acrylic(0.0, 1.0), particle("prolate:1.5", 3.8e-3)
    b, mass = cluster.radii.max(), DENSITY * cluster.volume
    smooth = ellipse(Elastic(3.3e9, 0.37), 1.5**2 * b, b).hertz
    sphere = law.hertz * math.sqrt(b)

    def stiffness(treatment, speed):
        return 1.25 * mass * speed**2 / landing(treatment, speed)[0] ** 2.5 / smooth

    alone = sphere / smooth
    assert alone == pytest.approx(0.805, abs=0.005)
    for speed in (0.1, 1.5):
        assert stiffness("deepest", speed) == pytest.approx(alone, rel=0.01)
    assert alone < stiffness("scaled", 1.5) < 1.25 * alone
    assert stiffness("sum", 1.5) > 2.0
    assert stiffness("sum", 0.1) < stiffness("sum", 1.5)


def test_restitution_of_a_landing_spheroid():
    """One contact has the restitution that its law is made for, 0.86; n in parallel that share no
    mass are damped by the root of n times as much, and so rebound less the faster they land."""
    assert landing("deepest", 1.5, 0.86)[1] == pytest.approx(0.86, abs=2e-3)
    assert landing("scaled", 1.5, 0.86)[1] == pytest.approx(0.86, abs=0.01)
    slow, fast = (landing("sum", speed, 0.86)[1] for speed in (0.1, 1.5))
    assert 0.86 > slow > fast > 0.5


@pytest.mark.parametrize("shape", ["prolate:1.5", "prolate:3"])
def test_the_step_that_impacts_need_does_not_go_with_the_smallest_sphere(shape):
    """Elastic impacts on a wall, without friction, of 25 bodies turned at random, 0.8 m/s: what 1
    us leaves open of the energy is at most 3e-4 of it and falls with the square of the step, for
    tips of 2.2 mm as for those of 0.9 mm (of whose Rayleigh step 1 us is a third)."""
    cluster, rng = particle(shape, 3.8e-3), np.random.default_rng(3)
    turns = rng.normal(size=(25, 4))
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    x, y = (grid.ravel() for grid in np.meshgrid(*[0.05 * np.arange(-2, 3)] * 2))
    height = np.full(25, cluster.bounding_radius + 1e-5)
    law, mass = acrylic(0.0, 1.0), DENSITY * cluster.volume

    def left_open(step):
        sim = world_of(cluster, np.column_stack([x, y, height]), turns, wall_law=law,
                       time_step=step)  # fmt: skip
        sim.set_velocity(np.tile([0.0, 0.0, -0.8], (25, 1)), np.zeros((25, 3)))
        sim.step(round((cluster.bounding_radius + 1e-3) / 0.8 / step))
        now, momentum = sim.frame(), sim.world.particles.momentum_now[:, :3]
        energy = 0.5 * mass * (now["v"] ** 2).sum(axis=1) + 0.5 * (momentum * now["spin"]).sum(1)
        return np.abs(energy / (0.5 * mass * 0.64) - 1.0)

    errors = [left_open(step).max() for step in (2e-6, 1e-6)]
    assert errors[1] < 3e-4
    assert errors[1] < errors[0] / 3


# Single particles that are held and pressed


def test_pressed_row_is_the_sum_of_its_spheres():
    """The lying prolate of Fig. 5.8 with 51 sub-spheres: each gives K sqrt(R) d^1.5 for what it is
    deep (eq. 5.7), and shifted by s each gives kt s up to mu of that (eqs 5.15, 5.16). The last
    half of a step of s is the engine's leapfrog. To rounding."""
    prolate, (_, law) = parse_particle("prolate:2", 3.78e-3, sub_spheres=51), steel()
    overlaps = np.array([1e-6, 4e-6, 12e-6])
    depth = (overlaps[:, None] - prolate.radii.max() + prolate.radii).clip(0.0)
    each = law.hertz * np.sqrt(prolate.radii) * depth**1.5
    assert (depth > 0.0).sum(axis=1).tolist() == [1, 3, 5]
    found = pressed(prolate, AS_IT_IS, overlaps, law, "sum")
    assert found == pytest.approx(each.sum(axis=1), rel=1e-6)
    deepest = pressed(prolate, AS_IT_IS, overlaps, law, "deepest")
    assert deepest == pytest.approx(each.max(axis=1), rel=1e-6)
    scaled = pressed(prolate, AS_IT_IS, overlaps, law, "scaled")
    energy = 0.4 * each * depth
    together = (energy**8).sum(axis=1) ** (1 / 8)
    shares = (energy / together[:, None]) ** 7
    assert scaled == pytest.approx((shares * each).sum(axis=1), rel=1e-6)
    across, tangential = sheared(prolate, AS_IT_IS, 4e-6, 3e-6, 6, law, "sum")
    stiffness = law.tangential * law.hertz * np.sqrt(prolate.radii * depth[1])
    wanted = np.minimum(stiffness * across[:, None], law.mu * each[1]).sum(axis=1)
    assert tangential == pytest.approx(wanted, rel=1e-6)


def test_sheared_oblate_under_the_normal_force_of_the_smooth_one(monkeypatch):
    """Figs 5.6b, 5.8b: under one force a round contact's radius, and with it kt = 8 G* a, goes with
    the cube root of the body's radius, and F/d^1.5 with its root (eqs 5.7, 5.15): one sub-sphere's
    kt is that of F/d^1.5 to the power 2/3. All treatments slide at mu N in the end."""
    way = shape_shear.ways()[0]
    only = way.setting._replace(finenesses=way.setting.finenesses[:1])
    monkeypatch.setattr(shape_shear, "ways", lambda: [way._replace(setting=only)])
    found = shape_shear.compute()
    (name,) = (key for key in found.numbers if key != "friction")
    numbers, (_, law) = found.numbers[name], steel()
    cluster = only.clusters()[0]
    overlap = shape_shear.overlap_under(
        cluster, way.orientation, law, "sum", numbers["normal_force_n"]
    )
    held = pressed(cluster, way.orientation, np.array([overlap]), law, "sum")
    assert held[0] == pytest.approx(numbers["normal_force_n"], rel=1e-6)
    lowest = np.argmin((cluster.offsets @ matrix(way.orientation)[2]) - cluster.radii)
    radius = 1.5e-3**2 / 1.4e-3
    ratio = (cluster.radii[lowest] / radius) ** (1 / 3)
    assert numbers["deepest_stiffness_over_smooth"] == pytest.approx(ratio, rel=1e-4)
    assert numbers["sum_stiffness_over_smooth"] > numbers["scaled_stiffness_over_smooth"] > ratio
    limit = law.mu * numbers["normal_force_n"]
    last = max(row["displacement_m"] for row in found.rows)
    ends = [row["force_n"] for row in found.rows if row["displacement_m"] == last]
    assert ends == pytest.approx([limit] * 3, rel=1e-4)


def test_force_of_a_lying_toroid_passes_that_of_the_smooth_one(monkeypatch):
    """Figs 5.10, 5.13: at small overlaps n sub-spheres are softer than the line of contact, at
    large ones stiffer, and the more the larger n; below a third of eq. 5.19's limit already."""
    lying = next(setting for setting in settings() if setting.key == "toroid lying")
    monkeypatch.setattr(shape_force, "settings", lambda: [lying])
    numbers = shape_force.compute().numbers
    fifty = numbers["toroid lying, 50"]
    assert fifty["sum_over_smooth_at_tenth"] < 1.0 < fifty["sum_over_smooth"]
    assert fifty["sum_exceeds_smooth_from_m"] == pytest.approx(4.98e-6, rel=0.01)
    assert fifty["groove_depth_m"] > 3.0 * fifty["sum_exceeds_smooth_from_m"]
    ratio = numbers["toroid lying, 100"]["sum_over_smooth"] / fifty["sum_over_smooth"]
    assert ratio == pytest.approx(2.0, rel=1e-6)
    assert numbers["toroid lying, 10"]["sum_exceeds_smooth_from_m"] is None
    assert fifty["deepest_over_smooth"] < fifty["scaled_over_smooth"] < 0.1
