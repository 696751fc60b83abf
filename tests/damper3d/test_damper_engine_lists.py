"""Lists of neighbours: they miss no contact, and no bit depends on when they are made."""

import numpy as np
import pytest
from damper_beds import DOWN, LARGEST, NOWHERE, STILL, acrylic, bed, lone

from damper3d.engine import state
from damper3d.engine.motions import Sines
from damper3d.engine.world import with_capacities

SHAPES = ["cylinder", "box"]


def brute_force(sim):
    """All pairs of particles, and particles and walls, that overlap now: a search in O(n^2)."""
    x, walls, n = sim.frame()["x"], sim.world.walls, sim.n_particles
    radius = sim.world.spheres.position[:n, 3]
    i, j = np.triu_indices(n, 1)
    touching = np.linalg.norm(x[j] - x[i], axis=1) < radius[i] + radius[j]
    pairs = set(zip(i[touching].tolist(), j[touching].tolist(), strict=True))
    depths = [radius - (x @ plane[:3] - plane[3]) for plane in walls.planes]
    if walls.surface.radius > 0.0:
        depths.append(radius - (walls.surface.radius - np.hypot(x[:, 0], x[:, 1])))
    for w, depth in enumerate(depths):
        pairs |= {(k, n + w) for k in np.flatnonzero(depth > 0.0).tolist()}
    return pairs


@pytest.mark.parametrize("smallest", [1.0, 0.6])
@pytest.mark.parametrize("shape", SHAPES)
def test_contacts_are_those_of_a_search_over_all_pairs(shape, smallest):
    """Equal and unequal spheres, from the violent start on; the lists are as old as they are."""
    sim = bed(shape, smallest=smallest, speed=1.0)
    seen, rng = set(), np.random.default_rng(1)
    for _ in range(120):
        sim.step(int(rng.integers(1, 400)))
        found = [tuple(pair) for pair in sim.contacts()["bodies"].tolist()]
        assert len(found) == len(set(found))
        assert set(found) == brute_force(sim)
        seen |= set(found)
    assert len(seen) > sim.n_particles  # pairs that have met, of those seen
    assert {w for _, w in seen} >= {sim.n_particles, sim.n_particles + 2}
    assert sim.world.counts[state.OUTER_SEARCHES] > 10  # the near list was made anew many times
    assert sim.world.counts[state.INNER_SEARCHES] > 3 * sim.world.counts[state.OUTER_SEARCHES]


def undisturbed(shape, steps):
    sim = bed(shape)
    sim.step(steps)
    return sim.state_digest(), sim.world.balance.copy()


