"""Reports for a person before and after a run."""

from typing import Any

import numpy as np

from damper3d.case.bed import pairs_of
from damper3d.case.case import DamperCase
from damper3d.case.contacts import Pairing
from damper3d.case.excitation.excitation import Excitation
from damper3d.case.host.host import COUNTED, REACHED, Drive
from damper3d.case.host.modes import Modes
from damper3d.case.host.several import name_of
from damper3d.case.plan import (
    disk_at_most,
    expected_cpu_of_step,
    expected_cpu_s,
    memory_at_most,
    most_threads,
    steps_at_most,
    warnings,
)
from damper3d.case.settings import Run, Settings
from damper3d.measures import excitation, host
from damper3d.measures.efficiency import in_words
from damper3d.run.result import Result
from granulab.campaign.output import room
from granulab.campaign.output.layout import pulls_in_words
from granulab.campaign.runs import sharing
from granulab.campaign.sweeps.overview import in_minutes

_COARSE = 0.005  # closed at 1 us, relative to what is dissipated
_MOST_CYCLES = 12  # that are listed one by one


def _filling_friction(settings: Settings) -> str:
    """ "with friction 0.2, ", where it is not that of the motion."""
    friction = settings.fill.friction
    if friction is True:
        return ""
    return f"with friction {friction:g}, " if friction else "without friction, "


def echo(case: DamperCase, dry_run: bool) -> str:
    """The case in SI, the time step with its reason, restitutions, and what looks wrong."""
    settings, particle, steps = case.settings, case.particle, case.steps
    lines = [
        f"{case.name}, seed {settings.run.seed}",
        f"  enclosure   {case.enclosure.words}",
        f"  particles   {case.count} of {particle.name}: radius {particle.equal_volume_radius:g} "
        f"m, {case.particle_mass:.4g} kg each, {case.mass:.4g} kg together, fill ratio "
        f"{case.fill_ratio:.3f}",
        *_kinds(case),
        *_motion(case),
        *_laws(case),
        f"  contact     {_contact(case)}",
        *_more(case),
        *_yield(case),
        f"  filling     settled for {settings.fill.settle_time:g} s under gravity "
        f"{_vector(case.settling_gravity)} m/s2, {_filling_friction(settings)}in steps of "
        f"{steps.free:.4g} s",
        f"  time step   {case.time_step:.6g} s: {steps.reason};",
        f"              {steps.per_sample} a sample, {settings.output.samples} samples a cycle",
        *sharing.in_words(min(sharing.shared_by(expected_cpu_of_step(case)), most_threads(case))),
        f"  ends        {_end(case)}",
    ]
    if dry_run:
        filling, motion = expected_cpu_s(case)
        lines.append(
            f"  expected    about {in_minutes(filling + motion)} min of CPU besides pictures, "
            f"{in_minutes(filling)} of them for a packing that is not there yet"
        )
    lines += room.lines(disk_at_most(case), memory_at_most(case))
    return "\n".join([*lines, *(f"  warning     {line}" for line in warnings(case))])


def _motion(case: DamperCase) -> list[str]:
    motion = case.settings.motion
    if case.modes is not None:
        return [*_host_lines(case, case.modes), _along(case)]
    if case.excitation is not None:
        return [
            f"  motion      {case.orientation}, {_excited(case.excitation)}: at most "
            f"{case.amplitude:.4g} m, {case.peak_speed:.4g} m/s, gamma {motion.gamma:.4g};",
            _along(case),
        ]
    ramp = f", growing over {motion.ramp:g} cycles" if motion.ramp else ""
    return [
        f"  motion      {case.orientation}, {motion.frequency:g} Hz, gamma {motion.gamma:g}: "
        f"amplitude {case.amplitude:.4g} m, peak speed {case.peak_speed:.4g} m/s{ramp};",
        _along(case),
    ]


def _along(case: DamperCase) -> str:
    return f"              along {_vector(case.direction)}, gravity {_vector(case.gravity)} m/s2"


