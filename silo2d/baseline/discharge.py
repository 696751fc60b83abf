"""The baseline: a discharge by pymunk's impulses, from the same packing to the same run folder.

A particle is the same eroded core with a radius, of the same mass and moment; the outline, the
pairs' friction and the criteria for the end are the case's. Otherwise are the contacts: rigid,
with a given restitution instead of springs and dashpots, and solved by a number of iterations.
"""

import hashlib
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from granulab.campaign.runs.stages import Stages
from granulab.campaign.runs.trajectory import TrajectoryWriter
from granulab.contact.jit import njit
from granulab.errors import SimulationError, Stopped
from silo2d.baseline.space import Placed, Surface, add_particle, add_walls, empty_space, strays
from silo2d.case.case import GRAVITY, SiloCase
from silo2d.case.impulses import factors
from silo2d.run.ending import LOOK, Clock, ending, report_progress
from silo2d.run.packing import Packing

if TYPE_CHECKING:
    import pymunk

# Behind the door, without friction, until the impulses that carry the heap are found: each step
# begins with those of the step before. Longer only lets the heap sink into itself.
_WARM_UP = 0.02  # [s]
X, Y, ANGLE, VX, VY, OMEGA = range(6)  # columns of Baseline.motion


class Baseline:
    """The particles of a packing in a pymunk space, behind the closed door, without friction.

    motion       x, y [m], angle [rad], vx, vy [m/s], angular velocity [rad/s] (n_particles, 6)
    out_time     when each centroid passed y = 0 (n_particles,) [s]; NaN before
    live         indices of the particles that are still simulated
    """

    def __init__(self, case: SiloCase, packing: Packing) -> None:
        assert case.impulses is not None  # whose engine is pymunk
        self.time_step = case.impulses.time_step
        self.steps = 0
        self.carried_out = 0.0  # kinetic and potential energy of particles that were dropped [J]
        self._settings, self._outline = case.impulses, case.outline
        shapes = [case.shapes.shapes[kind] for kind in packing.kinds]
        self.mass = case.surface_density * np.array([shape.area for shape in shapes])
        self.moment = case.surface_density * np.array([shape.polar_moment for shape in shapes])
        self._lowest = -np.array([shape.bounding_radius for shape in shapes])
        self._lift = np.sqrt(case.shapes.mean_area)
        self._space = empty_space(self._settings.iterations, self._settings.slop)
        # Of a contact that has parted nothing is kept: pymunk would report its last impulse for
        # three more steps, and the walls' loads would not add up to the momentum given to them.
        self._space.collision_persistence = 1
        elasticity = factors(*self._settings.restitution)
        particle, wall = (Surface(0.0, value) for value in elasticity)
        walls = case.outline.walls()
        self._walls, self._doors = add_walls(self._space, walls.segments, wall), walls.doors
        self._particles = [
            add_particle(self._space, shape, case.surface_density, pose, particle)
            for shape, pose in zip(shapes, packing.poses.tolist(), strict=True)
        ]
        self.motion = np.column_stack([packing.poses, np.zeros((len(shapes), 3))])
        self.out_time = np.full(len(shapes), np.nan)
        self.live = np.arange(len(shapes))
        self._readings = _Readings(self._space, self._walls, self._particles)
        self._load, self._load_steps = np.zeros((len(self._walls), 2)), 0

    @property
    def n_particles(self) -> int:
        """Number of particles, those that have left included."""
        return len(self.mass)

    @property
    def n_out(self) -> int:
        """Number of particles whose centroid has passed y = 0."""
        return int((~np.isnan(self.out_time)).sum())

    @property
    def time(self) -> float:
        """Seconds since the opening, or since the beginning before it."""
        return self.steps * self.time_step

    def poses(self) -> np.ndarray:
        """Position and angle of the particles (n_particles, 3) [m, rad], copied."""
        return self.motion[:, : ANGLE + 1].copy()

    def run(self, n_steps: int) -> None:
        """Advance by n_steps. Raises SimulationError where a particle has passed a wall."""
        for _ in range(n_steps):
            before = self.motion[:, Y].copy()
            self._space.step(self.time_step)
            self.steps += 1
            self._load += self._readings.wall_impulses()
            self._load_steps += 1
            self.motion[self.live] = self._readings.motion()
            if (self.motion[self.live, Y] < 0.0).any():
                self._let_out(before)
        inside = self.motion[self.live]
        lost = strays(self._outline, inside[inside[:, Y] > 0.0, : Y + 1])
        if lost or not np.isfinite(inside).all():
            raise SimulationError(
                f"pymunk lost {lost} particles at t = {self.time:.6f} s, in steps of "
                f"{self.time_step * 1e3:g} ms; give a shorter [pymunk] time_step"
            )

    def _let_out(self, before: np.ndarray) -> None:
        """Note when particles pass y = 0, and drop those that are below it entirely.

        before: heights (n_particles,) [m] a step ago. Not the velocities: those of now are what the
        step's impulses left, while it moved the particles by those before it, and overlaps apart.
        """
        low = self.live[self.motion[self.live, Y] < 0.0]
        new = low[np.isnan(self.out_time[low])]
        y = self.motion[new, Y]
        self.out_time[new] = self.time - self.time_step * y / (y - before[new])
        gone = low[self.motion[low, Y] < self._lowest[low]]
        if len(gone):
            self.carried_out += sum(self._energy(gone))
            for k in gone:
                self._space.remove(*self._particles[k])
            self.live = self.live[~np.isin(self.live, gone)]
            self._readings.expect([self._particles[k] for k in self.live])

    def open_door(self) -> None:
        """Friction on, the door away, and the clock at zero."""
        particle, wall = factors(*self._settings.friction)
        for placed in self._particles:
            placed.shape.friction = particle
        for placed in self._walls:
            placed.shape.friction = wall
        for door in self._doors:
            self._space.remove(*self._walls[door])
        self.steps = 0

    def wall_forces(self) -> np.ndarray:
        """Mean force on each wall since the last call (n_walls, 2) [N]."""
        mean = self._load / (max(self._load_steps, 1) * self.time_step)
        self._load, self._load_steps = np.zeros_like(self._load), 0
        return mean

    def _energy(self, which: np.ndarray) -> tuple[float, float]:
        """Kinetic and potential energy [J] of some particles."""
        motion, mass = self.motion[which], self.mass[which]
        speed2 = motion[:, VX] ** 2 + motion[:, VY] ** 2
        kinetic = 0.5 * (mass * speed2 + self.moment[which] * motion[:, OMEGA] ** 2).sum()
        return float(kinetic), float(GRAVITY * (mass * motion[:, Y]).sum())

    def energies(self) -> dict[str, float]:
        """Kinetic and potential energy of the live particles, and what was carried out [J]."""
        kinetic, potential = self._energy(self.live)
        return {"kinetic": kinetic, "potential": potential, "carried_out": self.carried_out}

    def normalised_kinetic_energy(self) -> float:
        """Kinetic energy over what lifts each particle by its size, as in pour.py [-]."""
        weight = GRAVITY * self.mass[self.live].sum()
        return self._energy(self.live)[0] / (weight * self._lift) if len(self.live) else 0.0

    def frame(self, wall_force: np.ndarray) -> dict[str, Any]:
        """Frame of a moment, as for the contact law but for what impulses do not give."""
        columns = dict(zip(("x", "y", "angle", "vx", "vy", "spin"), self.motion.T, strict=True))
        inside = np.zeros(self.n_particles, bool)
        inside[self.live] = True
        return {
            "time": self.time,
            "steps": self.steps,
            "n_out": self.n_out,
            **{name: column.astype(np.float32) for name, column in columns.items()},
            "inside": inside,
            "out_time": self.out_time,
            "wall_force": wall_force,
            **self.energies(),
        }

    def state_digest(self) -> str:
        """Hash of positions, orientations, velocities and the times of leaving."""
        text = hashlib.sha256(np.ascontiguousarray(self.motion).tobytes())
        text.update(self.out_time.tobytes())
        return text.hexdigest()[:16]


