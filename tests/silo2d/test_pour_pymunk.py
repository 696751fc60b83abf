"""Filling with pymunk: the heap it leaves, what the contact law makes of it, and its errors."""

import math

import numpy as np
import pytest
from heaps import (
    assert_filled_to_the_level,
    particle_overlaps,
    silent,
    small_case,
    solid_fraction,
    wall_overlaps,
    weight,
)

from granulab.errors import SimulationError
from silo2d.baseline import pouring as pour_pymunk
from silo2d.baseline.pouring import SKIN, fall, pour_with_pymunk
from silo2d.case.case import SiloCase
from silo2d.run.pour import pour, rain


@pytest.fixture(scope="module")
def case(tmp_path_factory) -> SiloCase:
    return small_case(tmp_path_factory.mktemp("small"))


@pytest.fixture(scope="module")
def packings(case):
    return [pour_with_pymunk(case, seed, silent) for seed in range(1, 7)]


def test_pymunk_leaves_overlaps_less_deep_than_a_skin():
    """In a heap as high as the paper's. The law can undo five skins at a wall, ten elsewhere.

    Seeds 1 to 4 of A4, C4, D4 and A1 left at most 0.07 mm at a wall and none between particles.
    """
    case = SiloCase.load("A4")
    kinds, poses, above = rain(case, np.random.default_rng(1))
    heap = fall(case, kinds, poses, case.outline.raised(above), silent)
    skin = SKIN * case.shapes.shapes[0].spheroradius
    assert wall_overlaps(case, kinds, heap).max() < skin
    assert particle_overlaps(case, kinds, heap).max(initial=0.0) < skin
    # It has fallen: even as loose as 0.75 it would not reach higher.
    areas = np.array([shape.area for shape in case.shapes.shapes])[kinds]
    assert case.outline.area_below(heap[:, 1].max()) < areas.sum() / 0.75


def test_particles_lie_in_the_silo_and_do_not_overlap(case, packings):
    """F = kn overlap: no contact carries more than ten times the weight of all particles."""
    for packing in packings:
        deepest = 10 * weight(case, packing.kinds) / case.pour_laws[0].kn
        assert wall_overlaps(case, packing.kinds, packing.poses).max() < deepest
        assert particle_overlaps(case, packing.kinds, packing.poses).max() < deepest
        assert packing.poured_with == "pymunk"


def test_level_is_reached(case, packings):
    """Under the law the heap sinks by what was left of the skins, and is levelled after that."""
    for packing in packings:
        assert_filled_to_the_level(case, packing)


def test_same_seed_pours_the_same_bits(case, packings):
    """pymunk is serial: nothing may differ but the time it took."""
    again = pour_with_pymunk(case, 1, silent)
    np.testing.assert_array_equal(again.kinds, packings[0].kinds)
    np.testing.assert_array_equal(again.poses, packings[0].poses)


def test_packs_as_densely_as_the_rain_under_the_contact_law(case, packings):
    """Both ways lead to a frictionless heap at rest.

    24 fillings each of this silo spread by 0.010 about 0.858 and 0.854; the means of six agree
    within three standard errors of their difference. With its skins a heap would be 0.02 looser.
    """
    ours = np.mean([solid_fraction(case, packing) for packing in packings])
    seeds = range(1, len(packings) + 1)
    law = np.mean([solid_fraction(case, pour(case, seed, silent)) for seed in seeds])
    assert ours == pytest.approx(law, abs=3 * 0.010 * math.sqrt(2 / len(packings)))


def test_particles_outside_the_silo_are_an_error(case):
    """They would fall for ever; the message says what to do instead."""
    kinds, poses, above = rain(case, np.random.default_rng(1))
    poses[7, 0] += case.outline.width
    with pytest.raises(SimulationError, match=rf"lost 1 of {len(kinds)} .* pour_with = 'dem'"):
        fall(case, kinds, poses, case.outline.raised(above), silent)


def test_a_heap_that_does_not_calm_is_an_error(case, monkeypatch):
    """The time is limited."""
    monkeypatch.setattr(pour_pymunk, "_PATIENCE", 0.01)
    with pytest.raises(SimulationError, match=r"did not calm within 0\.01 s"):
        pour_with_pymunk(case, 1, silent)


def test_a_report_can_stop_the_filling_in_every_phase(case):
    """What it raises goes through; the phases come in this order."""

    class Enough(Exception):
        pass

    seen: list[str] = []

    def note(phase: str, fraction: float, text: str) -> None:
        assert 0 <= fraction <= 1
        if phase not in seen:
            seen.append(phase)
            raise Enough

    for phase in ("pouring", "relaxing"):
        with pytest.raises(Enough):
            pour_with_pymunk(case, 1, note)
        assert seen[-1] == phase