def _excited(excitation: Excitation) -> str:
    """Words on an excitation and its windows."""
    windows = f"{excitation.windows} windows of {excitation.window:.4g} s"
    error = excitation.band_error
    bands = "" if error is None else f", third octaves within {error:.2g} dB of the table"
    if excitation.taken_off is not None:
        offset, drift = excitation.taken_off
        bands = (
            f", means of {offset:.3g} m/s2 and {drift:.3g} m/s taken off, begins at "
            f"{excitation.motion.rate[0]:.3g} m/s"
        )
    return f"{excitation.words}, {windows}{bands}"


def _mass_at_damper(shape: float) -> str:
    return f"mass {shape**-2.0:.4g} kg at the damper" if shape else "does not move the damper"


def _host_lines(case: DamperCase, modes: Modes) -> list[str]:
    """The modes of a host, what moves it, and what it does without the damper."""
    lines = [
        f"{_mass_at_damper(shape)}, {omega / (2.0 * np.pi):.4g} Hz, damping ratio {ratio:g}"
        for shape, omega, ratio in zip(modes.shape, modes.omega, modes.damping_ratio, strict=True)
    ]
    if case.arc is not None:
        lines = [f"twists about the axis, in arcs at {case.arc:.4g} m: {line}" for line in lines]
    drive = case.drive or Drive()
    what = f"{case.settings.motion.frequency:g} Hz, " + (
        f"a force of {drive.force:.4g} N" if drive.force
        else f"its base by {drive.base:.4g} m" if drive.base
        else f"let go from {drive.start_displacement:.4g} m at {drive.start_velocity:.4g} m/s"
    )  # fmt: skip
    if case.excitation is not None:
        what = _excited(case.excitation)
    others = [
        f"  damper {k + 1:<4} at {name_of(own, k)}: {one.count} of {one.particle.name}, "
        f"{one.mass:.4g} kg, seed {one.settings.run.seed}"
        for k, (own, one) in enumerate(
            zip((case.together and case.together.damper) or [], case.dampers, strict=True)
        )
    ]
    return [
        f"  host        {'; '.join(lines)}; the bed has "
        f"{case.mass * float(modes.shape @ modes.shape):.3g} of its mass",
        *others,
        f"  motion      {case.orientation}, {what}; without "
        f"the damper: amplitude {case.amplitude:.4g} m, gamma {case.settings.motion.gamma:.4g}, "
        f"peak speed {case.peak_speed:.4g} m/s;",
    ]


def _vector(vector: np.ndarray) -> str:
    return f"({', '.join(f'{x + 0.0:.4g}' for x in vector)})"


def _kinds(case: DamperCase) -> list[str]:
    """Lines on each kind of unlike particles."""
    lines = []
    for n, kind in enumerate([] if case.bed is None else case.bed.described()):
        size, several = kind["diameter_m"], kind["sub_spheres"] > 1
        whose = (
            f"{kind['sub_spheres']} sub-spheres; equal-volume diameter" if several else "diameter"
        )
        lines.append(
            f"    kind {n + 1}    {kind['count']} of {kind['particles']}, {kind['material']}: "
            f"{kind['mass_kg']:.4g} kg, {100 * kind['mass_fraction']:.1f} % of the mass; {whose} "
            f"{size['mean']:.4g} m, sd {size['sd']:.3g}, {size['smallest']:.4g} to "
            f"{size['largest']:.4g}"
        )
    return lines


def _laws(case: DamperCase) -> list[str]:
    return [_law(name, one) for name, one in zip(_names(case), case.pairings, strict=True)]


def _names(case: DamperCase) -> list[str]:
    """Name of each pair of contacts: particles or walls, or both numbers of a mixture's kinds."""
    if len(case.pairings) == 2:
        return ["walls" if one.of_wall else "particles" for one in case.pairings]
    walls = int(case.wall_kinds.max()) + 1
    found = []
    for one, (first, second) in zip(case.pairings, pairs_of(case.sorts, walls), strict=True):
        wall = f"wall of {one.materials[1]}" if walls > 1 else "wall"
        found.append(f"{first + 1}-{wall if one.of_wall else second + 1}")
    return found


def _law(name: str, pairing: Pairing) -> str:
    law, origin = pairing.law, pairing.origin
    whence = f" from the {origin}" if origin.startswith("loss") else ""
    return (
        f"  law {name:9} 4/3 E {law.hertz:.4g} Pa, kt/kn {law.tangential:.4g}, mu {law.mu:g}, "
        f"restitution {pairing.restitution:g}{whence}"
    )