class _Readings:
    """Reads the motion of all particles, and what the walls carry, in one call each."""

    def __init__(self, space: "pymunk.Space", walls: list[Placed], particles: list[Placed]) -> None:
        from pymunk import batch

        self._space, self._batch = space, batch
        self._bodies, self._contacts = batch.Buffer(), batch.Buffer()
        self._walls = np.array([wall.body.id for wall in walls], dtype=np.uintp)
        self.expect(particles)

    def expect(self, particles: list[Placed]) -> None:
        """Set the particles that are there from now on, in the order of reading."""
        fields = self._batch.BodyFields.BODY_ID
        self._bodies.clear()
        self._batch.get_space_bodies(self._space, fields, self._bodies)
        found = np.frombuffer(self._bodies.int_buf(), dtype=np.uintp).tolist()
        row = {body: k for k, body in enumerate(found)}
        ids = np.array([particle.body.id for particle in particles], dtype=np.uintp)
        self._order = np.array([row[body] for body in ids.tolist()], dtype=np.intp)
        self._number = np.argsort(ids)
        self._ids = ids[self._number]

    def motion(self) -> np.ndarray:
        """x, y, angle, vx, vy, angular velocity of the particles (n, 6)."""
        fields = self._batch.BodyFields
        wanted = fields.POSITION | fields.ANGLE | fields.VELOCITY | fields.ANGULAR_VELOCITY
        self._bodies.clear()
        self._batch.get_space_bodies(self._space, wanted, self._bodies)
        return np.frombuffer(self._bodies.float_buf()).reshape(-1, 6)[self._order]

    def wall_impulses(self) -> np.ndarray:
        """Impulse on each wall in the last step (n_walls, 2) [N s]."""
        fields = self._batch.ArbiterFields
        wanted = fields.BODY_A_ID | fields.BODY_B_ID | fields.TOTAL_IMPULSE
        self._contacts.clear()
        self._batch.get_space_arbiters(self._space, wanted, self._contacts)
        contacts = np.frombuffer(self._contacts.int_buf(), dtype=np.uintp).reshape(-1, 2)
        impulses = np.frombuffer(self._contacts.float_buf()).reshape(-1, 2)
        return _of_walls(contacts, impulses, self._walls, self._ids, self._number)


