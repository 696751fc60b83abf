"""Plan of a run: its steps, the CPU time, disk and memory to expect, and warnings."""

import math
from typing import Any

from damper3d.case.case import GRAVITY, DamperCase
from damper3d.case.closed_forms import fluidisation_threshold
from damper3d.case.contacts import Pairing
from damper3d.case.excitation.excitation import peaks_of
from damper3d.case.oscillation import DEEPEST
from damper3d.case.parameters import SAFE_SHARE
from damper3d.engine import state
from damper3d.engine.enclosures.cavity import Cavity
from damper3d.engine.motions import Turning
from damper3d.engine.records import CLASSES
from damper3d.engine.world import parts_of
from granulab.campaign.output import room

# On one core of a server of 2020, of a particle and step [s] (`make bench`;
# the runs that those of several spheres were fitted to stand in docs/damper/shapes.md).
_OF_A_SPHERE = 4e-8
_OF_A_PARTICLE, _OF_A_SUB_SPHERE = 1.2e-7, 3.6e-9
_GROWING = 3000  # steps of a random start
# Cost of a step of the settled bed, of one that the enclosure throws, and what is added with the
# square root of the peak speed over sqrt(g d), d of a sphere of a particle's volume: fitted to runs
# at 20, 40 and 80 Hz and Gamma 2 to 40, which it meets to a quarter.
_SETTLED, _THROWN, _STIRRED = 2.5, 0.75, 0.3
_WRITING = 0.5  # [s]
_NOT_MUCH = 0.05  # of a signal's largest value, that its start or its mean may be without a warning
# Particles times steps between checkpoints, some seconds of work: a checkpoint must not depend on
# how fast a machine is, and in the short runs of a map it would cost more than it saves.
CHECKPOINT_WORK = 2e8
# A checkpoint costs what some tens of steps of its bed do, of any size: beyond so many particles
# the work between two grows with them, so that 2000 steps lie between.
_LARGE = 100_000
_MOST_SAMPLES = 10_000  # between checkpoints, of a few particles too: until then they are in memory
# Bytes: of a contact in a frame, of a particle in a checkpoint (with its contacts' springs), of the
# program with its kernels (when they are compiled), and of a particle in a frame that counts, while
# its motion is measured at the end (found 102).
_OF_A_CONTACT, _KEPT_OF_A_PARTICLE, _PROCESS, _MEASURED = 20, 800, 600e6, 110
# [B] in the arrays of the step loop: of a sphere (found 3740, of which 2100 are used), of a
# multi-sphere particle (8.7e3) and of each of its sub-spheres (630).
_OF_A_WORLD, _OF_A_WORLD_PARTICLE, _OF_A_WORLD_SUB_SPHERE = 4e3, 9e3, 650
_NUMBERS = 30  # of a sample, besides the wall forces
_OF_ARRAYS = 5e3  # [B] of the arrays of a sample in memory, besides what is in them
_OF_A_SUMMARY = 5 * 4096  # [B] of a run that keeps its results only: five files of a block
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
    each = _OF_A_SPHERE
    if not case.of_spheres:
        each = _OF_A_PARTICLE + _OF_A_SUB_SPHERE * float(case.sub_spheres.mean())
    return each * case.all_particles


def most_threads(case: DamperCase) -> int:
    """Return how many threads can share a step: see engine.simulation.Simulation.share."""
    law = case.settings.law
    alone = case.dampers or law.rolling_friction or law.cohesion == "jkr"
    if alone or isinstance(case.enclosure, Cavity) or isinstance(case.shaker, Turning):
        return 1
    return state.most_threads(parts_of(case.count, not case.of_spheres))


def expected_stages(case: DamperCase) -> dict[str, float]:
    """About what each stage of a run costs [s of CPU]."""
    cost = expected_cpu_of_step(case)
    return {
        "filling": _GROWING * cost,
        "settling": _SETTLED * cost * case.settings.fill.settle_time / case.steps.free,
        "shaking": _stirring(case) * cost * steps_at_most(case),
        "writing": _WRITING,
    }


