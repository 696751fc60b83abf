"""Discharge from the opening of the door to the end: frames, checkpoints, when to stop."""

import dataclasses
import math
import time
from collections.abc import Callable

import numpy as np

from granulab.campaign.runs.checkpoint import keep_checkpoint
from granulab.campaign.runs.folder import RunFolder
from granulab.campaign.runs.stages import Stages
from granulab.campaign.runs.trajectory import TrajectoryWriter
from granulab.contact.attraction import Attraction
from granulab.errors import InputError, Stopped
from silo2d.case.case import SiloCase
from silo2d.engine import state
from silo2d.engine.simulation import Simulation
from silo2d.run.beds.acts import Acts, equip
from silo2d.run.ending import (
    ENERGY_TOLERANCE,
    LOOK,
    Clock,
    Flow,
    discharged,
    ending,
    report_progress,
)
from silo2d.run.packing import Packing
from silo2d.run.pour import normalised_kinetic_energy
from silo2d.run.rest import Rest

LONGEST_LOOK = 4_000_000  # particles times steps between looks whether to stop

_NEXT_TO_NOTHING, _ROUNDING = 1e-3, 1e-9  # of the energy at the opening


def discharge(
    sim: Simulation,
    case: SiloCase,
    packing: Packing,
    folder: RunFolder,
    writer: TrajectoryWriter,
    clock: Clock,
    stages: Stages,
    stop: Callable[[], bool],
    rest: Rest | None = None,
) -> str:
    """Run to the end and return the outcome: open the door first, unless going on.

    rest: what was borne before, which comes with the first frame.

    Looks, frames, samples at the walls and checkpoints come at fixed numbers of steps since the
    opening; the first and the last frame bring the contacts, and of those between every so many.
    Raises Stopped when `stop` says so, with the state kept, and SimulationError.
    """
    if clock.parts == 0:
        _open_door(sim, case, packing, writer, clock, rest)
        _keep(sim, folder, writer, clock)
    output = case.settings.output
    each, touch = case.intervals
    intervals = (LOOK, each, output.checkpoint_interval)
    look, frame, keep = (max(round(interval / sim.time_step), 1) for interval in intervals)
    every = [look, frame, keep, max(LONGEST_LOOK // sim.n_particles, 1)]
    sample = output.wall_interval and max(round(output.wall_interval / sim.time_step), 1)
    every += [sample] if sample else []
    acts = Acts.of(case, packing, sim)
    contacts = frame * max(round(touch / each), 1)
    stages.begin(*discharged(sim, case, clock)[:3])
    while True:
        now = sim.steps
        target = min(*(now - now % n + n for n in every), *acts.next(now))
        began = time.process_time()
        sim.run(target - now)
        clock.cpu_s += time.process_time() - began
        acts.act(sim)
        outcome = _look(sim, case, packing, clock, acts) if target % look == 0 else None
        if sample and target % sample == 0:
            sim.sample_walls()
        if target % frame == 0 or outcome:
            touches = contacts_of(sim) if target % contacts == 0 or outcome else {}
            if samples := sim.wall_samples():
                touches["walls"] = samples
            writer.append(frame_of(sim, sim.wall_forces()), touches)
        if outcome:
            return outcome
        if target % keep == 0:
            _keep(sim, folder, writer, clock)
        report_progress(sim, case, clock, stages)
        if stop():
            _keep(sim, folder, writer, clock)
            raise Stopped(f"go on with: {folder.go_on('silo2d')}")


def _open_door(
    sim: Simulation, case: SiloCase, packing: Packing, writer: TrajectoryWriter, clock: Clock,
    rest: Rest | None,
) -> None:  # fmt: skip
    """t = 0: friction on, the door away or on its way; the first frame has the forces before."""
    forces, touches = sim.wall_forces(), contacts_of(sim)
    if rest is not None and rest.time:
        touches |= rest.tables(sim, forces)
    open_door(sim, case, packing, clock)
    writer.append(frame_of(sim, forces), touches)


def open_door(sim: Simulation, case: SiloCase, packing: Packing, clock: Clock) -> None:
    """t = 0: the laws of the discharge, the door away or on its way."""
    held = bool(case.settings.fill.friction)
    sim.begin_phase(*case.laws(sim.n_particles), sim.time_step, keep_slips=held)
    doors, speed = case.outline.walls().doors, case.settings.run.door_speed
    equip(sim, case, packing)
    if case.settings.flow.feed_rate is not None:
        pass  # it stays closed
    elif speed is None:
        for door in doors:
            sim.remove_wall(door)
        sim.world.account[state.CARRIED_OUT] = 0.0  # of the doors: not of the discharge
    else:
        sim.draw_door(doors[-1], speed)
    # With what the springs of contacts with the door held: that counts as friction already.
    clock.starting_energy = _energy(sim.energies()) + _dissipated(sim)


def _keep(sim: Simulation, folder: RunFolder, writer: TrajectoryWriter, clock: Clock) -> None:
    clock.parts = writer.flush()
    keep_checkpoint(folder, clock.parts, sim.save(), dataclasses.asdict(clock))


def _look(
    sim: Simulation, case: SiloCase, packing: Packing, clock: Clock, acts: Acts
) -> str | None:
    """The outcome, once there is one. Raises SimulationError where the energy balance is off."""
    # Nothing is at rest while the door is closed, however slow the particles are.
    moving = math.inf if acts.closed(sim.steps) else motion(sim, case)
    outcome = ending(sim, moving, case, packing, clock)
    attraction = Attraction(*clock.attraction)
    attraction.look(sim.contacts())
    clock.attraction = list(dataclasses.astuple(attraction))
    # While next to nothing is dissipated, a part of what there is to dissipate is the measure;
    # at the end nothing but rounding counts beside it.
    check_energy_balance(sim, case, clock, _ROUNDING if outcome else _NEXT_TO_NOTHING)
    check_rim(sim, case)  # after that, as a simulation that fails throws particles, too
    return outcome


def check_rim(sim: Flow, case: SiloCase) -> None:
    """Raise InputError where a particle left over the open top: it would count as discharged.

    It is beside the silo, and higher than what falls there out of an outlet in the side.
    """
    outline, shaken = case.outline, case.settings.flow.vibration_amplitude or 0.0
    outlets = max((float(ends[:, 1].max()) for ends in outline.outlets), default=0.0)
    x, y = sim.poses()[sim.live, :2].T
    sides = outline.polygon[:, 0]
    beside = np.maximum(sides.min() - x, x - sides.max()) > shaken
    over = beside & (y > outlets + shaken + (2 * case.shapes.bounding_radius if outlets else 0.0))
    if over.any():
        raise InputError(
            f"{case.name}: [silo] height = {outline.height * 1e3:g} mm: particles leave over the "
            f"open top ({over.sum()} by t = {sim.time:.3g} s), where they are not discharged; give "
            "a higher silo"
        )


def motion(sim: Simulation, case: SiloCase) -> float:
    """Normalised kinetic energy; nothing is at rest while door or walls move, however slow."""
    moves = sim.door_moves or case.settings.flow.vibration_amplitude is not None
    return math.inf if moves else normalised_kinetic_energy(sim, case.shapes)


def _energy(table: dict[str, float]) -> float:
    return sum(table[k] for k in ("kinetic", "potential", "elastic_normal", "elastic_tangential"))


def _dissipated(sim: Simulation) -> float:
    return float(sim.world.account[: state.CARRIED_OUT].sum())


def check_energy_balance(
    sim: Simulation, case: SiloCase, clock: Clock, least: float = _NEXT_TO_NOTHING
) -> None:
    """Stop where the energies do not balance, as when the time step is too long.

    least: of the energy at the opening, that is taken for dissipated where less is.
    """
    tolerance, least = ENERGY_TOLERANCE[case.step_source], least * abs(clock.starting_energy)
    table = sim.energies()
    held = _energy(table)
    dissipated = _dissipated(sim)
    gone = table["carried_out"] + table["given_to_door"]
    gained = held + gone + dissipated - clock.starting_energy
    if not abs(gained) < tolerance * max(dissipated, least):
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
        "out_time": sim.out_time,
        "wall_force": wall_force,
        **sim.energies(),
    }
