"""What a person reads before and after a run."""

import math
from typing import Any

import numpy as np

from contact.hertz import HertzLaw
from damper3d.case import DamperCase
from damper3d.clusters.swing import DEEPEST
from damper3d.parameters import SAFE_SHARE
from damper3d.predict.theory import fluidisation_threshold
from damper3d.records import CLASSES
from damper3d.result import Result

_SECONDS_PER_BALL_STEP = 2.5e-8  # on one core of a current server
_SECONDS_PER_CLUSTER_STEP = 3e-7  # likewise, of some 50 sub-spheres
_UNSTEADY = 0.1  # of the efficiency, by which the walls' work may differ without a word
_COARSE = 0.005  # closed at 1 us, relative to what is dissipated
_HEAVY = 25e3  # [kg/m3] above osmium and all others
_FAST = 3.0  # peak speed of the enclosure over the yield velocity
_MOST_CYCLES = 12  # that are told one by one


def echo(case: DamperCase, dry_run: bool) -> str:
    """The case in SI, the time step with its reason, restitutions, and what looks wrong."""
    settings, particle, steps = case.settings, case.particle, case.steps
    lines = [
        f"{case.name}, seed {settings.run.seed}",
        f"  enclosure   {_enclosure(case)}",
        f"  particles   {case.count} of {particle.name}: radius {particle.equal_volume_radius:g} "
        f"m, {case.particle_mass:.4g} kg each, {case.mass:.4g} kg together, fill ratio "
        f"{case.fill_ratio:.3f}",
        *_motion(case),
        _law("particles", case.pair_law, case.restitution[CLASSES[0]]),
        _law("walls", case.wall_law, case.restitution[CLASSES[1]]),
        f"  contact     {_contact(case)}",
        f"  yield       {_yield(case)}",
        f"  filling     settled for {settings.fill.settle_time:g} s under gravity "
        f"{_vector(case.settling_gravity)} m/s2, in steps of {steps.free:.4g} s",
        f"  time step   {case.time_step:.6g} s: {steps.reason};",
        f"              {steps.per_sample} a sample, {settings.output.samples} samples a cycle",
        f"  ends        {_end(case)}",
    ]
    if dry_run:
        filling, motion = expected_cpu_s(case)
        lines.append(
            f"  expected    about {_minutes(filling + motion)} min of CPU, {_minutes(filling)} of "
            "them for a packing that is not there yet"
        )
    return "\n".join([*lines, *(f"  warning     {line}" for line in warnings(case))])


def _enclosure(case: DamperCase) -> str:
    own = case.enclosure
    if own.radius is not None:
        return f"cylinder, {own.width:g} m in diameter, {own.height:g} m high"
    return f"box, {own.width:g} m (x) by {own.depth:g} m (y), {own.height:g} m high"


def _motion(case: DamperCase) -> list[str]:
    motion = case.settings.motion
    ramp = f", growing over {motion.ramp:g} cycles" if motion.ramp else ""
    return [
        f"  motion      {case.orientation}, {motion.frequency:g} Hz, gamma {motion.gamma:g}: "
        f"amplitude {case.amplitude:.4g} m, peak speed {case.peak_speed:.4g} m/s{ramp};",
        f"              along {_vector(case.direction)}, gravity {_vector(case.gravity)} m/s2",
    ]


def _vector(vector: np.ndarray) -> str:
    return f"({', '.join(f'{x + 0.0:.4g}' for x in vector)})"


def _law(name: str, law: HertzLaw, restitution: float) -> str:
    return (
        f"  law {name:9} 4/3 E {law.hertz:.4g} Pa, kt/kn {law.tangential:.4g}, mu {law.mu:g}, "
        f"restitution {restitution:g}"
    )


def _contact(case: DamperCase) -> str:
    law = case.settings.law
    end = "ends at zero overlap, with just this restitution"
    if law.contact_end == "force":
        end = "ends at zero force, with a slightly higher restitution"
    side = "the side's curvature counts" if law.wall_curvature else "walls are flat to it"
    return f"{end}; the spring carries its {law.tangential}; {side}"


def _yield(case: DamperCase) -> str:
    parts = [
        f"{pair.replace('_', '-')} " + ("not known" if v is None else f"{v:.3g} m/s")
        for pair, v in case.yield_velocity.items()
    ]
    above = "falls above it" if case.settings.law.yielding else "does not depend on it"
    return f"{', '.join(parts)} (thesis, eq. 5.26); restitution {above}"


def _end(case: DamperCase) -> str:
    run = case.settings.run
    if run.steady:
        return (
            f"when steady, {min(run.cycles, run.max_cycles)} cycles at least, the first "
            f"{run.discard} left out, and {run.max_cycles} cycles at most"
        )
    return (
        f"after {run.cycles} cycles of {case.period:.4g} s, the last {run.cycles - run.discard} "
        f"count; {steps_at_most(case):,} steps"
    )


def _minutes(seconds: float) -> str:
    minutes = max(seconds / 60, 0.1)
    return f"{minutes:.1g}" if minutes < 1 else f"{minutes:,.0f}"


def steps_at_most(case: DamperCase) -> int:
    """Of the motion."""
    run = case.settings.run
    cycles = run.max_cycles if run.steady else run.cycles
    return cycles * case.settings.output.samples * case.steps_per_sample


