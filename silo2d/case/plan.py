"""Plan of a run before anything is filled: particles, steps, CPU time, disk and memory."""

import math
from typing import Any

import numpy as np

from granulab.campaign.output import room
from silo2d.case.beds.elastic import PAIRS
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.filling import USUAL_FRACTION, particles_below
from silo2d.engine.state import parts_of

# Costs and usual values that the plan is made with.
_SECONDS_PER_PARTICLE_STEP = 5e-8  # in a bed, on one core of a server of 2024
_SECONDS_PER_PARTICLE_IMPULSES = 6e-7, 4e-8  # of pymunk: a step, and an iteration in it
# Cost of a particle that falls, and of one in a bed that flows out (A4 to D4 and A3: 0.67 to 0.83),
# over that of one in a bed at rest.
FALLING, FLOWING = 0.4, 0.75
# Simulated times, in root(level/g): from when the rain is down until it lies still, without
# friction and with it (means of 36 strangers' silos, which scatter by a third; published ones need
# less), and then under its own law.
_COLLAPSE, _WITH_FRICTION, _SETTLING = 4.2, 1.2, 0.6
_OF_A_LAYER = 0.65  # of this, where it lies still by layers
_WRITING = 0.5  # [s]
# Beverloo's law of a slot, C (D - k d)^1.5, for a rate before there is any: right to a third.
_BEVERLOO_C, _BEVERLOO_K = 0.85, 1.5
# Bytes: of a particle and of a contact in a frame, of a particle in a checkpoint (its row, layout
# and slips; found up to 270), and of the program with its kernels (350 MB when they are compiled).
_OF_A_PARTICLE, _OF_A_CONTACT, _KEPT_OF_A_PARTICLE, _PROCESS = 33, 37, 400, 350e6
_OF_A_SAMPLE = 26  # [B] of a contact in a sample at the walls
_AT_WALLS = 5.0  # contacts of a particle there, at most
_NUMBERS = 16  # of a frame, besides the wall forces
_OF_ARRAYS = 5e3  # [B] of the arrays of a frame in memory, besides what is in them
_DRAWN = 4e3  # [B] of a particle in pictures and film; found 3.7e3
_DENSEST = 1.1  # particles over those expected


def plan(case: SiloCase) -> dict[str, Any]:
    """Plan of a run of a case: particles, steps, CPU time [min]."""
    step = case.impulses.time_step if case.impulses else case.time_step
    return {
        "silo": case.silo_name or case.name,
        "seed": case.settings.run.seed,
        "engine": case.settings.run.engine,
        "n_particles": expected_particles(case),
        "time_step_s": step,
        "time_step_reason": "as given" if case.impulses else case.time_step_reason,
        "restitution": case.restitution(),
        "derived": {
            name: one.numbers() for name, one in zip(PAIRS, case.derived, strict=True) if one
        },
        "steps_at_most": math.ceil(case.settings.run.max_time / step),
        "expected_min": sum(expected_cpu_s(case)) / 60,
        "disk_bytes_at_most": disk_at_most(case),
        "memory_bytes_at_most": memory_at_most(case),
    }


def _kept(case: SiloCase) -> tuple[float, float, float, float, float]:
    """Frames, tables of contacts and parts of a run at most; frames a part, bytes a frame."""
    step = case.impulses.time_step if case.impulses else case.time_step
    longest = case.settings.run.max_time
    part = max(case.settings.output.checkpoint_interval, step)
    frame, touch = (max(interval, step) for interval in case.intervals)
    frames = longest / frame + 2
    tables = 0.0 if case.impulses else longest / max(touch, frame) + 2
    n_bytes = _DENSEST * _in_all(case) * _OF_A_PARTICLE + 8 * _numbers(case)
    return frames, tables, longest / part + 2, min(part / frame + 1, frames), n_bytes


def _numbers(case: SiloCase) -> int:
    return _NUMBERS + 2 * len(case.outline.walls().names)


def disk_at_most(case: SiloCase) -> dict[str, int]:
    """Bytes of frames, contacts and checkpoints that a run takes at most, to its longest time."""
    frames, tables, parts, _, of_frame = _kept(case)
    n = _DENSEST * _in_all(case)
    return room.on_disk(
        frames=[(frames, of_frame)],
        numbers=frames * _numbers(case),
        contacts=(tables, _of_a_table(case, n, tables)),
        parts=parts,
        checkpoint=n * _KEPT_OF_A_PARTICLE,
    )


def _of_a_table(case: SiloCase, n: float, tables: float) -> float:
    """Bytes of a table of contacts of n particles, with the samples at the walls by it."""
    size = room.CONTACTS * n * _OF_A_CONTACT
    every = case.settings.output.wall_interval
    if every is None or not tables:
        return size
    around = float(np.hypot(*np.diff(case.outline.walls().segments, axis=1)[:, 0].T).sum())
    of_one = _AT_WALLS * around / math.sqrt(case.shapes.mean_area) * _OF_A_SAMPLE
    samples = case.settings.run.max_time / max(every, case.time_step)
    return size + samples / tables * of_one


