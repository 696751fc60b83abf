"""End of a discharge, whichever engine moves the particles, and what it remembers."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granulab.campaign.runs.stages import Stages
from silo2d.case.case import SiloCase
from silo2d.case.plan import expected_rate, hedge, particle_seconds
from silo2d.case.shape import Shape
from silo2d.run.packing import Packing

LOOK = 0.01  # [s] between looks for the end of the run, whatever the output
# Energy that may be unaccounted for, over the dissipated; more means that the step is too long for
# what happens. A chosen step (the published runs leave 0.1 to 0.4 % at 5 us) is halved up to four
# times; one that the case gives is its own affair until it is plainly wrong.
ENERGY_TOLERANCE = {"chosen": 0.005, "given": 0.05}
MOST_HALVINGS = 4
_UNTIL_KNOWN = 0.1  # [s] of flow, from which on its rate is rather measured than expected


@dataclass
class Clock:
    """State of a run besides the world: kept in the checkpoint."""

    parts: int = 0  # files of the trajectory that belong to the checkpoint
    cpu_s: float = 0.0  # CPU time of the discharge's step loop
    filling_cpu_s: float = 0.0  # CPU time of filling and settling
    halvings: int = 0  # of the chosen time step, since the energy did not close in longer ones
    starting_energy: float = 0.0  # kinetic, potential and elastic, at the opening [J]
    quiet_since: float | None = None  # since when the particles lie still [s]
    quiet_out: int = 0  # particles that were out by then
    attraction: list[float] = field(default_factory=list)  # of the contacts, at looks so far


class Flow(Protocol):
    """View of an engine that the end of a run is judged by."""

    @property
    def n_particles(self) -> int: ...
    @property
    def n_out(self) -> int: ...
    @property
    def steps(self) -> int: ...
    @property
    def time(self) -> float: ...
    @property
    def time_step(self) -> float: ...
    @property
    def live(self) -> np.ndarray: ...
    @property
    def out_time(self) -> np.ndarray: ...
    def poses(self) -> np.ndarray: ...
    def state_digest(self) -> str: ...


def report_progress(sim: Flow, case: SiloCase, clock: Clock, stages: Stages) -> None:
    """Report how far a discharge is: on the bar by simulated time, as it may end early."""
    stages.report(*discharged(sim, case, clock))
    stages.hedge = hedge(case, sim.n_particles - sim.n_out, _rate(sim, case), sim.time)


def discharged(sim: Flow, case: SiloCase, clock: Clock) -> tuple[str, float, float, str, float]:
    """Stage, its work done and left [particle s], words, and part of the longest time it may take.

    A step costs as much as the particles inside: these leave as fast as they did so far.
    """
    settings, n = case.settings.run, sim.n_particles
    inside = n - sim.n_out
    left = particle_seconds(inside, _rate(sim, case), settings.max_time - sim.time)
    if clock.quiet_since is not None:
        left = min(left, inside * (settings.rest_time - (sim.time - clock.quiet_since)))
    words = f"t = {sim.time:.2f} s of at most {settings.max_time:g} s, {sim.n_out} of {n} out"
    done = (n - 0.5 * sim.n_out) * sim.time
    return "discharging", done, max(left, 0.0), words, sim.time / settings.max_time


def _rate(sim: Flow, case: SiloCase) -> float:
    """Particles that leave in a second: as they did so far, and at first as expected."""
    known = (sim.n_out + _UNTIL_KNOWN * expected_rate(case)) / (sim.time + _UNTIL_KNOWN)
    return max(known, 1e-9)


def ending(sim: Flow, moving: float, case: SiloCase, packing: Packing, clock: Clock) -> str | None:
    """The outcome, once there is one; moving: the normalised kinetic energy (see pour.py)."""
    settings = case.settings.run
    if sim.n_out == sim.n_particles:
        return "empty"
    if at_rest(sim, moving, case, clock):
        if not blocked(sim, case, packing):
            return "dead_zones"
        return "clogged" if sim.n_out >= settings.opening_count else "clogged_at_opening"
    return "time_limit" if sim.time >= settings.max_time - 0.5 * sim.time_step else None


def at_rest(sim: Flow, moving: float, case: SiloCase, clock: Clock) -> bool:
    """True once the particles lie still and none has come out for a while; the clock minds it."""
    settings = case.settings.run
    still = moving < settings.at_rest
    if not still or clock.quiet_since is None or sim.n_out != clock.quiet_out:
        clock.quiet_since, clock.quiet_out = (sim.time if still else None), sim.n_out
        return False
    return sim.time - clock.quiet_since >= settings.rest_time - 0.5 * sim.time_step


def blocked(sim: Flow, case: SiloCase, packing: Packing) -> bool:
    """True where the outline of a particle that stays crosses one of Outline.blocking_lines.

    Of outlets in the side there is none.
    """
    poses, kinds = sim.poses()[sim.live], packing.kinds[sim.live]
    return any(
        (
            crosses_line(poses[:, 0], poses[:, 2], kinds, case.shapes.shapes, x)
            & (poses[:, 1] >= low) & (poses[:, 1] <= high)
        ).any()
        for x, low, high in case.outline.blocking_lines
    )  # fmt: skip


def crosses_line(
    x: ArrayLike, angle: ArrayLike, kind: ArrayLike, shapes: Sequence[Shape], centre: float
) -> NDArray[np.bool_]:
    """Mask (n,) of the particles whose outlines meet the vertical line x = centre [m].

    x        of the centroids (n,) [m]; angle of the particles (n,) [rad]
    kind     which of the shapes each particle has (n,)

    Exact: a rounded outline reaches as far as its furthest core vertex and the spheroradius.
    """
    x, angle, kind = np.asarray(x), np.asarray(angle), np.asarray(kind)
    crosses = np.zeros(len(x), dtype=bool)
    for k, shape in enumerate(shapes):
        which = kind == k
        rotated = np.cos(angle[which]), -np.sin(angle[which])
        extent = x[which, None] + np.stack(rotated, axis=1) @ shape.core.T
        left, right = extent.min(axis=1), extent.max(axis=1)
        crosses[which] = (left - shape.spheroradius <= centre) & (
            centre <= right + shape.spheroradius
        )
    return crosses