@njit
def _of_walls(contacts, impulses, walls, ids, number):
    """The sum (n_walls, 2) of the impulses on each wall.

    The impulse of a contact is that on its first body. pymunk gives the contacts in the order of
    addresses in memory, so the impulses are added in the order of the particles.
    """
    load = np.zeros((len(walls), len(ids), 2))
    for n in range(len(contacts)):
        for w in range(len(walls)):
            if contacts[n, 0] == walls[w]:
                load[w, number[np.searchsorted(ids, contacts[n, 1])]] = impulses[n]
            elif contacts[n, 1] == walls[w]:
                load[w, number[np.searchsorted(ids, contacts[n, 0])]] = -impulses[n]
    return load.sum(axis=1)


def discharge_by_impulses(
    sim: Baseline,
    case: SiloCase,
    packing: Packing,
    writer: TrajectoryWriter,
    clock: Clock,
    stages: Stages,
    stop: Callable[[], bool],
) -> str:
    """Run from behind the closed door to the end and return the outcome.

    A space cannot be saved to the same bits: one that is stopped starts from the opening again.
    Raises Stopped when `stop` says so, and SimulationError; the frames are kept before either.
    """
    try:
        _warm_up(sim, writer)
        look, frame = (
            max(round(interval / sim.time_step), 1) for interval in (LOOK, case.intervals[0])
        )
        while True:
            target = min(sim.steps - sim.steps % every + every for every in (look, frame))
            began = time.process_time()
            sim.run(target - sim.steps)
            clock.cpu_s += time.process_time() - began
            seen = target % look == 0
            outcome = (
                ending(sim, sim.normalised_kinetic_energy(), case, packing, clock) if seen else None
            )
            if target % frame == 0 or outcome:
                writer.append(sim.frame(sim.wall_forces()))
            if outcome:
                return outcome
            report_progress(sim, case, clock, stages)
            if stop():
                raise Stopped("a run by pymunk cannot be kept half way: the same command runs it "
                              "again, from the opening")  # fmt: skip
    finally:
        writer.flush()


def _warm_up(sim: Baseline, writer: TrajectoryWriter) -> None:
    """Rest behind the door, then open it; the first frame has the forces just before."""
    steps = max(round(_WARM_UP / sim.time_step), 2)
    sim.run(steps - steps // 2)
    sim.wall_forces()
    sim.run(steps // 2)
    forces = sim.wall_forces()
    sim.open_door()
    writer.append(sim.frame(forces))