def _stirring(case: DamperCase) -> float:
    """Cost of a step of the shaken bed, over the mean of all: particles that fly touch nobody."""
    if case.settings.motion.gamma <= 1.0:
        return _SETTLED
    own = math.sqrt(GRAVITY * 2.0 * case.particle.equal_volume_radius)
    return min(_THROWN + _STIRRED * math.sqrt(case.peak_speed / own), _SETTLED)


def expected_cpu_s(case: DamperCase) -> tuple[float, float]:
    """About what the packing of a case and its run cost [s of CPU]."""
    growing, settling, *run = expected_stages(case).values()
    return growing + settling, sum(run)


def compiling(case: DamperCase) -> tuple[float, int]:
    """About what the kernels of a case cost to compile [s of CPU], and how many functions."""
    return (19.0, 229) if case.of_spheres else (34.0, 302)


def checkpoint_interval(case: DamperCase, work: float = CHECKPOINT_WORK) -> int:
    """Samples between checkpoints: whole cycles, or less in cycles that take long."""
    per_cycle = case.settings.output.samples
    steps = work / min(case.all_particles, _LARGE)
    samples = min(max(int(steps / case.steps_per_sample), 1), _MOST_SAMPLES)
    return samples if samples < per_cycle else samples // per_cycle * per_cycle


def _kept(case: DamperCase) -> tuple[int, int, float, float, float]:
    """Samples and frames of a run at most; bytes of a sample, and of a frame's particles and
    contacts.
    """
    output = case.settings.output
    samples = steps_at_most(case) // case.steps_per_sample
    frames = samples // output.samples * output.frames + 1 if output.frames else 0
    numbers = _NUMBERS + 3 * len(case.wall_names)
    columns = 10 if case.of_spheres else 14  # place, motion, spin, heat; and how it is turned
    of_contacts = room.CONTACTS * case.all_particles * _OF_A_CONTACT
    return (
        samples + 1,
        frames,
        8.0 * numbers * max(len(case.dampers), 1),
        4.0 * columns * case.all_particles,
        of_contacts,
    )


def disk_at_most(case: DamperCase) -> dict[str, int]:
    """Bytes of frames, contacts and checkpoints that a run takes at most, to its last cycle."""
    samples, frames, of_sample, of_frame, of_contacts = _kept(case)
    return room.on_disk(
        frames=[(samples, of_sample), (frames, of_frame)],
        numbers=0,
        contacts=(frames, of_contacts),
        parts=samples / checkpoint_interval(case) + 1,
        checkpoint=case.all_particles * _KEPT_OF_A_PARTICLE,
        merged=case.settings.output.keep == "all",
    )


def stays(case: DamperCase) -> float:
    """Bytes that a finished run takes at most, of those of disk_at_most."""
    return _OF_A_SUMMARY if case.settings.output.keep == "summary" else math.inf


def memory_at_most(case: DamperCase) -> int:
    """Bytes of memory that a run takes at most; most frames are in it when it is measured."""
    samples, frames, of_sample, of_frame, of_contacts = _kept(case)
    together = min(checkpoint_interval(case), samples)
    unwritten = together * (of_sample + _OF_ARRAYS)
    unwritten += frames / samples * together * (of_frame + of_contacts)
    each = _OF_A_WORLD
    if not case.of_spheres:
        each = _OF_A_WORLD_PARTICLE + _OF_A_WORLD_SUB_SPHERE * float(case.sub_spheres.mean())
    own = case.all_particles * (each + frames * _MEASURED)
    return room.in_memory(_PROCESS + own, unwritten)


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
    shapes = [case.particle] if case.bed is None else [sort.shape for sort in case.bed.sorts]
    found += [
        f"the mesh does not keep its size: it is scaled to an equal-volume radius of "
        f"{1e3 * shape.equal_volume_radius:g} mm; --mesh-unit mm keeps it"
        for shape, own in zip(shapes, case.settings.particles.kinds, strict=True)
        if shape.kind == "mesh" and not (own.mesh_unit or own.equal_volume_radius)
    ]
    motion, run = case.settings.motion, case.settings.run
    if motion.ramp > run.discard:
        found.append(
            f"the amplitude grows over {motion.ramp:g} cycles and only {run.discard} are left out: "
            "the efficiency is low, as it is taken over the full amplitude; discard as many"
        )
    found += _signal_warnings(case)
    found += _still_bed_warning(case)
    found += [line for pair in CLASSES for line in _impact_warnings(case, pair)]
    return found