STEPS = 9000  # most of a cycle, with hundreds of lists


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize(("pairs", "walls"), [(0.002, 0.03), (0.03, 0.002), (0.02, 0.02)])
def test_no_bit_depends_on_the_skin(shape, pairs, walls):
    """Skins over the largest radius; they are put back to that every 50 steps, because they adapt.
    The sums of the books go in the order of the lists, which is that of the spheres' numbers."""
    sim = bed(shape)
    for _ in range(STEPS // 50):
        sim.world.lengths[[state.INNER_SKIN, state.WALL_SKIN]] = (
            np.array([pairs, walls]) * sim.world.cells.largest
        )
        sim.world.counts[[state.STALE_INNER, state.STALE_WALL]] = 1  # made with the new skin
        sim.step(50)
    digest, books = undisturbed(shape, STEPS)
    assert sim.state_digest() == digest
    assert np.array_equal(sim.world.balance, books)


def test_no_bit_depends_on_when_the_curvature_of_a_conical_wall_was_seen():
    """It is that of the place where a sphere is now, not of where it was when it was listed."""
    digests = []
    for often, curved in ((False, True), (True, True), (False, False)):
        sim = bed("frustum", speed=1.0)
        sim.world = sim.world._replace(walls=sim.world.walls._replace(curved=curved))
        for _ in range(60):
            sim.world.counts[state.STALE_WALL] |= often
            sim.step(50)
        digests.append(sim.state_digest())
    assert digests[0] == digests[1] != digests[2]


@pytest.mark.parametrize("pairs", [0.002, 0.03])
def test_no_bit_of_a_packed_bed_depends_on_the_skin(pairs):
    """Where most pairs of the list touch, those that do not are not looked for."""
    settled = bed(shaker=STILL, speed=0.0, smallest=1.0)
    settled.step(200_000)
    saved, sims = settled.save(), [bed(shaker=STILL) for _ in range(2)]
    for sim in sims:
        sim.restore(saved)
    for _ in range(40):
        sims[0].world.lengths[state.INNER_SKIN] = pairs * LARGEST
        sims[0].world.counts[state.STALE_INNER] = 1
        for sim in sims:
            sim.step(50)
    assert sims[1].world.packed.all()
    assert sims[0].state_digest() == sims[1].state_digest()
    assert np.array_equal(sims[0].world.balance, sims[1].world.balance)
    assert sims[1].world.balance.any()


def test_cells_are_a_few_a_sphere_however_large_the_room():
    """A sphere of 2.5 mm in a room of a metre: five million cells of its size."""
    assert np.prod(lone(acrylic(), height=0.5).world.cells.shape) < 1010


def test_no_bit_depends_on_samples_or_on_who_looks():
    digest, books = undisturbed("cylinder", STEPS)
    for steps_per_sample in (45, 1000, STEPS):
        sim = bed(steps_per_sample=steps_per_sample)
        sim.run(STEPS // steps_per_sample)
        assert sim.state_digest() == digest
        assert np.array_equal(sim.world.balance, books)
    sim, rng = bed(), np.random.default_rng(2)
    while sim.steps < STEPS:
        sim.contacts(), sim.sample(), sim.frame(), sim.save()
        sim.step(min(int(rng.integers(1, 400)), STEPS - sim.steps))
    assert sim.state_digest() == digest
    assert np.array_equal(sim.world.balance, books)


@pytest.mark.parametrize("shape", SHAPES)
def test_a_restored_bed_goes_on_with_the_same_bits(shape):
    """Saved and put into a new simulation, or the same one, at random moments, some right after
    each other; every fourth save is of a state that was just restored."""
    digest, books = undisturbed(shape, STEPS)
    sim, rng = bed(shape), np.random.default_rng(3)
    for k in range(60):
        saved = sim.save()
        if k % 2:
            sim = bed(shape, gravity=DOWN)
        sim.restore(saved)
        if k % 4 == 0:
            again = sim.save()
            assert all(np.array_equal(again[name], saved[name]) for name in saved)
        sim.step(min(int(rng.integers(0, 300)), STEPS - sim.steps))
    sim.step(STEPS - sim.steps)
    assert sim.state_digest() == digest
    assert np.array_equal(sim.world.balance, books)
    heat = sim.frame()["heat"]
    assert (heat > 0.0).any()


@pytest.mark.parametrize("wall", [-1.0, 1.0])
def test_a_wall_that_comes_to_a_sphere_at_rest_meets_it(wall):
    """The list of wall contacts is of places in the enclosure: floor or lid, at 1 m/s, strike a
    sphere that has never moved, and part from it at e times that. Tolerance: 1/40, the inverse of
    the steps of a contact."""
    slow = 1e-5  # so that the sine is a uniform motion
    uniform = Sines(np.array([-wall / slow]), np.array([slow]), np.zeros(1), 0.0)
    height = 3 * LARGEST if wall < 0.0 else 1.0 - 3 * LARGEST
    sim = lone(acrylic(), height=height, gravity=NOWHERE, shaker=uniform)
    sim.step(round(2.5 * LARGEST / 1e-6))
    assert sim.frame()["v"][0, 2] == pytest.approx(-1.86 * wall, rel=1 / 40)


def test_lists_without_capacity_are_made_longer_and_change_no_bit():
    """A bed whose lists begin with room for one contact each."""
    digest, books = undisturbed("box", STEPS)
    sim = bed("box")
    sim.world = with_capacities(sim.world, outer=1, inner=1, wall=1)
    sim.step(STEPS)
    assert sim.state_digest() == digest
    assert np.array_equal(sim.world.balance, books)