def expected_cpu_s(case: DamperCase) -> tuple[float, float]:
    """About what filling and motion of a case cost [s of CPU]."""
    each = _SECONDS_PER_BALL_STEP if case.particle.is_ball else _SECONDS_PER_CLUSTER_STEP
    cost = each * case.count
    filling = case.settings.fill.settle_time / case.steps.free
    return cost * filling, cost * steps_at_most(case)


def warnings(case: DamperCase) -> list[str]:
    """What is valid and looks wrong, a line each."""
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
    """Whether gravity or friction keeps a rigid bed where it is in its enclosure."""
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
    """Whether impacts at the enclosure's peak speed are within the law."""
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
    """What a run of a case would be: particles, steps, expected CPU time [min]."""
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


def report(result: Result) -> str:
    """The answers of a run."""
    lines = [
        f"{result.n_particles} of {result.particles}, {result.orientation}, "
        f"{result.frequency_hz:g} Hz, gamma {result.gamma:g}, seed {result.seed}: efficiency "
        f"{result.efficiency:.3f}{_interval(result.efficiency_interval)}",
        f"  cycles           {_cycles(result)}",
        f"  by other counts  {result.efficiency_contact_count:.3f} as the thesis counts, "
        f"{result.efficiency_wall_work:.3f} from the work of the walls",
        *_own_energy(result),
        *_shares(result),
        f"  design           {result.dissipated_power_w:.4g} W dissipated, loss factor "
        f"{_number(result.loss_factor)}, like a damper of "
        f"{_number(result.equivalent_damping_n_s_per_m)} N s/m;",
        f"                   effective mass {_effective_mass(result)}, of {result.mass_kg:.4g} kg",
        f"  motion           {result.phase or 'phase not told'}; bed's centre of mass "
        f"{_number(result.bed_height_m)} m up; largest force on the enclosure "
        f"{result.peak_wall_force_n:.4g} N",
        f"  impacts          largest over the yield velocity: {_impacts(result)}",
        f"  energy           {_books(result)}",
        f"  cost             {result.cpu_us_per_step:.1f} us of CPU a step, {result.steps:,} "
        f"steps of {result.time_step_s:.4g} s; {result.cpu_s:.1f} s in all",
        f"  run folder       {result.run_folder}{' (computed before)' if result.reused else ''}",
    ]
    return "\n".join(lines)


def _own_energy(result: Result) -> list[str]:
    """A line where much of what is dissipated is not the shaker's work."""
    own = result.efficiency - result.efficiency_wall_work
    if not abs(own) > _UNSTEADY * abs(result.efficiency):
        return []
    whence = "the bed gives itself (it sinks or slows down)" if own > 0 else "the bed takes up"
    return [f"                   they differ by what {whence}: go on until it is steady (--steady)"]


def _interval(interval: tuple[float, float] | None) -> str:
    return "" if interval is None else f" (95 %: {interval[0]:.3f} to {interval[1]:.3f})"


def _cycles(result: Result) -> str:
    """The efficiency of each cycle, a bar before the first that counts."""
    each = [f"{eta:.3f}" for eta in result.efficiency_per_cycle]
    left_out, counted = each[: result.discarded], each[result.discarded :]
    if len(each) > _MOST_CYCLES:
        return (
            f"the last {len(counted)} of {len(each)} count, {min(counted)} to {max(counted)}"
            f"{_steady(result)}"
        )
    return f"{' '.join([*left_out, '|', *counted])} (counted from the bar on){_steady(result)}"


def _packing(packing: dict[str, float]) -> str:
    return (
        f"packing fraction {packing['fraction']:.3f}, {packing['coordination']:.1f} contacts a "
        f"particle, {packing['height_m']:.4g} m high, {packing['rms_speed_m_s']:.2g} m/s left"
    )


def _steady(result: Result) -> str:
    if result.steady is None:
        return ""
    return "; steady" if result.steady else "; not steady"


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.4g}"


def _shares(result: Result) -> list[str]:
    """What part of the dissipated energy each mechanism takes, a line for each pair."""
    return [
        f"  {pair.replace('_', '-'):16} "
        + ", ".join(
            f"{mechanism.replace('_', ' ')} {'none' if share is None else f'{share:.1%}'}"
            for mechanism, share in mechanisms.items()
        )
        for pair, mechanisms in result.shares.items()
    ]


def _effective_mass(result: Result) -> str:
    mass = result.effective_mass
    return (
        f"{_number(mass.get('in_phase_kg'))} kg in phase, "
        f"{_number(mass.get('out_of_phase_kg'))} kg out of phase"
    )


def _impacts(result: Result) -> str:
    ratios = result.max_impact_over_yield_velocity
    return ", ".join(f"{pair.replace('_', '-')} {_number(r)}" for pair, r in ratios.items())


def _books(result: Result) -> str:
    if result.energy_closure is None:
        return "nothing dissipated"
    closure = abs(result.energy_closure)
    law = "" if result.law_term is None else f"; gain of the law {100 * result.law_term:.2g} %"
    advice = f", more than {100 * _COARSE:g} %: take a shorter step" * (closure > _COARSE)
    return f"books closed to {100 * closure:.2g} % of what is dissipated{advice}{law}"