def _signal_warnings(case: DamperCase) -> list[str]:
    """Warnings where a measured motion begins with a kick, or was measured with an offset."""
    own = case.excitation
    if own is None or own.taken_off is None:
        return []
    found, (offset, _) = [], own.taken_off
    start, peaks = abs(float(own.motion.rate[0])), peaks_of(own)
    if start > _NOT_MUCH * peaks.speed:
        found.append(
            f"[excitation] the signal begins at {start:.3g} m/s, {100 * start / peaks.speed:.0f} % "
            "of its largest velocity, a kick to the bed at rest: give a record that begins at "
            "rest, or integration = 'as_measured', which starts an acceleration from rest"
        )
    if abs(offset) > _NOT_MUCH * peaks.acceleration:
        found.append(
            f"[excitation] a mean of {offset:.3g} m/s2 is taken off the measured acceleration, "
            f"{100 * abs(offset) / peaks.acceleration:.0f} % of its largest: an offset of the "
            "instrument, or a pulse that integration = 'as_measured' keeps"
        )
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
    lines, name = [], pair.replace("_", "-")
    own = [one for one in case.pairings if one.of_wall == (pair == CLASSES[1])]
    constant = [one.yield_velocity for one in own if not one.falls]
    limit = min((limit for limit in constant if limit is not None), default=None)
    if limit is not None and case.peak_speed > _FAST * limit:
        lines.append(
            f"peak speed {case.peak_speed:.3g} m/s: {case.peak_speed / limit:.1f} times the yield "
            f"velocity of {name}; the restitution would be lower there"
        )
    depth = max(_hertz_overlap(one, case.peak_speed) for one in own)
    if depth > DEEPEST:
        lines.append(
            f"{name} impacts at the peak speed overlap by {depth:.2g} radii; the law holds for "
            "small overlaps: give a higher youngs_modulus or a lower gamma"
        )
    return lines


def _hertz_overlap(pairing: Pairing, speed: float) -> float:
    """Largest overlap of an elastic impact, over the radius of the sphere [-].

    (5 m v^2/(4 K))^(2/5) with K = law.hertz sqrt(R) and the reduced mass and radius; that of two
    spheres is half of theirs where they are alike, and the smaller one's at least.
    """
    stiffness = pairing.law.hertz * math.sqrt(pairing.radius)
    overlap = (1.25 * pairing.mass * speed**2 / stiffness) ** 0.4
    return overlap / (pairing.radius if pairing.of_wall else 2.0 * pairing.radius)


def _described(pairing: Pairing) -> dict[str, Any]:
    """Contacts of two materials for --dry-run."""
    return {
        "materials": list(pairing.materials),
        "of_wall": pairing.of_wall,
        "friction": pairing.law.mu,
        "restitution": pairing.restitution,
        "restitution_from": pairing.origin,
        "yield_velocity_m_s": pairing.yield_velocity,
        "restitution_falls": pairing.falls,
        "restitution_rule": pairing.reason,
    }


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
        "pairs": [_described(pairing) for pairing in case.pairings],
        "kinds": None if case.bed is None else case.bed.described(),
        "yield_velocity_m_s": case.yield_velocity,
        "wave_speed_m_s": case.wave_speed,
        "steps": steps_at_most(case),
        "expected_min": sum(expected_cpu_s(case)) / 60,
        "disk_bytes_at_most": disk_at_most(case),
        "memory_bytes_at_most": memory_at_most(case),
        "warnings": warnings(case),
    }
