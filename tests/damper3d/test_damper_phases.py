"""Phases of a damper from motions whose phase is known, and the measures behind them."""

import dataclasses
import math

import made_motions as made
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from damper3d.case.random_packing import close_packing
from damper3d.measures.phases.bed_flow import low_density, ring_share, roll_share
from damper3d.measures.phases.bed_motion import collision_phase, contrast
from damper3d.measures.phases.criteria import PHASES, RULES, classify
from damper3d.measures.phases.motion import Motion, clearance
from damper3d.measures.phases.motion_measures import MEANING, measure_motion
from damper3d.measures.phases.particle_motion import near_pairs, neighbour_motion, travel
from granulab.errors import InputError


def phase(motion: Motion) -> str:
    return classify(measure_motion(motion), motion.orientation).name


def test_a_bed_that_sticks_is_solid_like():
    """Thesis, sec. 6.4.2: no relative motion; the floor carries the weight, pi/Gamma of 2 M V."""
    motion = made.sticking()
    measures = measure_motion(motion)
    assert phase(motion) == "solid_like"
    assert measures["carried_share"] == 1.0
    assert measures["neighbours_kept"] == 1.0
    # M g T / (2 M V) = pi/Gamma: exact for the mean of a sine over whole cycles.
    assert measures["low_impulse"] == pytest.approx(math.pi / 0.8, rel=1e-9)


@pytest.mark.parametrize("horizontal", [False, True])
def test_a_bed_that_strikes_both_ends_in_each_cycle_bounces(horizontal):
    """The ideal collect-and-collide (eqs 6.10, 6.11): 2 M V at either end, half a cycle apart."""
    motion = made.bouncing(horizontal)
    measures = measure_motion(motion)
    assert phase(motion) == "bouncing_bed"
    assert measures["low_impulse"] == pytest.approx(1.0)
    assert measures["high_impulse"] == pytest.approx(1.0)
    assert measures["coherence"] == pytest.approx(1.0)
    # The three samples of a collision begin at its phase: their middle is 1.5 % of a cycle later.
    assert measures["low_phase_deg"] == pytest.approx(5.4)
    assert measures["high_phase_deg"] == pytest.approx(185.4)
    # It crosses the clearance, seen from the enclosure, at 100 samples a cycle.
    assert measures["stroke"] == pytest.approx(1.0, abs=0.02)


def test_particles_that_part_and_return_are_fluidised():
    """Thesis, sec. 6.4.3: temporarily lose contacts, then maintain their average position."""
    motion = made.fluidised()
    measures = measure_motion(motion)
    assert phase(motion) == "global_fluidisation"
    assert measures["agitated_share"] > 0.9
    assert measures["travel"] == pytest.approx(0.0, abs=1e-9)  # a cycle later each is back
    assert measures["neighbours_kept"] == 1.0


def test_who_moves_and_returns_is_fluidised_and_who_goes_on_convects():
    """Thesis, sec. 6.4.3: both move against their neighbours; a cycle later one is back."""
    swings, drifts = (measure_motion(m) for m in (made.fluidised(), made.floating_cloud()))
    assert swings["fluidised_share"] == swings["agitated_share"] > 0.9
    assert swings["convecting_share"] == 0.0
    assert drifts["fluidised_share"] == 0.0
    assert drifts["convecting_share"] == drifts["agitated_share"]


def test_the_deepest_layers_lie_along_gravity():
    """One of six layers swings, the highest along z: the deepest fifth (43 of 216) is carried.

    With gravity across, that fifth is a plane of 36 of which 6 swing, and 7 others.
    """
    assert measure_motion(made.fluidised(part=0.3))["deep_carried_share"] == 1.0
    across = measure_motion(made.fluidised(part=0.3, horizontal=True))["deep_carried_share"]
    assert across is not None
    assert 30 / 43 <= across <= 37 / 43
    weightless = dataclasses.replace(made.fluidised(), gravity=np.zeros(3))
    assert measure_motion(weightless)["deep_carried_share"] is None


