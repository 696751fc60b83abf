"""Discharge from the opening of the door to the end: frames, checkpoints, when to stop."""

import dataclasses
import math
import shlex
import time
from collections.abc import Callable

import numpy as np

from granulab.campaign.runs.checkpoint import save_checkpoint
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.protocol import Progress
from granulab.campaign.runs.trajectory import TrajectoryWriter
from granulab.errors import Stopped
from silo2d.case.case import SiloCase
from silo2d.engine import state
from silo2d.engine.simulation import Simulation
from silo2d.run.ending import ENERGY_TOLERANCE, LOOK, Clock, ending, report_progress
from silo2d.run.packing import Packing
from silo2d.run.pour import normalised_kinetic_energy


def discharge(
    sim: Simulation,
    case: SiloCase,
    packing: Packing,
    folder: RunFolder,
    writer: TrajectoryWriter,
    clock: Clock,
    progress: Progress,
    stop: Callable[[], bool],
) -> str:
    """Run to the end and return the outcome: open the door first, unless going on.

    Looks, frames and checkpoints come at fixed numbers of steps since the opening; the first and
    the last frame bring the contacts, and of those between every so many. Raises Stopped when
    `stop` says so, and SimulationError; the state is kept before either.
    """
    if clock.parts == 0:
        _open_door(sim, case, writer, clock)
        _keep(sim, folder, writer, clock)
    output = case.settings.output
    intervals = (LOOK, output.frame_interval, output.checkpoint_interval)
    look, frame, keep = (max(round(interval / case.time_step), 1) for interval in intervals)
    contacts = frame * max(round(output.contact_interval / output.frame_interval), 1)
    while True:
        now = sim.steps
        target = min(now - now % every + every for every in (look, frame, keep))
        began = time.process_time()
        sim.run(target - now)
        clock.cpu_s += time.process_time() - began
        outcome = _look(sim, case, packing, clock) if target % look == 0 else None
        if target % frame == 0 or outcome:
            touches = contacts_of(sim) if target % contacts == 0 or outcome else {}
            writer.append(frame_of(sim, sim.wall_forces()), touches)
        if outcome:
            return outcome
        if target % keep == 0:
            _keep(sim, folder, writer, clock)
        report_progress(sim, case, clock, progress)
        if stop():
            _keep(sim, folder, writer, clock)
            raise Stopped(f"go on with: silo2d run --resume {shlex.quote(str(folder.path))}")


def _open_door(sim: Simulation, case: SiloCase, writer: TrajectoryWriter, clock: Clock) -> None:
    """t = 0: friction on, the door away or on its way; the first frame has the forces before."""
    forces, touches = sim.wall_forces(), contacts_of(sim)
    held = bool(case.settings.fill.friction)
    sim.begin_phase(*case.laws(sim.n_particles), case.time_step, keep_slips=held)
    door, speed = len(case.outline.walls().names) - 1, case.settings.run.door_speed
    if speed is None:
        sim.remove_wall(door)
    else:
        sim.draw_door(door, speed)
    clock.starting_energy = _energy(sim.energies())
    writer.append(frame_of(sim, forces), touches)


def _keep(sim: Simulation, folder: RunFolder, writer: TrajectoryWriter, clock: Clock) -> None:
    clock.parts = writer.flush()
    save_checkpoint(folder.checkpoint, sim.save(), dataclasses.asdict(clock))


def _look(sim: Simulation, case: SiloCase, packing: Packing, clock: Clock) -> str | None:
    """The outcome, once there is one. Raises SimulationError where the energy balance is off."""
    _check_energy_balance(sim, clock)
    # Nothing is at rest while the door moves, however slow the particles are.
    moving = math.inf if sim.door_moves else normalised_kinetic_energy(sim, case.shapes)
    return ending(sim, moving, case, packing, clock)


def _energy(table: dict[str, float]) -> float:
    return sum(table[k] for k in ("kinetic", "potential", "elastic_normal", "elastic_tangential"))


def _check_energy_balance(sim: Simulation, clock: Clock) -> None:
    """Stop where the energies do not balance, as when the time step is too long."""
    table = sim.energies()
    held = _energy(table)
    dissipated = float(sim.world.account[: state.CARRIED_OUT].sum())
    gone = table["carried_out"] + table["given_to_door"]
    gained = held + gone + dissipated - clock.starting_energy
    # While next to nothing is dissipated, a part of what there is to dissipate is the measure.
    if not abs(gained) < ENERGY_TOLERANCE * max(dissipated, 0.01 * abs(clock.starting_energy)):
        whither = "came from nowhere" if gained > 0 else "went nowhere"
        raise sim.failure(f"{abs(gained):.3g} J of energy {whither}")


def contacts_of(sim: Simulation) -> dict[str, dict[str, np.ndarray]]:
    """The table of a moment's contacts as it is kept, in single precision."""
    contacts = sim.contacts()
    single = {k: contacts[k].astype(np.float32) for k in ("point", "force", "normal", "overlap")}
    return {"contacts": {"bodies": contacts["bodies"], **single, "slides": contacts["slides"]}}


def frame_of(sim: Simulation, wall_force: np.ndarray) -> dict[str, np.ndarray | float | int]:
    """Frame of a moment: particles (single precision will do), counts, energies, forces."""
    rows = sim.rows.astype(np.float32)
    inside = np.zeros(sim.n_particles, bool)
    inside[sim.live] = True
    columns = {
        "x": state.X, "y": state.Y, "angle": state.ANGLE,
        "vx": state.UX, "vy": state.UY, "spin": state.UOMEGA,
    }  # fmt: skip
    return {
        "time": sim.time,
        "steps": sim.steps,
        "n_out": sim.n_out,
        **{name: rows[:, column] for name, column in columns.items()},
        "inside": inside,
        "out_time": sim.world.bodies.out_time[: sim.n_particles],
        "wall_force": wall_force,
        **sim.energies(),
    }
