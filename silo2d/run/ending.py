"""End of a discharge, whichever engine moves the particles, and what it remembers."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from granulab.campaign.runs.protocol import Progress
from silo2d.case.case import SiloCase
from silo2d.case.shape import Shape
from silo2d.run.packing import Packing

LOOK = 0.01  # [s] between looks for the end of the run, whatever the output
# Energy that may be unaccounted for, over the dissipated: at 5 us the published runs leave 0.2 to
# 0.4 %, and more means that the step is too long for what happens.
ENERGY_TOLERANCE = 0.05


@dataclass
class Clock:
    """State of a run besides the world: kept in the checkpoint."""

    parts: int = 0  # files of the trajectory that belong to the checkpoint
    cpu_s: float = 0.0  # CPU time of the discharge's step loop
    filling_cpu_s: float = 0.0  # CPU time of filling and settling
    starting_energy: float = 0.0  # kinetic, potential and elastic, at the opening [J]
    quiet_since: float | None = None  # since when the particles lie still [s]
    quiet_out: int = 0  # particles that were out by then


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
    def live(self) -> np.ndarray: ...
    def poses(self) -> np.ndarray: ...
    def state_digest(self) -> str: ...


def report_progress(sim: Flow, case: SiloCase, clock: Clock, progress: Progress) -> None:
    """Report how far a discharge is."""
    settings = case.settings.run
    fraction = max(sim.n_out / sim.n_particles, sim.time / settings.max_time)
    if clock.quiet_since is not None:
        fraction = max(fraction, (sim.time - clock.quiet_since) / settings.rest_time)
    progress(fraction, f"t = {sim.time:.2f} s, {sim.n_out} of {sim.n_particles} out")


def ending(sim: Flow, moving: float, case: SiloCase, packing: Packing, clock: Clock) -> str | None:
    """The outcome, once there is one; moving: the normalised kinetic energy (see pour.py)."""
    settings = case.settings.run
    if sim.n_out == sim.n_particles:
        return "empty"
    still = moving < settings.at_rest
    if not still or clock.quiet_since is None or sim.n_out != clock.quiet_out:
        clock.quiet_since, clock.quiet_out = (sim.time if still else None), sim.n_out
    elif sim.time - clock.quiet_since >= settings.rest_time - 0.5 * case.time_step:
        return _at_rest(sim, case, packing)
    return "time_limit" if sim.time >= settings.max_time - 0.5 * case.time_step else None


def _at_rest(sim: Flow, case: SiloCase, packing: Packing) -> str:
    """Clogged if the outline of a particle that stays crosses the centre line of the outlet."""
    poses, kinds = sim.poses()[sim.live], packing.kinds[sim.live]
    centre = case.outline.outlet_centre
    if not crosses_centre_line(poses[:, 0], poses[:, 2], kinds, case.shapes.shapes, centre).any():
        return "dead_zones"
    return "clogged" if sim.n_out >= case.settings.run.opening_count else "clogged_at_opening"


def crosses_centre_line(
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
