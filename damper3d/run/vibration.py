"""From the first moment of the motion to the last cycle: samples, frames, checkpoints, the end."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, dataclass, field
from typing import Any

import numpy as np

from damper3d.case.case import DamperCase
from damper3d.case.host.host import COUNTED, REACHED
from damper3d.case.plan import CHECKPOINT_WORK, checkpoint_interval, expected_cpu_of_step
from damper3d.engine.records import MECHANISMS
from damper3d.engine.simulation import Simulation, Together
from damper3d.measures.efficiency import held, reference_energy, summed
from damper3d.run.steady import BLOCK, is_steady, keeps_amplitude
from granulab.campaign.runs.checkpoint import keep_checkpoint
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.stages import Stages
from granulab.campaign.runs.trajectory import TrajectoryWriter
from granulab.contact.attraction import Attraction
from granulab.errors import Stopped

# Energy that may be unaccounted for, over the dissipated: 1 us leaves 0.5 % and 0.4 of Rayleigh's
# step 5 %; more means that the state is wrong, not coarse.
MOST_UNACCOUNTED = 0.2
_NOTHING = 1e-4  # efficiency below which this is not checked: next to nothing is dissipated
BESIDE = "damper-"  # begins the name of the folder of another damper on the host, and its arrays
_LONGEST_LOOK = 0.3  # [s of CPU, as expected] between looks whether to stop


@dataclass
class Clock:
    """State of a run besides the world, kept in the checkpoint."""

    parts: int = 0  # files of the trajectory that belong to the checkpoint
    cpu_s: float = 0.0  # CPU time of the step loop
    filling_cpu_s: float = 0.0  # CPU time of filling and settling
    lost: list[float] = field(default_factory=list)  # energy lost by the end of each cycle [J]
    attraction: list[float] = field(default_factory=list)  # of the contacts at the ends of cycles
    amplitudes: list[float] = field(default_factory=list)  # of a host in each cycle [m]
    tops: list[float] = field(default_factory=list)  # largest energy of a host in each cycle [J]
    # First harmonic of the host [m] and its largest energy [J] in the cycle that is going on.
    cycle: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    beside: list[dict[str, Any]] = field(default_factory=list)  # clocks of others on the host


@dataclass
class Shaken:
    """A damper in motion: its case, its bed, and what is kept of it where."""

    case: DamperCase
    sim: Simulation
    clock: Clock
    folder: RunFolder
    writer: TrajectoryWriter


def vibrate(
    lead: Shaken, dampers: Sequence[Shaken], stages: Stages, stop: Callable[[], bool]
) -> None:
    """Shake from the first moment, or from a checkpoint, to the last cycle.

    dampers: all on the host, in their order; lead: the one of them in whose folder the state is
    kept. Samples, frames and checkpoints come at fixed numbers of steps since the motion began.
    Raises Stopped when `stop` says so, and SimulationError; the state is kept before either.
    """
    case, together = lead.case, Together([one.sim for one in dampers])
    for one in dampers:
        one.sim.steps_per_sample = case.steps_per_sample
    per_cycle, checkpoint = case.settings.output.samples, checkpoint_interval(case, CHECKPOINT_WORK)
    intervals = (per_cycle, frame_interval(case), checkpoint, _look_interval(case))
    now = lead.sim.steps // case.steps_per_sample
    stages.begin(*_so_far(case, now)[:3])
    stages.hedge = " at most" if case.settings.run.steady else ""
    if now == 0:
        for one in dampers:
            _take(one, one.sim.sample(), now)
    while not (now % per_cycle == 0 and all(_ended(one.case, one.clock) for one in dampers)):
        target = min(now - now % every + every for every in intervals)
        began = time.process_time()
        rows = together.run(target - now)
        lead.clock.cpu_s += time.process_time() - began
        now = target
        for one, own in zip(dampers, rows, strict=True):
            _take(one, own, now)
        if now % checkpoint == 0:
            _keep(lead, dampers)
        stages.report(*_so_far(case, now))
        if stop():
            _keep(lead, dampers)
            raise Stopped(f"go on with: {lead.folder.go_on('damper3d')}")


def frame_interval(case: DamperCase) -> int:
    """Samples from one table of particles to the next; a cycle where no tables are kept."""
    output = case.settings.output
    return output.samples // (output.frames or 1)


def _look_interval(case: DamperCase) -> int:
    return max(int(_LONGEST_LOOK / (expected_cpu_of_step(case) * case.steps_per_sample)), 1)


def efficiencies_so_far(case: DamperCase, clock: Clock) -> np.ndarray:
    """Efficiencies of the cycles since the start-up that is discarded (n_cycles,) [-]."""
    reference = reference_energy(case.peak_speed, case.mass)
    return np.diff(clock.lost[case.settings.run.discard :]) / reference


def _ended(case: DamperCase, clock: Clock) -> bool:
    """True where the last cycle is over: so many, or in a steady run as soon as they are steady."""
    run, n_cycles = case.settings.run, len(clock.lost) - 1
    if case.is_decay:
        counts = n_cycles > run.discard  # one at least, or there is nothing to measure
        return n_cycles >= run.cycles or (counts and _has_decayed(clock))
    if not run.steady:
        return n_cycles >= run.cycles
    if case.modes is not None:
        ready = n_cycles >= max(run.cycles, run.discard + COUNTED)
        return n_cycles >= run.max_cycles or (ready and keeps_amplitude(clock.amplitudes))
    counted = n_cycles - run.discard
    if n_cycles < run.cycles or counted % BLOCK:
        return n_cycles >= run.max_cycles
    return n_cycles >= run.max_cycles or is_steady(efficiencies_so_far(case, clock))


def _has_decayed(clock: Clock) -> bool:
    """True where the host's energy stayed so low for a cycle that its decay is over."""
    return len(clock.tops) > 1 and clock.tops[-1] < REACHED**2 * clock.tops[0]


