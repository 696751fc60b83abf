"""Efficiency, shares, closure and response of made-up beds whose results are closed formulas."""

import math

import numpy as np
import pytest
from damper_signals import ALONG, AMPLITUDE, FREQUENCY, OMEGA, PEAK_SPEED, at_rest, pushed

from damper3d.engine.records import CLASSES, MECHANISMS, cut
from damper3d.measures import efficiency, response

MASS, PER_CYCLE = 0.027, 100


def test_a_bed_that_collects_and_collides_twice_a_cycle_has_efficiency_one():
    """All mass meets each end with 2 V and stays: 2 (1/2) M (2 V)^2 a cycle (eq. 6.10)."""
    samples = at_rest()
    hits = np.arange(len(samples["time"])) // (PER_CYCLE // 2)  # so far
    lost = 0.5 * MASS * (2 * PEAK_SPEED) ** 2 * hits
    samples["wall_work"] = samples["friction_particle_particle"] = lost
    reference = efficiency.reference_energy(PEAK_SPEED, MASS)
    found = efficiency.efficiencies(samples, PER_CYCLE, reference)
    assert found.keys() == {"efficiency", "contact_count", "wall_work"}
    np.testing.assert_allclose(found["efficiency"], np.ones(5), rtol=1e-12)
    np.testing.assert_allclose(found["wall_work"], np.ones(5), rtol=1e-12)
    np.testing.assert_allclose(found["contact_count"], np.zeros(5), atol=1e-12)  # no slip_count
    assert efficiency.shares(samples)["particle_particle"]["friction"] == pytest.approx(1.0)


def _budget() -> dict[str, np.ndarray]:
    """A bed that takes 10 J a cycle, keeps 1 J of the first and loses the rest by mechanisms."""
    samples = at_rest()
    cycles = np.arange(len(samples["time"])) / PER_CYCLE
    samples["wall_work"] = 10.0 * cycles
    samples["kinetic"] = np.minimum(cycles, 1.0) * 0.6
    samples["elastic_tangential"] = np.minimum(cycles, 1.0) * 0.4
    parts = dict.fromkeys((f"{m}_{c}" for c in CLASSES for m in MECHANISMS), 1.0)
    parts |= {"friction_particle_particle": 4.0, "friction_particle_wall": 2.0}
    for name, joules in parts.items():
        samples[name] = joules * cycles
    samples["law_term_particle_wall"] = 0.3 * cycles
    samples["slip_count_particle_particle"] = 4.5 * cycles
    samples["slip_count_particle_wall"] = 2.25 * cycles
    return samples


def test_the_budget_separates_lost_from_held_energy_and_from_the_work_of_the_law():
    """lost = wall work - change of what is held; the rest, over the dissipated, is unaccounted."""
    samples = _budget()
    found = efficiency.efficiencies(samples, PER_CYCLE, reference=20.0)
    np.testing.assert_allclose(found["efficiency"], [0.45, 0.5, 0.5, 0.5, 0.5])
    np.testing.assert_allclose(found["wall_work"], 0.5)
    np.testing.assert_allclose(found["contact_count"], (4 + 6.75) / 20.0)
    counted = cut(samples, PER_CYCLE, 1)
    unaccounted, law = efficiency.closure(counted)
    assert law == pytest.approx(0.3 / 10.0)
    assert unaccounted == pytest.approx((10.0 + 0.3 - 10.0) / 10.0)
    shares = efficiency.shares(counted)
    assert shares["particle_particle"] == pytest.approx(
        {"normal_damping": 0.1, "tangential_damping": 0.1, "friction": 0.4}
    )
    assert sum(sum(part.values()) for part in shares.values()) == pytest.approx(1.0)
    as_counted = efficiency.shares_contact_count(counted)
    assert as_counted["particle_wall"] == pytest.approx(
        {"normal_damping": 1 / 10.75, "tangential_damping": 1 / 10.75, "friction": 2.25 / 10.75}
    )
    assert sum(sum(part.values()) for part in as_counted.values()) == pytest.approx(1.0)


def test_nothing_dissipated_has_no_shares_and_no_closure():
    samples = at_rest()
    assert efficiency.closure(samples) == (None, None)
    assert efficiency.shares(samples)["particle_wall"]["friction"] is None
    assert efficiency.shares_contact_count(samples)["particle_wall"]["friction"] is None