def _more(case: DamperCase) -> list[str]:
    """Lines on rolling resistance and cohesion, where the law has them."""
    law, lines = case.settings.law, []
    if law.rolling_friction is not None:
        lines.append(
            f"  rolling     resistance {law.rolling_friction:g}, {law.rolling_stiffness:g} N/m, "
            f"{law.rolling_damping or 0.0:g} N s/m"
        )
    if law.cohesion is not None:
        lines.append(
            f"  cohesion    {law.cohesion.upper()}, {law.surface_energy:g} J/m2 of each surface"
        )
    return lines


def _contact(case: DamperCase) -> str:
    law = case.settings.law
    end = "ends at zero overlap, with just this restitution"
    if law.contact_end == "force":
        end = "ends at zero force, with a slightly higher restitution"
    side = "the side's curvature counts" if law.wall_curvature else "walls are flat to it"
    return f"{end}; the spring carries its {law.tangential}; {side}"


def _yield(case: DamperCase) -> list[str]:
    """Yield velocity of each pair (eq. 5.26), and what its restitution does above it, and why."""
    lines = []
    for name, one in zip(_names(case), case.pairings, strict=True):
        limit = "not known" if one.yield_velocity is None else f"{one.yield_velocity:.3g} m/s"
        lines.append(f"  yield       {name} {limit}: restitution {one.reason}")
    return lines


def _least_on_host(run: Run) -> int:
    return min(max(run.cycles, run.discard + COUNTED), run.max_cycles)


def _end(case: DamperCase) -> str:
    run = case.settings.run
    if case.is_decay:
        return (
            f"when the root of the host's energy is below {REACHED:g} of its first for a cycle of "
            f"{case.period:.4g} s, or after {run.cycles} cycles"
        )
    if run.steady and case.modes is not None:
        return (
            f"when the host's amplitude is steady, {_least_on_host(run)} cycles at least, as its "
            f"start is to be forgotten, and {run.max_cycles} at most; the last {COUNTED} count"
        )
    if run.steady:
        return (
            f"when steady, {min(run.cycles, run.max_cycles)} cycles at least, the first "
            f"{run.discard} left out, and {run.max_cycles} cycles at most"
        )
    return (
        f"after {run.cycles} cycles of {case.period:.4g} s, the last {run.cycles - run.discard} "
        f"count; {steps_at_most(case):,} steps"
    )


def report(result: Result) -> str:
    """Report of a finished run."""
    lines = [
        f"{result.n_particles} of {result.particles}, {result.orientation}, "
        f"{_moved(result)}, gamma {result.gamma:g}, seed {result.seed}: "
        f"{_efficiency(result)}",
        f"  cycles           {_cycles(result)}",
        f"  by other counts  {result.efficiency_contact_count:.3f} as the thesis counts, "
        f"{result.efficiency_wall_work:.3f} from the work of the walls",
        *(
            f"  warning: {note}"
            for note in (result.efficiency_note, result.steady_note)
            if note is not None
        ),
        *_shares(result),
        f"  design           {result.dissipated_power_w:.4g} W dissipated{_of_a_sine(result)}",
        *(
            []
            if result.excitation is None
            else [f"  excitation       {excitation.in_words(result.excitation)}"]
        ),
        *([] if result.host is None else [f"  host             {_host(result.host)}"]),
        *[f"  damper           {_of_damper(row)}" for row in result.dampers or []],
        f"  motion           {result.phase or 'no phase named'}; bed's centre of mass "
        f"{_number(result.bed_height_m)} m up; largest force on the enclosure "
        f"{result.peak_wall_force_n:.4g} N, mean over a sample",
        f"  impacts          largest over the yield velocity: {_impacts(result)}",
        *_validity(result.hertz_validity),
        *pulls_in_words(result.pulling, "{:.2%}".format, "at the ends of cycles "),
        f"  energy           {_balance(result)}",
        f"  cost             {result.cpu_us_per_step:.1f} us of CPU a step, {result.steps:,} "
        f"steps of {result.time_step_s:.4g} s; {result.cpu_s:.1f} s in all",
        f"  run folder       {result.run_folder}{' (computed before)' if result.reused else ''}",
    ]
    return "\n".join(lines)


