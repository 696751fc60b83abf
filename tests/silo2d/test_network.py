"""Contact network: pairs, coordination, and the tail of the force distribution."""

import dataclasses

import numpy as np
import pytest
import scenes
from hand_built import moment_of, scene_of

from silo2d.case.outline import hopper
from silo2d.measures.basics.contacts import flowing, read_moments, states
from silo2d.measures.network import coordination, exponential_tail, in_words, measure
from silo2d.view.scene import read_scene


def test_tail_of_an_exponential_distribution():
    """P = exp(-f): above the mean the excess is exponential again, beta = 1, and the estimate is
    within three of its standard errors; a scale of the forces changes nothing."""
    force = np.random.default_rng(4).exponential(size=20_000)
    tail = exponential_tail(force)
    assert abs(tail.beta - 1) < 3 * tail.error
    assert 0 < tail.error < tail.beta / np.sqrt(tail.n)  # what a fixed threshold would leave
    assert tail.n == (force > force.mean()).sum()
    assert exponential_tail(1e-3 * force).beta == pytest.approx(tail.beta)


def test_error_of_the_tail_is_the_spread_of_repeats():
    """A hundred and fifty samples of 500 forces: their spread is the error given, to 20 % (both
    have an uncertainty of some 1/sqrt(2 * 150) = 6 %)."""
    chance = np.random.default_rng(5)
    tails = [exponential_tail(chance.exponential(size=500)) for _ in range(150)]
    spread = np.std([tail.beta for tail in tails])
    assert np.mean([tail.error for tail in tails]) == pytest.approx(spread, rel=0.2)


def test_forces_that_pull_and_few_forces_make_no_tail():
    assert exponential_tail(-np.ones(1000)) is None
    assert exponential_tail(np.zeros(0)) is None
    assert exponential_tail(np.array([1.0, 2.0, 9.0])) is None


def test_pairs_add_up_their_contacts():
    """Two contacts of one pair and one with a wall: two pairs, of which the particles touch
    2 and 1 bodies, mean 1.5 of two particles, and 1 of three where one touches nothing."""
    silo = hopper(0.0, 0.1, 0.1, 0.2)
    bodies, normal = [[0, 1], [0, 1], [0, 3]], [[0.0, 1.0], [0.0, 1.0], [1.0, 0.0]]
    force = [[0.5, 2.0], [0.0, 3.0], [-1.0, 0.0]]
    scene = scene_of([scenes.block(0.02, 0.01)], [0, 0, 0], silo, np.zeros(3), np.full(3, 0.1))
    moment = moment_of(
        scene, {"bodies": bodies, "normal": normal, "force": force, "point": np.zeros((3, 2))}
    )
    pairs, pressing = moment.pairs
    assert pairs.tolist() == [[0, 1], [0, 3]]
    assert pressing.tolist() == [5.0, -1.0]
    assert coordination(moment) == pytest.approx(3 / 3)
    assert moment.at_wall.tolist() == [False, False, True]


def test_numbers_of_a_run(reference):
    """Frictionless before the opening: every contact slides; nothing is left at its end."""
    numbers = measure(reference.path)
    assert numbers["before_opening_sliding"] == 1
    assert numbers["before_opening_contacts"] >= numbers["before_opening_pairs"] > 70
    # Frictionless particles at rest need three neighbours a body, fewer where some touch nothing.
    assert 3 < numbers["before_opening_coordination"] < 6
    assert numbers["before_opening_grains"] == read_scene(reference.path).n_particles
    assert len(numbers["series"]["time_s"]) == len(read_moments(reference.path))


def test_frictionless_is_said_of_what_has_no_friction_alone(reference):
    """A bed poured without friction; with a third of each force along it, its contacts slide."""
    before = read_moments(reference.path)[0]
    assert before.slides.all()
    assert in_words(before).endswith("neighbours, frictionless")
    along = np.stack([-before.normal[:, 1], before.normal[:, 0]], axis=1)
    size = np.hypot(*before.force.T)[:, None]
    rubbing = dataclasses.replace(before, force=before.force + 0.3 * size * along)
    assert in_words(rubbing).endswith("neighbours, all contacts slide")


def test_states_of_a_run(reference):
    """Before the opening, and the flow while a tenth to a half of the leavers were out."""
    moments = read_moments(reference.path)
    found = states(moments)
    assert list(found) == ["before_opening", "flow"]
    assert found["before_opening"] == moments[:1]
    first, last = flowing(moments[0].scene)
    assert 0 < first < last
    during = [m for m in moments if first <= m.time <= last]
    assert found["flow"] == during != []
    # With none stored meanwhile it is the one nearest to the middle, and never the first.
    outside = [m for m in moments if m not in during]
    (one,) = states(outside)["flow"]
    middle = (first + last) / 2
    assert abs(one.time - middle) == min(abs(m.time - middle) for m in outside[1:])
    assert "flow" not in states(moments[:1])