def test_cut_takes_whole_cycles_and_refuses_more_than_there_are():
    samples = at_rest()
    last_two = cut(samples, PER_CYCLE, 3)
    assert len(last_two["time"]) == 2 * PER_CYCLE + 1
    assert last_two["time"][0] == samples["time"][3 * PER_CYCLE]
    with pytest.raises(ValueError, match="cycles 4 to 6 of 5"):
        cut(samples, PER_CYCLE, 3, 6)


def test_the_largest_impact_is_that_of_the_counted_cycles_alone():
    """The row before the first counted cycle belongs to the cycle before (eq. 5.26)."""
    samples = at_rest()
    speeds = samples["impact_speed_particle_particle"]
    speeds[3 * PER_CYCLE], speeds[3 * PER_CYCLE + 1] = 9.0, 1.75
    limits = {"particle_particle": 3.5, "particle_wall": 7.0}
    found = efficiency.impact_ratios(cut(samples, PER_CYCLE, 3), limits)
    assert found == {"particle_particle": 0.5, "particle_wall": 0.0}


def test_validity_of_hertz_s_law_is_that_of_the_fastest_counted_impact():
    """(c/v)^(1/5) (eqs 5.11, 5.12), 2 where c = 32 v; none of a class without an impact."""
    samples = at_rest()
    speeds = samples["impact_speed_particle_particle"]
    speeds[3 * PER_CYCLE], speeds[3 * PER_CYCLE + 1] = 9.0, 2.0
    waves = {"particle_particle": 2.0 * 32.0, "particle_wall": 100.0}
    found = efficiency.hertz_validities(cut(samples, PER_CYCLE, 3), waves)
    assert found == {"particle_particle": pytest.approx(2.0, rel=1e-15), "particle_wall": None}


def test_the_part_of_impacts_beyond_yield_is_that_of_the_counted_cycles():
    """Likewise; null without a yield velocity, without an impact, and in samples that lack it."""
    samples = at_rest()
    assert efficiency.impacts_beyond_yield(samples, {}) is None
    begun, beyond = np.zeros((2, len(samples["time"])))
    begun[3 * PER_CYCLE :: 3], beyond[3 * PER_CYCLE :: 6] = 4.0, 1.0
    counts = {"impacts_particle_particle": begun, "impacts_particle_wall": np.zeros_like(begun),
              "impacts_beyond_yield_particle_particle": beyond,
              "impacts_beyond_yield_particle_wall": np.zeros_like(begun)}  # fmt: skip
    counted = cut({**samples, **counts}, PER_CYCLE, 3)
    limits = {"particle_particle": 3.5, "particle_wall": 7.0}
    found = efficiency.impacts_beyond_yield(counted, limits)
    share = beyond[3 * PER_CYCLE + 1 :].sum() / begun[3 * PER_CYCLE + 1 :].sum()
    assert found == {"particle_particle": share, "particle_wall": None}
    unknown = dict.fromkeys(limits)
    assert efficiency.impacts_beyond_yield(counted, unknown) == dict.fromkeys(limits)


# Response. The projection of sampled means is exact for the fundamental, but for rounding and for
# the 200 moments by which the made-up force is averaged: (omega step/200)^2/24 = 4e-9 of it.
CLOSE = 1e-7


def _energy(samples) -> float:
    return float(samples["wall_work"][-1]) / 5


def test_a_mass_fixed_to_the_enclosure_is_its_own_effective_mass_without_loss():
    """F = -M a; a constant weight and harmonics do not show."""
    samples = at_rest()

    def force(t):
        riding = MASS * AMPLITUDE * OMEGA**2 * np.sin(OMEGA * t)
        return riding - 9.81 * MASS + 0.5 * np.cos(3 * OMEGA * t)

    pushed(samples, force)
    found = response.effective_mass(samples, ALONG, OMEGA)
    assert found.real == pytest.approx(MASS, rel=CLOSE)
    assert found.imag == pytest.approx(0.0, abs=CLOSE * MASS)
    assert response.loss_factor(_energy(samples), PEAK_SPEED, MASS) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("steps", [1, 3, 40])
