"""Words before and after a run: the case as it is understood, and the results."""

from typing import Any

import numpy as np

from granulab.campaign.output import room
from granulab.campaign.output.layout import pulls_in_words
from granulab.campaign.runs import sharing
from granulab.campaign.sweeps.overview import in_minutes
from granulab.contact.laws import LinearLaw
from silo2d.case.beds.elastic import assumed, in_words
from silo2d.case.case import USUAL_INTERVALS, SiloCase
from silo2d.case.disorder import QUANTITIES
from silo2d.case.plan import (
    cpu_of_step,
    disk_at_most,
    expected_cpu_s,
    expected_particles,
    hedge,
    memory_at_most,
    most_threads,
    plan,
)
from silo2d.run.ending import ENERGY_TOLERANCE
from silo2d.run.result import Result

_OUTCOMES = {
    "empty": "empty",
    "dead_zones": "at rest, dead zones left next to the outlet",
    "clogged": "clogged",
    "clogged_at_opening": "clogged at the opening",
    "time_limit": "stopped at the time limit",
}


def echo(case: SiloCase, dry_run: bool) -> str:
    """The case in SI, the time step with its reason, the restitution that follows."""
    outline, fill, run = case.outline, case.settings.fill, case.settings.run
    particle, wall = case.settings.particles.names
    lines = [
        f"{case.name}, seed {run.seed}",
        f"  silo        {outline.width:g} m wide, {outline.height:g} m high, outlet "
        f"{outline.outlet:g} m{_outlet(case)}, filled to {fill.level:g} m (about "
        f"{expected_particles(case)} particles)",
        f"  particles   {case.shapes.name}: {len(case.shapes.shapes)} shapes, mean area "
        f"{case.shapes.mean_area:.4g} m2, {case.surface_density:g} kg/m2, mean mass "
        f"{case.mean_mass:.4g} kg",
        f"  materials   particles of {particle}, walls of {wall}",
    ]
    for name, law in (("particles", case.particle_law), ("walls", case.wall_law)):
        lines.append(f"  law {name:9} {_law(law)}")
    lines += [
        *_derived(case),
        f"  contact     ends at zero {case.settings.law.contact_end}; damping: {_damping(case)}",
        f"  restitution {_restitution(case)}",
        *_disorder(case),
        f"  filling     with {fill.pour_with}, {_pouring(case)}, kn {case.pour_laws[0].kn:g} N/m, "
        f"in steps of {case.pour_time_step:g} s, until the normalised "
        f"kinetic energy is below {fill.settled:g}",
        *_door(case),
        *_acts(case),
        *_engine(case),
        *sharing.in_words(min(sharing.shared_by(cpu_of_step(case)), most_threads(case))),
        f"  ends        empty; or at rest: normalised kinetic energy below {run.at_rest:g} and "
        f"none out for {run.rest_time:g} s; or after {run.max_time:g} s (kinetic energy over what "
        "lifts each particle by its size); at rest, clogged if an outline crosses the outlet's "
        f"centre line (at the opening: fewer than {run.opening_count} out), else dead zones",
    ]
    filling, discharge = expected_cpu_s(case)
    at_most = f"; at most {plan(case)['steps_at_most']:,} steps of discharge" if dry_run else ""
    lines.append(
        f"  expected    about {in_minutes(filling + discharge)} min of CPU{hedge(case)}, "
        f"{in_minutes(filling)} of them for the packing unless it is there{at_most}"
    )
    return "\n".join(
        [*lines, *_frames(case), *room.lines(disk_at_most(case), memory_at_most(case))]
    )


def _outlet(case: SiloCase) -> str:
    """Words on an outlet that is not in the middle, or that nobody has given."""
    outline, silo = case.outline, case.settings.silo
    off = outline.outlet_centre - float(outline.polygon[:, 0].min()) - outline.width / 2
    if silo.outline is not None and silo.outlet is None and not silo.outlets:
        return " (all of its lowest edge, as no outlet is given)"
    return f" ({abs(off):.4g} m off its middle)" if abs(off) > 1e-6 * outline.width else ""