def _note_host(case: DamperCase, clock: Clock, rows: dict[str, np.ndarray], now: int) -> None:
    """Add samples, of which the last is number `now`, to what is known of the host's cycle."""
    per_cycle = case.settings.output.samples
    number = now - len(rows["time"]) + 1 + np.arange(len(rows["time"]))
    turned = np.exp(-2j * np.pi * (number % per_cycle) / per_cycle)
    first = 2.0 / per_cycle * complex((rows["displacement"] * turned)[number > 0].sum())
    re, im, top = clock.cycle
    clock.cycle = [re + first.real, im + first.imag, max(top, float(rows["host_energy"].max()))]
    if now and now % per_cycle == 0:
        clock.amplitudes.append(math.hypot(*clock.cycle[:2]))
        clock.tops.append(clock.cycle[2])
        clock.cycle = [0.0, 0.0, 0.0]


def _take(damper: Shaken, rows: dict[str, np.ndarray], now: int) -> None:
    """Keep samples, of which the last is number `now`; frames and cycles end with one."""
    case, clock, sim = damper.case, damper.clock, damper.sim
    if case.modes is not None:
        _note_host(case, clock, rows, now)
    framed = case.settings.output.frames and now % frame_interval(case) == 0
    last = len(rows["time"]) - 1
    damper.writer.extend(rows, tables_of(sim) if framed else None)
    if now % case.settings.output.samples == 0:
        clock.lost.append(float(rows["wall_work"][last] - held(rows)[last]))
        attraction = Attraction(*clock.attraction)
        attraction.look(sim.contacts())
        clock.attraction = list(astuple(attraction))
        _check_balance(sim, case, clock, rows)


def _check_balance(
    sim: Simulation, case: DamperCase, clock: Clock, rows: dict[str, np.ndarray]
) -> None:
    """Stop where energy lost and dissipated differ, but for the work of the changing stiffness."""
    dissipated = float(summed(rows, MECHANISMS)[-1])
    gained = dissipated - float(summed(rows, ("law_term",))[-1]) - clock.lost[-1] + clock.lost[0]
    least = _NOTHING * reference_energy(case.peak_speed, case.mass)
    if not abs(gained) < MOST_UNACCOUNTED * max(dissipated, least):
        whither = "came from nowhere" if gained > 0 else "went nowhere"
        raise sim.failure(f"{abs(gained):.3g} J of energy {whither}")


def tables_of(sim: Simulation) -> dict[str, dict[str, np.ndarray]]:
    """Particles and contacts of a moment as they are kept, in single precision."""
    frame, contacts = sim.frame(), sim.contacts()
    vectors = {"": frame["x"], "v": frame["v"], "spin_": frame["spin"]}
    particles = {
        f"{name}{axis}": vector[:, k].astype(np.float32)
        for name, vector in vectors.items()
        for k, axis in enumerate("xyz")
    }
    force = contacts["force"].astype(np.float32)
    for k, name in enumerate(("turn_w", "turn_x", "turn_y", "turn_z")):  # of several spheres
        if "orientation" in frame:
            particles[name] = frame["orientation"][:, k].astype(np.float32)
    return {
        "particles": {**particles, "heat": frame["heat"].astype(np.float32)},
        "contacts": {
            **{f"body_{k + 1}": contacts["bodies"][:, k] for k in range(2)},
            **{f"force_{axis}": force[:, k] for k, axis in enumerate("xyz")},
        },
    }


def _keep(lead: Shaken, dampers: Sequence[Shaken]) -> None:
    """Write what all dampers go on from: the lead's arrays by their names, others' below BESIDE."""
    for one in dampers:
        one.clock.parts = one.writer.flush()
    arrays = lead.sim.save()
    others = [(k, one) for k, one in enumerate(dampers) if one is not lead]
    for k, one in others:
        arrays |= {f"{BESIDE}{k + 1}/{name}": array for name, array in one.sim.save().items()}
    lead.clock.beside = [asdict(one.clock) for _, one in others]
    keep_checkpoint(lead.folder, lead.clock.parts, arrays, asdict(lead.clock))


def restore(sims: Sequence[Simulation], lead: int, saved: dict[str, np.ndarray]) -> None:
    """Put back the arrays of a checkpoint, of which number lead has the plain names."""
    for k, sim in enumerate(sims):
        begin = f"{BESIDE}{k + 1}/"
        own = {name.removeprefix(begin): array for name, array in saved.items()
               if name.startswith(begin)}  # fmt: skip
        sim.restore(saved if k == lead else own)


def _so_far(case: DamperCase, now: int) -> tuple[str, float, float, str]:
    """Stage, cycles done and left, and words."""
    run = case.settings.run
    cycle, most = now / case.settings.output.samples, run.max_cycles if run.steady else run.cycles
    until = f"of at most {most}" if run.steady else f"of {most}"
    return "shaking", cycle, most - cycle, f"cycle {cycle:.1f} {until}"