@pytest.mark.parametrize("mass", [MASS, -0.3j, MASS - 0.2j])
def test_forces_at_the_beginnings_of_steps_give_the_mass_exactly(steps, mass):
    """A rigid mass, a dashpot and both, F at t - n dt ... t - dt as the engine sums it.

    Without the half step a rigid mass would have the loss omega dt/2 of it.
    """
    samples = at_rest()
    end = samples["time"][1:]
    dt = (end[1] - end[0]) / steps
    moments = end[:, None] - dt * np.arange(1, steps + 1)
    riding = (mass * OMEGA**2 * AMPLITUDE * np.exp(1j * OMEGA * moments)).imag
    samples["wall_force"][1:, 0] = riding.mean(axis=1)[:, None] * ALONG
    found = response.effective_mass(samples, ALONG, OMEGA, dt)
    assert found == pytest.approx(mass, abs=1e-12)  # rounding
    off = response.effective_mass(samples, ALONG, OMEGA)
    assert abs(off - mass) == pytest.approx(0.5 * OMEGA * dt * abs(mass), rel=0.01)


def test_a_viscous_damper_and_a_mass_have_the_textbooks_loss_factor():
    """F = -M a - c v takes pi c omega X^2 a cycle and has the loss factor c/(M omega)."""
    samples, c = at_rest(), 1.7

    def force(t):
        velocity = PEAK_SPEED * np.cos(OMEGA * t)
        return MASS * OMEGA**2 * AMPLITUDE * np.sin(OMEGA * t) - c * velocity

    pushed(samples, force)
    energy = _energy(samples)
    assert energy == pytest.approx(math.pi * c * OMEGA * AMPLITUDE**2, rel=CLOSE)
    assert response.equivalent_damping(energy, PEAK_SPEED, OMEGA) == pytest.approx(c, rel=CLOSE)
    loss = response.loss_factor(energy, PEAK_SPEED, MASS)
    assert loss == pytest.approx(c / (MASS * OMEGA), rel=CLOSE)
    found = response.effective_mass(samples, ALONG, OMEGA)
    assert found == pytest.approx(MASS - 1j * c / OMEGA, rel=CLOSE)
    assert response.dissipated_power(energy, 1 / FREQUENCY) == pytest.approx(
        0.5 * c * PEAK_SPEED**2, rel=CLOSE
    )


def test_loss_factor_is_four_over_pi_times_the_efficiency():
    """Eqs 2.5 and 6.10 differ by their reference alone."""
    reference = efficiency.reference_energy(PEAK_SPEED, MASS)
    loss = response.loss_factor(0.37 * reference, PEAK_SPEED, MASS)
    assert loss == pytest.approx(4 / math.pi * 0.37)


@pytest.mark.parametrize("tuning", [0.5, 1.0, 3.0])
def test_a_sprung_mass_has_the_absorbers_effective_mass(tuning):
    """M_eff = M (k + j c w)/(k - M w^2 + j c w), below, at and above its resonance."""
    samples, c = at_rest(), 0.8
    k = tuning * MASS * OMEGA**2
    expected = MASS * (k + 1j * c * OMEGA) / (k - MASS * OMEGA**2 + 1j * c * OMEGA)

    def force(t):
        # a is -w^2 X sin(w t), the imaginary part of -w^2 X e^(j w t).
        return (expected * OMEGA**2 * AMPLITUDE * np.exp(1j * OMEGA * t)).imag

    pushed(samples, force)
    found = response.effective_mass(samples, ALONG, OMEGA)
    assert found == pytest.approx(expected, rel=CLOSE)
    energy = math.pi * PEAK_SPEED**2 * -found.imag
    assert energy == pytest.approx(_energy(samples), rel=CLOSE)


def test_peak_force_is_that_on_all_walls_along_the_motion():
    """A sample's mean of a sine near its peak is its sinc below it."""
    samples = at_rest()
    pushed(samples, lambda t: -5.0 * np.sin(OMEGA * t))
    samples["wall_force"][:, 2, 0] = 100.0  # across the motion
    assert response.peak_wall_force(samples, ALONG) == pytest.approx(5.0, rel=1e-3)
    assert response.peak_wall_force(samples, -ALONG) == pytest.approx(5.0, rel=1e-3)


def test_bed_height_is_counted_against_gravity_from_the_lowest_point():
    """A cylinder of radius 20 mm on its side: its lowest point is at x = -20 mm."""
    samples = at_rest()
    samples["mean_position"][:, 0] = -8e-3
    height = response.bed_height(samples, np.array([1.0, 0.0, 0.0]), -20e-3)
    assert height == pytest.approx(12e-3)