def _derived(case: SiloCase) -> list[str]:
    """Lines on what follows from E and nu, one where walls are as particles."""
    law, (particles, walls) = case.settings.law, case.derived
    alike = particles and walls and (particles.names, particles.line) == (walls.names, walls.line)
    found = [in_words(one) for one in ([particles] if alike else case.derived) if one]
    if not found or case.solids is None:
        return []
    instead = ""
    if law.kn is not None:
        instead = "; the case's kn goes before, with kt in the same ratio"
    elif law.kn_curve is not None:
        instead = "; the case's kn_curve goes before its kn"
    lines = [f"  derived     {words}{instead}" for words in found]
    return [*lines, f"  assumed     {assumed(case.solids)}"]


def _damping(case: SiloCase) -> str:
    """Source of gamma_n, between particles and at walls."""
    usual, derived = case.settings.law.damping, [one and one.restitution for one in case.derived]
    if all(derived):
        return "restitution"
    return f"{usual}, where not derived" if any(derived) else usual


def _frames(case: SiloCase) -> list[str]:
    """Line on the frames where they are fewer than usual, or more."""
    frame, touch = case.intervals
    if (frame, touch) == USUAL_INTERVALS:
        return []
    return [f"  frames      every {frame:g} s, with contacts every {touch:g} s"]


def _law(law: Any) -> str:
    """The constants of a law; with its name where it is not the linear one."""
    if isinstance(law, LinearLaw):
        return (
            f"kn {law.kn:g} N/m, kt {law.kt:g} N/m, mu {law.mu:g}, gamma_n {law.gamma_n:g} 1/s, "
            f"gamma_t {law.gamma_t:g} 1/s"
        )
    numbers = [(k, v) for k, v in law._asdict().items() if np.ndim(v) == 0]  # no curves
    return f"{type(law).__name__}: " + ", ".join(f"{k} {v:g}" for k, v in numbers)


def _acts(case: SiloCase) -> list[str]:
    """Line on inserts, outlets, plates, gate, feeder, store and vibration, where there are any."""
    law, flow, outline = case.settings.law, case.settings.flow, case.outline
    words = []
    if outline.inserts or outline.outlets:
        words.append(f"{len(outline.inserts)} inserts, {len(outline.outlets) + 1} outlets")
    if law.mu_plates is not None:
        words.append(f"plates: mu {law.mu_plates:g}, pressure ratio {law.plates_ratio:g}")
    if flow.gate_times:
        words.append(f"the gate closes, opens ... at {', '.join(flow.gate_times)}")
    if flow.feed_rate is not None:
        words.append(f"a feeder takes {flow.feed_rate:g} particles in a second")
    if flow.refill:
        words.append(f"{flow.refill} particles in store")
    if flow.vibration_amplitude is not None:
        words.append(
            f"walls vibrate, {flow.vibration_direction}, by {flow.vibration_amplitude:g} m at "
            f"{flow.vibration_frequency:g} Hz"
        )
    return [f"  besides     {'; '.join(words)}"] if words else []


def _engine(case: SiloCase) -> list[str]:
    """Lines on what moves the particles after the filling, in which steps."""
    impulses = case.impulses
    if impulses is None:
        return [f"  time step   {case.time_step:g} s: {case.time_step_reason}"]
    return [
        f"  engine      pymunk: {impulses.iterations} iterations in steps of "
        f"{impulses.time_step:g} s; overlaps of {impulses.slop:g} m are left alone; of the law it "
        "takes the friction alone, and the restitution instead of kn, kt, gamma",
    ]


def _restitution(case: SiloCase) -> str:
    parts = [
        f"{pair.replace('_', '-')} {values['one_contact']:.2f} for one contact, "
        f"{values['face_to_face']:.2f} face to face"
        for pair, values in case.restitution().items()
    ]
    return "; ".join(parts) or "not reckoned for this law"


def _disorder(case: SiloCase) -> list[str]:
    """Lines on what is drawn how widely, where anything is."""
    if case.disorder is None:
        return []
    particles, walls = (
        ", ".join(
            f"{name} {100 * getattr(found, name):.3g} %"
            for name in QUANTITIES
            if getattr(found, name)
        )
        for found in case.disorder
    )
    return [
        f"  disorder    per {case.settings.disorder.per}, standard deviations: between particles "
        f"{particles or 'none'}; at walls {walls or 'none'}"
    ]