@pytest.mark.parametrize(
    ("lift", "density"), [(0.0, 1.0), (0.25, 3 * 0.75**2 - 2 * 0.75**3), (0.5, 0.5), (1.0, 0.0)]
)
def test_the_density_at_the_floor_is_that_of_the_caps_below_one_diameter(lift, density):
    """Equal layers, lifted by a part of a diameter: of a sphere 3 s^2 - 2 s^3 is below s of it."""
    bed = made.lattice() + np.array([0.0, 0.0, lift * made.DIAMETER])
    shaken = made.Shaken(gamma=0.8)
    assert low_density(shaken.motion(made.at_rest(shaken, bed))) == pytest.approx(density, abs=1e-9)


def test_fluidisation_of_the_upper_layers_alone_is_local_or_partial():
    """Thesis, secs 6.4.3.3, 6.4.3.4: near the uppermost layers; the deep ones stay as they are."""
    assert phase(made.fluidised(part=0.3)) == "local_fluidisation"
    assert phase(made.fluidised(part=0.3, horizontal=True)) == "partial_fluidisation"
    assert phase(made.fluidised(horizontal=True)) == "fluidisation_convection"


def test_collisions_that_alternate_are_the_transition():
    """Thesis, Fig. 6.19: one collective collision in two cycles, or of different intensity."""
    motion = made.period_two()
    measures = measure_motion(motion)
    assert phase(motion) == "transition"
    assert measures["contrast"] == pytest.approx(0.9 / 1.1)


def test_a_slow_cloud_over_a_hot_layer_is_the_leidenfrost_effect():
    """Thesis, Fig. 6.21: a cloud of slow particles on a few fast ones at the base."""
    motion = made.floating_cloud()
    measures = measure_motion(motion)
    assert phase(motion) == "leidenfrost"
    # The floor's layer, 36 of 216 particles and three times as fast, and 7 or 8 slow ones make the
    # lowest fifth: (36 x 9 + 7.2)/43.2 = 7.7 times the energy of the middle one. Either is a mean
    # of some 120 squares: 13 % of scatter each.
    assert measures["hot_low"] == pytest.approx(7.7, rel=0.35)
    # In the laboratory each goes straight on; the oscillation of the enclosure is not theirs.
    assert measures["travel"] == pytest.approx(1.0)


@pytest.mark.parametrize("kind", ["roll", "ring"])
def test_a_cloud_that_circulates_is_buoyancy_convection(kind):
    """Thesis, Fig. 6.21: circulating motions, as one cell or as a ring about the axis."""
    assert phase(made.rolling(kind)) == "buoyancy_convection"


@pytest.mark.parametrize(("kind", "share"), [("roll", roll_share), ("ring", ring_share)])
def test_a_pure_roll_is_explained_whole(kind, share):
    """By construction; what is lost is of second order in the angle turned, some 0.1."""
    assert share(made.rolling(kind, noise=0.0)) == pytest.approx(1.0, abs=0.02)


def test_random_transport_is_no_roll():
    """Of N independent displacements one field explains chi^2_1/(3 N): far below a tenth."""
    motion = made.floating_cloud()
    assert max(roll_share(motion), ring_share(motion)) < 0.05


def test_independent_particles_that_touch_nothing_are_a_gas():
    """Thesis, sec. 2.5.1: they float without generating contacts."""
    motion = made.gas()
    measures = measure_motion(motion)
    assert phase(motion) == "gas_like"
    assert measures["flight_share"] == 1.0


def test_the_contrast_of_collisions():
    """|b - a|/(b + a): 0 for equal ones, 1/3 for double and single, 1 for every other cycle."""
    assert contrast(np.array([1.0, 1.0, 1.0])) == 0.0
    assert contrast(np.array([2.0, 1.0, 2.0, 1.0])) == pytest.approx(1.0 / 3.0)
    assert contrast(np.array([1.0, 0.0, 1.0])) == 1.0
    assert contrast(np.zeros(4)) == 0.0
    assert contrast(np.array([1.0])) == 0.0  # one counted cycle follows none


def test_a_collision_across_the_end_of_the_cycle_has_its_phase_there():
    """Half before, half after the cycle's end: 0 degrees, not 180."""
    push = np.zeros((2, 100))
    push[:, [0, 99]] = 1.0
    phase_deg = collision_phase(push)
    assert phase_deg is not None
    assert min(phase_deg, 360.0 - phase_deg) < 1e-9


