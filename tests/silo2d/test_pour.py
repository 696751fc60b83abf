"""Filling by rain: what goes in, what lies there afterwards, and what it weighs."""

import math

import numpy as np
import pytest
from heaps import (
    assert_filled_to_the_level,
    particle_overlaps,
    silent,
    small_case,
    wall_overlaps,
    weight,
)

from granulab.errors import SimulationError
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.filling import LOOSE
from silo2d.engine import state
from silo2d.run import pour as pour_module
from silo2d.run.pour import level_off, pour, pouring, rain, settle


@pytest.fixture(scope="module")
def case(tmp_path_factory) -> SiloCase:
    return small_case(tmp_path_factory.mktemp("small"))


@pytest.fixture(scope="module")
def packing(case):
    return pour(case, 1, silent)


@pytest.mark.parametrize("silo", ["small", "A1", "D4"])
def test_rain_touches_nothing(case, silo):
    """Bounding circles that keep clear of each other and of the walls; in A1 of a deep hopper."""
    case = case if silo == "small" else SiloCase.load(silo)
    kinds, poses, above = rain(case, np.random.default_rng(3))
    diameter = 2 * case.shapes.bounding_radius
    apart = np.hypot(*(poses[:, None, :2] - poses[None, :, :2]).transpose(2, 0, 1))
    assert apart[~np.eye(len(poses), dtype=bool)].min() > diameter
    high = case.outline.raised(above).walls().segments
    along = high[:, 1] - high[:, 0]
    to_particle = poses[:, None, :2] - high[:, 0]
    across = along[:, 0] * to_particle[..., 1] - along[:, 1] * to_particle[..., 0]
    assert (across / np.linalg.norm(along, axis=1)).min() > diameter / 2
    assert poses[:, 1].max() + diameter / 2 < case.outline.height + above
    areas = np.array([shape.area for shape in case.shapes.shapes])
    needed = LOOSE * case.outline.area_below(case.settings.fill.level)
    # As many particles as make up the area on average: less three standard deviations.
    assert areas[kinds].sum() > needed - 3 * math.sqrt(len(kinds)) * areas.std()


def test_particles_lie_in_the_silo_and_do_not_overlap(case, packing):
    """F = kn overlap: no contact carries more than ten times the weight of all particles."""
    deepest = 10 * weight(case, packing.kinds) / case.pour_laws[0].kn
    assert deepest < 0.02 * case.shapes.shapes[0].spheroradius
    assert wall_overlaps(case, packing.kinds, packing.poses).max() < deepest
    assert particle_overlaps(case, packing.kinds, packing.poses).max() < deepest


def test_floor_and_hopper_carry_the_weight(case, packing):
    """Newton: mean force on the walls = M g + (change of momentum)/time, to rounding.

    The momenta are those of half a step before, as the leapfrog has them. At rest their sum is
    at most M v with v^2 = 2 `settled` g d. Without friction the side walls carry what the
    dashpots of sliding do, m gamma_t v for each of the two corners of a face.
    """
    sim = pouring(case, packing.kinds, packing.poses, case.outline)

    def momentum() -> float:
        return float((sim.rows[:, state.VY] / sim.rows[:, state.INV_MASS]).sum())

    steps = round(0.01 / sim.world.time_step)
    sim.run(steps)
    before, _ = momentum(), sim.wall_forces()
    sim.run(steps)
    forces = sim.wall_forces()[:, 1]
    changed = (momentum() - before) / (steps * sim.world.time_step)
    total = weight(case, packing.kinds)
    assert -forces.sum() == pytest.approx(total + changed, rel=1e-9)
    speed = math.sqrt(2 * case.settings.fill.settled * GRAVITY * math.sqrt(case.shapes.mean_area))
    assert abs(changed) < 2 * speed * (total / GRAVITY) / (steps * sim.world.time_step)
    names = case.outline.walls().names
    sides = [forces[names.index(side)] for side in ("left wall", "right wall")]
    assert np.abs(sides).max() < 2 * case.pour_laws[1].gamma_t * speed * total / GRAVITY


def test_level_is_reached(case, packing):
    """More rained than fits below the level, and what lies above it is taken off."""
    assert len(packing.kinds) < len(rain(case, np.random.default_rng(1))[0])
    assert_filled_to_the_level(case, packing)


def test_same_seed_pours_the_same_bits(case, packing):
    """One order of sums, one generator: nothing may differ but the time it took."""
    again = pour(case, 1, silent)
    np.testing.assert_array_equal(again.kinds, packing.kinds)
    np.testing.assert_array_equal(again.poses, packing.poses)
    assert (again.fraction, again.coordination) == (packing.fraction, packing.coordination)


def test_another_seed_pours_another_packing(case, packing):
    """Other shapes at other angles from the start."""
    other = pour(case, 2, silent)
    assert other.kinds.tolist() != packing.kinds.tolist()


def test_levelling_keeps_what_lies_under_the_level_and_numbers_it_in_rows(case):
    """Rows of one largest particle from the bottom up, from left to right in each."""
    level, height = case.settings.fill.level, 2 * case.shapes.bounding_radius
    rng = np.random.default_rng(5)
    poses = rng.uniform([-0.05, 0, -9], [0.05, 1.5 * level, 9], (200, 3))
    poses[0, 1] = level  # on the level counts as below
    labels = np.arange(200)
    kept, placed = level_off(case, labels, poses)
    assert sorted(kept) == np.flatnonzero(poses[:, 1] <= level).tolist()
    np.testing.assert_array_equal(placed, poses[kept])
    rows = (placed[:, 1] // height).astype(int)
    assert (np.diff(rows) >= 0).all()
    assert (np.diff(placed[:, 0])[np.diff(rows) == 0] >= 0).all()


def test_rain_that_has_just_begun_to_fall_does_not_count_as_settled(tmp_path):
    """Normalised kinetic energy after 5 ms of free fall, (g t)^2/(2 g d): 0.009, as allowed."""
    case = small_case(tmp_path, {"fill.settled": 0.05})
    fractions: list[float] = []
    packing = pour(case, 1, lambda phase, fraction, text: fractions.append(fraction))
    assert_filled_to_the_level(case, packing)
    assert 0 <= min(fractions) <= max(fractions) <= 1


def test_particles_that_do_not_come_to_rest_are_an_error(case, monkeypatch):
    """The message names what was going on and the setting that asks for less."""
    monkeypatch.setattr(pour_module, "_PATIENCE", 0.01)
    kinds, poses, above = rain(case, np.random.default_rng(1))
    sim = pouring(case, kinds, poses, case.outline.raised(above))
    with pytest.raises(SimulationError, match=r"the pouring did not .* \[fill\] settled"):
        settle(sim, case, silent, "pouring")


def test_a_report_can_stop_the_filling(case):
    """What it raises goes through."""

    class Enough(Exception):
        pass

    def stop(phase: str, fraction: float, text: str) -> None:
        assert phase == "pouring"
        assert 0 <= fraction <= 1
        raise Enough

    with pytest.raises(Enough):
        pour(case, 1, stop)