def _pouring(case: SiloCase) -> str:
    fill, (particles, walls) = case.settings.fill, case.pour_laws
    friction = f"mu {particles.mu:g} and {walls.mu:g}" if fill.friction else "without friction"
    return friction + (f", layers of {fill.layer:g} m" if fill.layer is not None else "")


def _door(case: SiloCase) -> list[str]:
    """Lines on how the door opens, where it does not at once."""
    speed = case.settings.run.door_speed
    if speed is None:
        return []
    return [
        f"  door        drawn to the right at {speed:g} m/s, away after "
        f"{case.outline.outlet / speed:g} s; times count from the start of its motion"
    ]


def report(result: Result) -> str:
    """The results of a run with the published values."""
    store = f" and {result.n_store} in store" if result.n_store else ""
    if result.n_refilled is not None and result.n_refilled < result.n_store:
        store += f", of which {result.n_refilled or 'none'} were put on top,"
    out = f"{result.n_out} of {result.n_particles} particles{store} out"
    when = "" if not result.clogged_after_s else f" after {result.clogged_after_s:.3f} s"
    lines = [f"{result.silo}, seed {result.seed}: {_OUTCOMES[result.outcome]}{when}, {out}"]
    lines.append(f"  discharge time   {_time(result.discharge_time_s)}   {_published(result)}")
    lines.append(f"  T90              {_time(result.t90_s)}")
    if result.mean_rate_per_s is not None and result.mean_mass_flow_kg_per_s is not None:
        cut_off = result.outcome not in ("empty", "dead_zones")
        lines.append(
            f"  mean rate        {result.mean_rate_per_s:.0f} particles/s, "
            f"{result.mean_mass_flow_kg_per_s:.2f} kg/s{' until then' if cut_off else ''}"
        )
    lines += [
        f"  packing          fraction {_fraction(result.packing_fraction)}, coordination "
        f"{result.coordination:.2f}",
        *pulls_in_words(result.pulling, _percent),
        f"  energy           {_energy(result)}",
        *_shortened(result),
        f"  cost             {result.cpu_us_per_step:.1f} us of CPU a step, {result.steps:,} "
        f"steps; {result.cpu_s:.1f} s in all",
        f"  run folder       {result.run_folder}{' (computed before)' if result.reused else ''}",
    ]
    return "\n".join(lines)


def _fraction(value: float | None) -> str:
    return "not known of so few layers" if value is None else f"{value:.3f}"


def _time(seconds: float | None) -> str:
    return "none" if seconds is None else f"{seconds:.3f} s"


def _energy(result: Result) -> str:
    parts = [part for part in result.dissipated_j.values() if part is not None]
    if not parts:
        return "not known by mechanism: impulses have no energy balance"
    return (
        f"{sum(parts):.3g} J dissipated, energy balance closed to "
        f"{_percent(result.energy_closure)} of it"
    )


def _shortened(result: Result) -> list[str]:
    """A line on a time step that was shortened."""
    if not result.time_step_halvings:
        return []
    longer = 2e6 * result.time_step_s
    return [
        f"  time step        {longer / 2:.3g} us: the energy balance did not close to "
        f"{100 * ENERGY_TOLERANCE['chosen']:g} % in {longer:.3g} us"
    ]


def _percent(part: float | None) -> str:
    return "nothing" if part is None else f"{100 * abs(part):.2g} %"


def _published(result: Result) -> str:
    known = result.published
    parts = ["the paper's own"] if result.silo.endswith("(changed)") else []
    if known.get("experiment_mean_s") is not None:
        spread = known.get("experiment_sd_s")
        parts.append(
            f"experiment {known['experiment_mean_s']:.2f}"
            + (f" +- {spread:.2f}" if spread is not None else "")
            + " s"
        )
    if known.get("experiment_clogged"):
        parts.append(f"experiment clogged {known['experiment_clogged']} of {known['experiment_n']}")
    if known.get("simulation_s") is not None:
        parts.append(f"SPOLY {known['simulation_s']:.2f} s")
    elif known.get("simulation_clogged"):
        parts.append("SPOLY clogged")
    nothing = all(known.get(k) is None for k in ("experiment_n", "simulation_s"))
    return "(nothing published)" if nothing else f"({', '.join(parts)})"