@pytest.mark.parametrize(
    ("fill_ratio", "shape", "free"),
    [
        (0.466, "sphere", 1 - 0.466 / 0.55),
        (0.54, "sphere", 0.5 * (1 - 0.54 / 0.64)),
        (0.66, "prolate:1.5", 0.5 * (1 - 0.66 / close_packing("prolate:1.5").value)),
        (0.66, "sphere", 0.01),
    ],
)
def test_clearance_over_a_loose_packing(fill_ratio, shape, free):
    """Eq. 6.13 with 0.55, but at least half of what close packing leaves, and never none."""
    assert clearance(fill_ratio, 0.04, shape) == pytest.approx(0.04 * free)


def test_independent_neighbours_move_against_each_other_with_their_own_energy():
    """<|v_i - v_j|^2>/2 = <v^2> for independent velocities; 216 particles: 5 % of scatter."""
    shaken, bed = made.Shaken(gamma=3.0), made.lattice()
    rng = np.random.default_rng(7)
    motion = shaken.motion(made.at_rest(shaken, bed))
    motion.v[:] = rng.standard_normal(motion.v.shape) * 0.3 * shaken.peak_speed
    energy, _ = neighbour_motion(motion)
    # 3 components of 0.09 V^2 over the enclosure's V^2/2, whose mean over the frames, with the
    # last one counted as well as the first, is within 1 % of it.
    assert energy.mean() == pytest.approx(3 * 0.09 / 0.5, rel=0.05)


def test_neighbours_are_those_nearer_than_a_fifth_of_a_diameter():
    """Gap below 0.2 diameters, also between particles of different size."""
    x = np.array([[0.0, 0, 0], [1.19, 0, 0], [-1.21, 0, 0], [0, 0.89, 0]])
    i, j = near_pairs(x, np.array([0.5, 0.5, 0.5, 0.25]))
    assert {tuple(sorted(p)) for p in zip(i.tolist(), j.tolist(), strict=True)} == {(0, 1), (0, 3)}


def test_a_bed_that_comes_together_in_each_cycle_does_not_convect():
    """Sec. 6.4.3: convection needs significant decompaction, however far the particles go."""
    shaken, bed = made.Shaken(gamma=3.0), made.lattice(gap=0.1)
    rng = np.random.default_rng(5)
    x = made.drifting(shaken, bed, 0.1 * shaken.peak_speed * rng.standard_normal(bed.shape))
    for horizontal in (False, True):
        assert "fluidisation" in phase(shaken.motion(x, together=0.8, horizontal=horizontal))
        assert "fluidisation" not in phase(shaken.motion(x, together=0.2, horizontal=horizontal))


def test_travel_is_nothing_for_what_is_carried_and_one_for_what_goes_on():
    """In the laboratory: carried particles return in a cycle, free ones do not."""
    shaken, bed = made.Shaken(gamma=10.0), made.lattice(side=2, layers=2)
    np.testing.assert_allclose(travel(shaken.motion(made.at_rest(shaken, bed))), 0.0, atol=1e-9)
    speed = np.tile([0.1, 0.0, 0.0], (len(bed), 1))
    on = travel(shaken.motion(made.drifting(shaken, bed, speed)))
    np.testing.assert_allclose(on, 1.0, rtol=1e-9)


def test_every_measure_is_explained_and_finite():
    measures = measure_motion(made.fluidised())
    assert set(measures) == set(MEANING)
    assert all(value is None or math.isfinite(value) for value in measures.values())


USED = sorted({c.measure for rules in RULES.values() for _, together in rules for c in together})


@given(
    st.fixed_dictionaries({name: st.floats(0.0, 3.0) for name in USED}),
    st.sampled_from(sorted(RULES)),
)
def test_any_measures_have_a_phase_and_its_neighbours_are_across_one_threshold(values, orientation):
    """Moving the named measure across its threshold, and nothing else, makes the next phase."""
    found = classify(values, orientation)
    assert found.name in PHASES[orientation]
    for near in found.neighbours:
        across = near.threshold * (0.999 if near.value >= near.threshold else 1.0)
        assert classify({**values, near.measure: across}, orientation).name == near.phase
    assert [n.distance for n in found.neighbours] == sorted(n.distance for n in found.neighbours)


def test_an_unknown_orientation_is_refused_with_those_there_are():
    with pytest.raises(InputError, match="vertical"):
        classify({}, "diagonal")