def memory_at_most(case: SiloCase) -> int:
    """Bytes of memory that a run takes at most: the program's own, and that of its pictures."""
    frames, tables, _, together, of_frame = _kept(case)
    n = _DENSEST * _in_all(case)
    of_contacts = tables / frames * _of_a_table(case, n, tables)
    own = n * 16 * 200  # 16 pairs of vertices and edges a particle, of 25 numbers in three lists
    pictures = frames * of_frame + n * _DRAWN  # these read all frames
    return room.in_memory(
        _PROCESS + own + pictures, together * (of_frame + of_contacts + _OF_ARRAYS)
    )


def expected_particles(case: SiloCase) -> int:
    """About how many particles fill the silo to its level."""
    return particles_below(case.settings.fill.level, case.outline, case.shapes)


def _in_all(case: SiloCase) -> int:
    """About how many particles there are, with those in store."""
    return expected_particles(case) + case.settings.flow.refill


def cpu_of_step(case: SiloCase) -> float:
    """About how long a step takes one core while all particles are there [s]."""
    return _SECONDS_PER_PARTICLE_STEP * _in_all(case)


def most_threads(case: SiloCase) -> int:
    """Return how many threads can share a step: see engine.simulation.Simulation.share."""
    if case.settings.run.engine != "dem" or case.settings.law.mu_plates:
        return 1
    return len(parts_of(_in_all(case))) - 1


def expected_rate(case: SiloCase) -> float:
    """About how many particles leave in a second, if they flow (Beverloo et al. 1961) [1/s]."""
    area = case.shapes.mean_area
    diameter = math.sqrt(4 * area / math.pi)
    width = max(case.outline.outlet - _BEVERLOO_K * diameter, 0.1 * case.outline.outlet)
    return _BEVERLOO_C * USUAL_FRACTION * math.sqrt(GRAVITY) * width**1.5 / area


def particle_seconds(inside: float, rate: float, span: float) -> float:
    """Integral of the number of particles inside over a time [s], or until the last is out.

    rate: particles that leave in a second.
    """
    span = min(max(span, 0.0), inside / rate)
    return inside * span - 0.5 * rate * span**2


def hedge(
    case: SiloCase, inside: float | None = None, rate: float | None = None, time: float = 0.0
) -> str:
    """Words after a time left: of the longest time, or of a flow that empties the silo before."""
    inside = expected_particles(case) if inside is None else inside
    empty = time + inside / (expected_rate(case) if rate is None else rate)
    return " at most" if empty > case.settings.run.max_time else " if it flows on"


def collapse(case: SiloCase) -> float:
    """Simulated time [s] that a filling needs, once it is down, until it lies still."""
    return (_WITH_FRICTION if case.settings.fill.friction else _COLLAPSE) * _fall(case)


def settling(case: SiloCase) -> float:
    """Simulated time [s] that a packing needs until it lies still under its own law."""
    return _SETTLING * _fall(case)


def _fall(case: SiloCase) -> float:
    return math.sqrt(case.settings.fill.level / GRAVITY)


def expected_stages(case: SiloCase) -> dict[str, float]:
    """About what each stage of a run costs [s of CPU]."""
    n, cost, step = expected_particles(case), _SECONDS_PER_PARTICLE_STEP, case.time_step
    level, layer = case.settings.fill.level, case.settings.fill.layer
    n_layers = max(math.ceil(level / layer - 1e-9), 1) if layer else 1
    by_layers = 1.0 if n_layers == 1 else _OF_A_LAYER
    filling = FALLING * math.sqrt(2 * level / GRAVITY / n_layers) + by_layers * collapse(case)
    # Layer k of L costs (k + 1)/(L + 1) of what the whole bed does.
    spread = 0.5 * n_layers * (n_layers + 3) / (n_layers + 1)
    still, flowing = cost * settling(case) / step, FLOWING
    if case.impulses:
        a_step, an_iteration = _SECONDS_PER_PARTICLE_IMPULSES
        cost, step = a_step + an_iteration * case.impulses.iterations, case.impulses.time_step
        still, flowing = 0.0, 1.0
    inside = particle_seconds(n, expected_rate(case), case.settings.run.max_time)
    return {
        "filling": _SECONDS_PER_PARTICLE_STEP * n * spread * filling / case.pour_time_step,
        "settling": n * still,
        "discharging": cost * flowing * inside / step,
        "writing": _WRITING,
    }


def expected_cpu_s(case: SiloCase) -> tuple[float, float]:
    """About what the filling of a case and its run cost [s of CPU]."""
    filling, *run = expected_stages(case).values()
    return filling, sum(run)


def compiling(case: SiloCase) -> tuple[float, int]:
    """About what the kernels of a case cost to compile [s of CPU], and how many functions."""
    return 9.0, 92
