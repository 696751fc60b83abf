"""Flow through an outlet, clog after clog, and what is noted of it."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from granulab.campaign.runs.stages import Stages
from granulab.errors import Stopped
from silo2d.avalanches.arches import Bed
from silo2d.engine.simulation import Simulation
from silo2d.measures.clogging.waits import BINS, bin_of
from silo2d.run.discharge import LONGEST_LOOK, check_energy_balance, motion, open_door
from silo2d.run.ending import LOOK, Clock, at_rest, blocked

# Of the area above the outlet, where particles take less: a channel (rathole) around which the
# rest of the bed stands. Beds in flow take 0.6 to 0.85 of it, loose particles that fall through a
# channel 0.1 to 0.4 (docs/silo/clogging.md).
RATHOLE = 0.5
_CHECKPOINT = 0.5  # [s] of simulated time, at most between two
_PATIENCE = 100  # breaks one after the other from which nothing leaves


@dataclass
class Ledger(Clock):
    """State of a run of avalanches besides the world: kept in the checkpoint.

    sizes ... waits     as of the results
    through             particles that left since the space above the outlet was last half full, or
                        since the last break
    size                particles that left in the present avalanche so far
    begun               when that began; looked: when crossings were noted last; last: when the last
                        particle left, None before the first of the avalanche [s]
    """

    sizes: list[int] = field(default_factory=list)
    cut: list[int] = field(default_factory=list)
    durations: list[float] = field(default_factory=list)
    first: list[int] = field(default_factory=list)  # size and whether it clogged, once it is over
    arch_particles: list[int] = field(default_factory=list)
    arch_span: list[float] = field(default_factory=list)
    arch_aspect: list[float] = field(default_factory=list)
    arches_not_found: int = 0
    breaks: int = 0
    in_vain: int = 0  # the last of them, from which nothing left
    refilled: int = 0
    waits: list[int] = field(default_factory=lambda: [0] * BINS)
    through: int = 0
    opened: bool = False
    size: int = 0
    begun: float = 0.0
    looked: float = 0.0
    last: float | None = None


def flow(
    sim: Simulation, bed: Bed, ledger: Ledger, keep: Callable[[], None], stages: Stages,
    stop: Callable[[], bool],
) -> str:  # fmt: skip
    """Run avalanche after avalanche; "whole" once all are there, else why there are no more.

    Looks come at fixed numbers of steps since the opening, so that the same bits follow however
    often it is stopped. keep: writes a checkpoint. Raises Stopped when `stop` says so, with the
    state kept, and SimulationError.
    """
    if not ledger.opened:
        open_door(sim, bed.silo, bed.packing, ledger)
        ledger.opened = True
        keep()
    look, saving = (max(round(span / sim.time_step), 1) for span in (LOOK, _CHECKPOINT))
    every = [look, saving, max(LONGEST_LOOK // sim.n_particles, 1)]
    while True:
        now = sim.steps
        target = min(now - now % n + n for n in every)
        began = time.process_time()
        sim.run(target - now)
        outcome = _look(sim, bed, ledger) if target % look == 0 else None
        ledger.cpu_s += time.process_time() - began
        if outcome:
            if outcome == "rathole":  # through a channel, above which no arch can stand
                ledger.size = max(ledger.size - ledger.through, 0)
            if outcome != "whole" and ledger.size:  # what flowed until then counts too
                _over(bed, ledger, sim.time, clogged=False)
            return outcome
        if target % saving == 0:
            keep()
        _report(bed, ledger, sim, stages)
        if stop():
            keep()
            raise Stopped("the same command goes on from there")


def _look(sim: Simulation, bed: Bed, ledger: Ledger) -> str | None:
    """Note what left, keep the level, and end an avalanche that is over; the outcome, if all is."""
    left = _note(sim, ledger)
    ledger.refilled += bed.put_on_top(sim, _gone(sim), ledger.refilled)
    check_energy_balance(sim, bed.silo, ledger)
    silo, protocol = bed.silo, bed.case.protocol
    if at_rest(sim, motion(sim, silo), silo, ledger):
        if not blocked(sim, silo, bed.packing):
            return "dead_zones"
        return _clogged(sim, bed, ledger)
    if _is_rathole(bed, ledger, left, bed.above_outlet(sim)):
        return "rathole"
    if ledger.size >= protocol.largest:
        return _over(bed, ledger, sim.time, clogged=False)
    if left == 0 and sim.time - (ledger.last or ledger.begun) > silo.settings.run.max_time:
        return "time_limit"
    return None


def _is_rathole(bed: Bed, ledger: Ledger, left: int, above: float) -> bool:
    """True once more has left through a channel above the outlet than would fill it.

    above: see Bed.above_outlet; left: particles since the last look. What stands on a high arch
    leaves a hollow too, but lets nothing through.
    """
    ledger.through = ledger.through + left if above < RATHOLE else 0
    return ledger.through * bed.silo.shapes.mean_area > bed.above


def _note(sim: Simulation, ledger: Ledger) -> int:
    """Note the particles that left since the last look, and the times between them."""
    times = np.sort(sim.out_time[sim.out_time > ledger.looked])
    known = times if ledger.last is None else np.concatenate([[ledger.last], times])
    if ledger.first:  # not in the one from the opening
        for k in bin_of(np.diff(known)):
            ledger.waits[k] += 1
    if len(times):
        ledger.last, ledger.in_vain = float(times[-1]), 0
    ledger.size += len(times)
    ledger.looked = sim.time
    return len(times)


def _gone(sim: Simulation) -> np.ndarray:
    """Particles that are below the outlet and no longer simulated."""
    return np.setdiff1d(np.arange(sim.n_particles), sim.live)


def _clogged(sim: Simulation, bed: Bed, ledger: Ledger) -> str | None:
    """End the avalanche and break the arch; the outcome, once all avalanches are there.

    A break from which nothing left began no avalanche.
    """
    arch = bed.find_arch(sim)
    if ledger.size or not ledger.first:
        if arch is None:
            ledger.arches_not_found += 1
        else:
            ledger.arch_particles.append(len(arch.particles))
            ledger.arch_span.append(arch.span)
            ledger.arch_aspect.append(arch.rise / arch.span)
        if outcome := _over(bed, ledger, sim.time, clogged=True):
            return outcome
    which = bed.near_outlet(sim) if arch is None else arch.particles
    ledger.breaks += 1
    ledger.in_vain += 1
    if ledger.in_vain > _PATIENCE:
        return "stuck"
    if bed.case.protocol.breaking == "remove":
        ledger.refilled += bed.put_on_top(sim, np.sort(which), ledger.refilled)
    else:
        bed.shake(sim, which, ledger.breaks)
    ledger.begun, ledger.last, ledger.quiet_since = sim.time, None, None
    ledger.through = 0
    return None


def _over(bed: Bed, ledger: Ledger, now: float, *, clogged: bool) -> str | None:
    """Enter an avalanche that has clogged or is cut off; the outcome, once all are there."""
    if not ledger.first:
        ledger.first = [ledger.size, int(clogged)]
    else:
        ledger.sizes.append(ledger.size)
        ledger.cut.append(int(not clogged))
        ledger.durations.append((ledger.last or now) - ledger.begun)
    ledger.size, ledger.begun = 0, now
    return "whole" if len(ledger.sizes) == bed.case.protocol.avalanches else None


def _report(bed: Bed, ledger: Ledger, sim: Simulation, stages: Stages) -> None:
    """Report the avalanches that are over, and the part of the present one against the others."""
    total, done = bed.case.protocol.avalanches, len(ledger.sizes)
    usual = (sum(ledger.sizes) + ledger.size) / max(done, 1)
    part = 0.5 * ledger.size / max(usual, ledger.size, 1)
    words = f"{done} of {total} avalanches, {ledger.size} particles in this one"
    stages.report("flowing", done + part, total - done - part, f"{words}, t = {sim.time:.1f} s")