def _moved(result: Result) -> str:
    """Frequency of the motion, or kind of one that has none."""
    if result.excitation is not None:
        return str(result.excitation["kind"])
    return f"{result.frequency_hz:g} Hz"


def _host(found: dict[str, Any]) -> str:
    closure = found["energy_closure"]
    closed = "" if closure is None else f"; energy closed to {abs(closure):.2g} of what moved it"
    return f"{host.in_words(found)}{closed}"


def _of_damper(row: dict[str, Any]) -> str:
    """A damper of several on a host in a line."""
    size = row["rms_m"] if row["amplitude_m"] is None else row["amplitude_m"]
    kind = "rms" if row["amplitude_m"] is None else "amplitude"
    less = "" if row["reduction"] is None else f", {row['reduction']:.3g} of the bare"
    where = "" if row["folder"] == "." else f"; its own folder is {row['folder']}"
    return (
        f"{row['at']}: {row['n_particles']} of {row['particles']}, {row['mass_kg']:.4g} kg, {kind} "
        f"{1e3 * size:.4g} mm{less}, {row['dissipated_power_w']:.4g} W{where}"
    )


def _efficiency(result: Result) -> str:
    interval = "" if result.efficiency is None else _interval(result.efficiency_interval)
    return in_words(vars(result)) + interval


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


def _steady(result: Result) -> str:
    """Words on whether the counted cycles are steady; none where nobody asked or could say."""
    if result.steady is None:
        few = result.host is None and result.excitation is None and result.steady_note is None
        return "; too few to say whether they are steady" if few else ""
    return "; steady" if result.steady else "; not steady"


def _number(value: float | None) -> str:
    return "none" if value is None else f"{value:.4g}"


def _shares(result: Result) -> list[str]:
    """Share of each mechanism in the dissipated energy, a line for each pair."""
    return [
        f"  {pair.replace('_', '-'):16} "
        + ", ".join(
            f"{mechanism.replace('_', ' ')} {'none' if share is None else f'{share:.1%}'}"
            for mechanism, share in mechanisms.items()
        )
        for pair, mechanisms in result.shares.items()
    ]


def _of_a_sine(result: Result) -> str:
    """The numbers that go by one frequency; nothing of a signal that has several."""
    mass, damping = result.effective_mass, result.equivalent_damping_n_s_per_m
    if result.loss_factor is None and damping is None and mass.get("in_phase_kg") is None:
        return ""
    return (
        f", loss factor {_number(result.loss_factor)}, like a damper of {_number(damping)} N s/m;\n"
        f"                   effective mass {_number(mass.get('in_phase_kg'))} kg in phase, "
        f"{_number(mass.get('out_of_phase_kg'))} kg out of phase, of {result.mass_kg:.4g} kg"
    )


def _impacts(result: Result) -> str:
    ratios, beyond = result.max_impact_over_yield_velocity, result.impacts_beyond_yield or {}
    return ", ".join(
        f"{pair.replace('_', '-')} {_number(ratio)}"
        + (f" ({100 * share:.2g} % beyond it)" if (share := beyond.get(pair)) else "")
        for pair, ratio in ratios.items()
    )


def _validity(found: dict[str, float | None] | None) -> list[str]:
    """Line on the criterion of Hertz's law in an impact; nothing in runs of earlier versions."""
    if found is None:
        return []
    each = ", ".join(f"{pair.replace('_', '-')} {_number(one)}" for pair, one in found.items())
    return [f"  Hertz's law      (wave speed / fastest impact)^(1/5), to be much above 1: {each}"]


def _balance(result: Result) -> str:
    if result.energy_closure is None:
        return "nothing dissipated"
    closure = abs(result.energy_closure)
    law = (
        ""
        if result.law_term is None
        else f"; work of the changing stiffness {100 * result.law_term:.2g} %"
    )
    advice = f", more than {100 * _COARSE:g} %: take a shorter step" * (closure > _COARSE)
    return f"balance closed to {100 * closure:.2g} % of what is dissipated{advice}{law}"
