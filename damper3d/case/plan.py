"""Plan of a run: its steps, the CPU time to expect, and warnings."""

import math
from typing import Any

from damper3d.case.case import DamperCase
from damper3d.case.closed_forms import fluidisation_threshold
from damper3d.case.oscillation import DEEPEST
from damper3d.case.parameters import SAFE_SHARE
from damper3d.engine.records import CLASSES

# On one core of a current server, of a particle and step [s] (benchmarks/damper.py and clusters.py;
# the runs that those of several spheres were fitted to stand in docs/damper-shapes.md).
_OF_A_SPHERE = 2.5e-8
_OF_A_PARTICLE, _OF_A_SUB_SPHERE = 1.2e-7, 3.6e-9
_HEAVY = 25e3  # [kg/m3] above osmium and all others
_FAST = 3.0  # peak speed of the enclosure over the yield velocity


def steps_at_most(case: DamperCase) -> int:
    """Number of steps of the motion, at most."""
    run = case.settings.run
    cycles = run.max_cycles if run.steady else run.cycles
    return cycles * case.settings.output.samples * case.steps_per_sample


def expected_cpu_of_step(case: DamperCase) -> float:
    """About what a step of a case costs [s of CPU]: right to a factor of two.

    It goes with the contacts, which shape and motion have a hand in.
    """
    spheres = len(case.particle.radii)
    each = _OF_A_SPHERE if case.particle.is_sphere else _OF_A_PARTICLE + _OF_A_SUB_SPHERE * spheres
    return each * case.count


def expected_cpu_s(case: DamperCase) -> tuple[float, float]:
    """About what filling and motion of a case cost [s of CPU]."""
    cost = expected_cpu_of_step(case)
    filling = case.settings.fill.settle_time / case.steps.free
    return cost * filling, cost * steps_at_most(case)


def warnings(case: DamperCase) -> list[str]:
    """Warnings of what is valid and looks wrong, a line each."""
    found = []
    share = case.time_step / case.steps.limit
    if share > SAFE_SHARE:
        found.append(
            f"the time step is {share:.2f} of the Rayleigh step; above {SAFE_SHARE:g} the energy "
            "may not be right"
        )
    if case.density > _HEAVY:
        found.append(
            f"density {case.density:g} kg/m3: heavier than any metal; 1 g/cm3 is 1000 kg/m3"
        )
    motion, run = case.settings.motion, case.settings.run
    if motion.ramp > run.discard:
        found.append(
            f"the amplitude grows over {motion.ramp:g} cycles and only {run.discard} are left out: "
            "the efficiency is low, as it is taken over the full amplitude; discard as many"
        )
    found += _still_bed_warning(case)
    found += [line for pair in CLASSES for line in _impact_warnings(case, pair)]
    return found


def _still_bed_warning(case: DamperCase) -> list[str]:
    """Warning where gravity or friction keeps a rigid bed where it is in its enclosure."""
    gamma = case.settings.motion.gamma
    if case.orientation not in ("vertical", "horizontal"):
        return []
    threshold = fluidisation_threshold(case.orientation, case.wall_law.mu)
    if gamma > threshold:
        return []
    return [
        f"gamma {gamma:g}: up to {threshold:g} a rigid bed moves with its enclosure; what is "
        "dissipated is little, and may be the bed's own settling"
    ]


def _impact_warnings(case: DamperCase, pair: str) -> list[str]:
    """Warnings where impacts at the enclosure's peak speed are beyond the law."""
    lines, name, limit = [], pair.replace("_", "-"), case.yield_velocity[pair]
    if limit is not None and case.peak_speed > _FAST * limit:
        lines.append(
            f"peak speed {case.peak_speed:.3g} m/s: {case.peak_speed / limit:.1f} times the yield "
            f"velocity of {name}; the restitution would be lower there"
        )
    depth = _hertz_overlap(case, pair) / case.particle.smallest_radius
    if depth > DEEPEST:
        lines.append(
            f"{name} impacts at the peak speed overlap by {depth:.2g} radii; the law holds for "
            "small overlaps: give a higher youngs_modulus or a lower gamma"
        )
    return lines


def _hertz_overlap(case: DamperCase, pair: str) -> float:
    """Largest overlap [m] of an elastic impact at the enclosure's peak speed.

    (5 m v^2/(4 K))^(2/5) with K = law.hertz sqrt(R) and the reduced mass and radius.
    """
    share, law = (0.5, case.pair_law) if pair == CLASSES[0] else (1.0, case.wall_law)
    stiffness = law.hertz * math.sqrt(share * case.particle.smallest_radius)
    return (1.25 * share * case.particle_mass * case.peak_speed**2 / stiffness) ** 0.4


def plan(case: DamperCase) -> dict[str, Any]:
    """Plan of a run for --dry-run: particles, steps, expected CPU time [min]."""
    motion, run = case.settings.motion, case.settings.run
    return {
        "name": case.name,
        "frequency_hz": motion.frequency,
        "gamma": motion.gamma,
        "orientation": case.orientation,
        "particles": case.particle.name,
        "n_particles": case.count,
        "fill_ratio": case.fill_ratio,
        "particle_mass_kg": case.particle_mass,
        "seed": run.seed,
        "cycles": run.max_cycles if run.steady else run.cycles,
        "discarded": run.discard,
        "amplitude_m": case.amplitude,
        "peak_speed_m_s": case.peak_speed,
        "time_step_s": case.time_step,
        "time_step_reason": case.steps.reason,
        "rayleigh_step_s": case.steps.rayleigh,
        "step_limit_s": case.steps.limit,
        "restitution": case.restitution,
        "yield_velocity_m_s": case.yield_velocity,
        "steps": steps_at_most(case),
        "expected_min": sum(expected_cpu_s(case)) / 60,
        "warnings": warnings(case),
    }
