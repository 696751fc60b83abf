"""A bed of particles in motion: the only caller of the kernels."""

import hashlib
from collections.abc import Sequence

import numpy as np

from damper3d.engine import sampling, state
from damper3d.engine.integrate import advance_together, enclosure_at
from damper3d.engine.motions import Turning, host
from damper3d.engine.motions.turning import without_shaker
from damper3d.engine.multisphere.form import key_of_pair
from damper3d.engine.records import CLASSES, IMPACTS, MECHANISMS
from damper3d.engine.shared.steps import SharedSteps, one_thread_only
from damper3d.engine.state import (
    DONE,
    INNER_FULL,
    NOT_FINITE,
    OUTER_FULL,
    TOO_DEEP,
    WALL_FULL,
    World,
)
from damper3d.engine.walls import put_back
from damper3d.engine.world import kind_of, lengthened
from granulab.contact.compiled.threads import Crew, crew_of
from granulab.errors import SimulationError

_AT_A_TIME = 5_000_000  # spheres times steps of a call of the kernels: some tenths of a second
# Of each class in the kernels' balance, in their order (state.py).
_BOOKS = (*MECHANISMS, "law_term", "slip_count")
_FULL = {OUTER_FULL: "outer", INNER_FULL: "inner", WALL_FULL: "wall"}
_COLUMNS = {
    "time": state.TIME,
    "displacement": state.DISPLACEMENT,
    "velocity": state.VELOCITY,
    "kinetic": state.KINETIC,
    "potential": state.POTENTIAL,
    "elastic_normal": state.ELASTIC_NORMAL,
    "elastic_tangential": state.ELASTIC_TANGENTIAL,
    "contacts_particle_particle": state.CONTACTS_PP,
    "contacts_particle_wall": state.CONTACTS_PW,
    "impact_speed_particle_particle": state.IMPACT_PP,
    "impact_speed_particle_wall": state.IMPACT_PW,
    "wall_work": state.N_COLUMNS + state.WALL_WORK,
} | {
    f"{mechanism}_{name}": state.N_COLUMNS + c * state.N_MECHANISMS + m
    for c, name in enumerate(CLASSES)
    for m, mechanism in enumerate(_BOOKS)
}
_OF_IMPACTS = {
    name: column + c
    for c, pair in enumerate(CLASSES)
    for name, column in zip(IMPACTS[pair], (state.BEGUN_PP, state.BEYOND_PP), strict=True)
}
_OF_HOST = {
    "host_energy": host.HOST_ENERGY,
    "host_work": host.HOST_WORK,
    "host_damping": host.HOST_DAMPING,
}


class Simulation:
    """A world of particles, and what one may ask of it.

    Positions that it gives are relative to the enclosure.
    """

    def __init__(self, world: World, steps_per_sample: int = 1) -> None:
        self.world = world
        self.steps_per_sample = steps_per_sample
        self._kind = kind_of(world)
        self._first = self._kind.first_sphere_of_each(world)
        self._counts_impacts = True  # but in a run that an earlier version began
        self._crew: Crew | None = None
        self._shared: SharedSteps | None = None

    @property
    def n_particles(self) -> int:
        """Return how many particles there are."""
        return len(self.world.particles.inverse_mass)

    @property
    def steps(self) -> int:
        """Steps taken in this phase."""
        return int(self.world.counts[state.STEP])

    @property
    def time(self) -> float:
        """Time since the phase began [s]."""
        return self.steps * self.world.time_step

    @property
    def mass(self) -> np.ndarray:
        """Of each particle (n,) [kg]."""
        return 1.0 / self.world.particles.inverse_mass

    def run(self, n_samples: int) -> dict[str, np.ndarray]:
        """Go on for a number of samples; their columns, a row a sample.

        Times, displacement and velocity of the enclosure, energies [J], dissipation by mechanism
        and class [J], impact speeds [m/s], contacts; wall_force (n, n_walls, 3) [N], mean over
        the sample; mean_position and mean_velocity (n, 3). Energies that were dissipated, and
        wall_work, are since the phase began. Raises SimulationError where the state is no longer
        finite or an overlap is beyond belief.
        """
        rows = self.room(n_samples)
        self.fill(rows)
        if not np.isfinite(rows).all():
            raise self.failure("the state is no longer finite")
        return self.named(rows)

    def fill(self, rows: np.ndarray) -> None:
        """Go on by a sample for each row of `room`, and write them."""
        done, at_a_time = 0, self.steps_at_a_time() // self.steps_per_sample
        while done < len(rows):
            if not at_a_time:  # a sample takes long
                self.end_sample(rows[done], 0)
                done += 1
                continue
            filled, over, outcome = self._fill(self.steps_per_sample, rows[done : done + at_a_time])
            done += filled
            if outcome != DONE:  # in the middle of a sample: make room, and go on to its end
                self.answer(outcome)
                self.end_sample(rows[done], over)
                done += 1

    def share(self, n_threads: int) -> int:
        """Let so many threads share the steps from now on; how many do, with the same bits.

        Not more than the bed has parts, and one where something in it keeps the others out
        (shared.steps.one_thread_only).
        """
        n_threads = min(n_threads, state.most_threads(self.world.parts))
        if one_thread_only(self.world):
            n_threads = 1
        self._crew, self._shared = crew_of(n_threads), None
        return self.n_threads

    @property
    def n_threads(self) -> int:
        """Threads that share a step; a motion that began since `share` may keep others out."""
        return self._crew.n_threads if self._crew and not one_thread_only(self.world) else 1

    def _by_threads(self) -> SharedSteps | None:
        """Return what shares the steps of the world as it is; None where one thread takes them."""
        if self.n_threads == 1:
            return None
        if self._shared is None or self._shared.world is not self.world:
            self._shared = SharedSteps(self.world, self._crew, self._first)
        return self._shared

    def _fill(self, n_steps: int, rows: np.ndarray) -> tuple[int, int, int]:
        """See sampling.advance_sampling."""
        if shared := self._by_threads():
            return shared.fill(n_steps, rows)
        return sampling.advance_sampling(self.world, n_steps, rows)

    def room(self, n_samples: int) -> np.ndarray:
        """Room for samples."""
        own = host.N_HOST_COLUMNS if self._host else 0
        n_walls = len(self.world.walls.force)
        return np.zeros((n_samples, state.N_COLUMNS + state.N_BALANCE + 3 * n_walls + own))

    @property
    def _of_walls(self) -> slice:
        """Return the columns of a sample that are forces on the walls."""
        first = state.N_COLUMNS + state.N_BALANCE
        return slice(first, first + 3 * len(self.world.walls.force))

    @property
    def _host(self) -> host.Host | None:
        """Return the host that the enclosure rides on, if it does."""
        shaker = self.world.shaker
        shaker = shaker.arc if isinstance(shaker, Turning) else shaker
        return shaker if isinstance(shaker, host.Host) else None

    def named(self, rows: np.ndarray) -> dict[str, np.ndarray]:
        """The columns of samples by name."""
        named = {name: rows[:, column].copy() for name, column in _COLUMNS.items()}
        named["mean_position"] = rows[:, state.POSITION_X : state.VELOCITY_X].copy()
        named["mean_velocity"] = rows[:, state.VELOCITY_X : state.N_COLUMNS].copy()
        own, n_walls = self._of_walls.stop, len(self.world.walls.force)
        named["wall_force"] = rows[:, self._of_walls].copy().reshape(len(rows), n_walls, 3)
        if self._counts_impacts:
            named |= {name: rows[:, column].copy() for name, column in _OF_IMPACTS.items()}
        if self._host:
            named |= {name: rows[:, own + k].copy() for name, k in _OF_HOST.items()}
        return named

    def steps_at_a_time(self) -> int:
        """Steps of a call of the kernels, which hear no Ctrl-C."""
        return max(_AT_A_TIME // len(self.world.spheres.inverse_mass), 1)

    def end_sample(self, row: np.ndarray, taken: int) -> None:
        """Go on to the end of a sample of which so many steps are taken, and write it."""
        self.step(self.steps_per_sample - taken)
        self.write_sample(row)

    def write_sample(self, row: np.ndarray) -> None:
        """Write the sample of now, whose last steps are taken; SimulationError if not finite."""
        self._look(row[np.newaxis])
        row[self._of_walls] /= self.steps_per_sample
        if not np.isfinite(row).all():
            raise self.failure("the state is no longer finite")

    def step(self, n_steps: int) -> None:
        """Go on for a number of steps; raises as run does."""
        at_a_time, no_rows = self.steps_at_a_time(), self.room(0)
        while n_steps:
            _, taken, outcome = self._fill(min(n_steps, at_a_time), no_rows)
            n_steps -= taken
            if outcome != DONE:
                self.answer(outcome)

    def sample(self) -> dict[str, np.ndarray]:
        """One row of samples for the state as it is; forces on the walls are not known."""
        rows = self.room(1)
        self._look(rows)
        return self.named(rows)

    def compile(self) -> None:
        """Compile or load the kernels now, so that their time is not taken for a step's."""
        self._fill(0, self.room(0))

    def refresh(self) -> None:
        """Make stale lists again now."""
        if self._lists_are_stale:
            self._look(self.room(0))

    @property
    def _lists_are_stale(self) -> bool:
        return bool(self.world.counts[[state.STALE_INNER, state.STALE_WALL]].any())

    def _look(self, rows: np.ndarray) -> None:
        """Make stale lists again, and write the sample of now to rows, of one or none.

        Forces on the walls are sums there, over the steps since the last sample.
        """
        while True:
            if self._shared and self._lists_are_stale:
                self._shared.give_up_lists()
            if self.n_threads > 1:  # who take their steps by another kernel
                outcome = sampling.look(self.world, rows)
            else:
                _, _, outcome = sampling.advance_sampling(self.world, 0, rows)
            if outcome == DONE:
                return
            self.answer(outcome)

    def _place(self) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Displacement [m] and velocity [m/s] of the enclosure now."""
        return enclosure_at(self.world.shaker, self.world.direction, self.time)

    def answer(self, outcome: int) -> None:
        """Give a search the room that it lacked, or raise what is wrong."""
        if outcome in _FULL:
            self.world = lengthened(self.world, _FULL[outcome])
        elif outcome == NOT_FINITE:
            raise self.failure("a position is no longer a finite number")
        elif outcome == TOO_DEEP:
            cure = "a shorter --time-step, or a higher --youngs-modulus against soft contacts"
            raise self.failure("an overlap reached half a radius", cure)
        else:
            raise AssertionError(outcome)

    def failure(self, what: str, cure: str = "a shorter --time-step") -> SimulationError:
        """An error that says what happened, when, and what to try."""
        return SimulationError(
            f"the simulation failed at t = {self.time:.6f} s, in steps of "
            f"{self.world.time_step * 1e6:g} us: {what}; try {cure}"
        )

    def frame(self) -> dict[str, np.ndarray]:
        """The particles now: x (n, 3) in the enclosure [m], v (n, 3) in the laboratory [m/s].

        Also spin (n, 3) [rad/s], heat (n,) [J], half of what their contacts dissipated so far, and
        of multi-sphere particles the orientations (n, 4), unit quaternions (w, x, y, z).
        """
        moving = self._kind.moving(self.world)
        rotated = {name: moving[name].copy() for name in ("orientation",) if name in moving}
        return {
            "x": moving["position"][:, :3] - np.array(self._place()[0]),
            "v": moving["velocity_now"][:, :3].copy(),
            "spin": self._kind.angular_velocity_now(self.world)[:, :3].copy(),
            **rotated,
            "heat": self._summed(self.world.particles.dissipated[:-1]),
        }

    def _summed(self, of_spheres: np.ndarray) -> np.ndarray:
        """Sums over the spheres of each particle (n,)."""
        if np.ptp(np.diff(self._first)) == 0:  # a sum by rows, which has other bits
            return of_spheres.reshape(self.n_particles, -1).sum(axis=1)
        return np.add.reduceat(of_spheres, self._first[:-1])

    def _places(self, spheres: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The particles of spheres, by number, and which of its spheres each is."""
        whose = np.searchsorted(self._first, spheres, "right") - 1
        return whose, spheres - self._first[whose]

    def contacts(self) -> dict[str, np.ndarray]:
        """The n contacts of now, with the forces that the next step will apply.

        Contacts are those of spheres: two multi-sphere particles may have several.

        particles     (n, 2) particles, then walls (numbered after them)
        spheres    (n, 2) which of their spheres touch; 0 of a wall
        force      (n, 3) on the second [N]; the first takes its opposite
        normal     (n, 3) unit vector towards the second
        point      (n, 3) where the force acts, in the laboratory [m]
        overlap    (n,) [m]
        """
        self.refresh()
        most = int(self.world.counts[state.INNER] + self.world.counts[state.WALL])
        spheres = np.zeros((most, 2), np.uint32)
        numbers = np.zeros((most, sampling.N_CONTACT_COLUMNS))
        n = sampling.list_contacts(without_shaker(self.world), *self._place(), spheres, numbers)
        which, m = spheres[:n].astype(np.int64), len(self.world.spheres.inverse_mass)
        of_wall = which >= m
        whose, own = self._places(which)
        return {
            "bodies": np.where(of_wall, which - m + self.n_particles, whose).astype(np.uint32),
            "spheres": np.where(of_wall, 0, own).astype(np.uint32),
            "force": numbers[:n, sampling.FORCE : sampling.NORMAL],
            "normal": numbers[:n, sampling.NORMAL : sampling.POINT],
            "point": numbers[:n, sampling.POINT : sampling.OVERLAP],
            "overlap": numbers[:n, sampling.OVERLAP],
        }

    def top(self, up: np.ndarray) -> float:
        """The largest up . x of any particle's surface, in the enclosure [m]; up (3,) is a unit."""
        return float((self.frame()["x"] @ up + self._kind.extents(self.world, up)).max())

    def set_velocity(
        self, velocity: np.ndarray, angular_velocity: np.ndarray | None = None
    ) -> None:
        """Give the particles velocities (n, 3) [m/s], and angular velocities (n, 3) [rad/s]."""
        moving = self._kind.moving(self.world)
        moving["velocity"][:, :3] = moving["velocity_now"][:, :3] = velocity
        if angular_velocity is not None:
            self._kind.set_angular_velocity(self.world, angular_velocity)
        self.world.counts[[state.STALE_INNER, state.STALE_WALL]] = 1  # spheres have velocities too

    def save(self) -> dict[str, np.ndarray]:
        """All that is needed to go on with the same bits, as arrays.

        Of the lists only the contacts' histories are kept: the rest is made again in the same
        order, and no force depends on when.
        """
        self.refresh()  # of a state just restored, the lists are not yet made
        world = self.world
        pairs = _touching(world.inner, int(world.counts[state.INNER]))
        at_walls = _touching(world.wall, int(world.counts[state.WALL]))
        of_wall = np.searchsorted(world.walls.first, at_walls, "right") - 1
        of_wall = of_wall + world.wall.feature[at_walls]  # of triangles, which are one wall
        rolled = {}
        if world.walls.rolling is not None:
            rolled = {"rolled": world.inner.rolling[pairs].T,
                      "wall_rolled": world.wall.rolling[at_walls].T}  # fmt: skip
        return {
            **self._save_particles(),
            **rolled,
            "heat": world.particles.dissipated.copy(),
            "pairs": np.stack([world.inner.i[pairs], world.inner.j[pairs]], axis=1),
            "springs": world.inner.history[pairs].T,
            "wall_pairs": np.stack([world.wall.i[at_walls], of_wall], axis=1),
            "wall_springs": world.wall.history[at_walls].T,
            "wall_force": world.walls.force.copy(),
            "step": world.counts[[state.STEP]],
            "books": world.balance.copy(),
            "impacts": world.impacts[:, : state.YIELD].copy(),
            **{f"host_{name}": array.copy() for name, array in self._of_host().items()},
        }

    def _of_host(self) -> dict[str, np.ndarray]:
        """The arrays of the enclosure's host that steps change."""
        return {name: getattr(self._host, name) for name in host.CHANGING} if self._host else {}

    def _save_particles(self) -> dict[str, np.ndarray]:
        return {name: array.copy() for name, array in self._kind.moving(self.world).items()}

    def restore(self, saved: dict[str, np.ndarray]) -> None:
        """Put back what `save` gave."""
        self._restore_particles(saved)
        if self._shared:
            self._shared.give_up_lists()
        self.world.counts[:] = 0
        self._restore_pairs(saved["pairs"], saved["springs"].T, saved.get("rolled"))
        world = self.world
        world.particles.dissipated[:] = saved["heat"]
        world.lengths[state.OUTER_SKIN] = -1.0  # its cutoff is used up: it is made again
        world.walls.history[:] = 0.0
        world.walls.history[..., state.DAMPING] = state.NO_CONTACT
        touching, of_wall = saved["wall_pairs"].T
        put_back(world.walls, touching, of_wall, saved["wall_springs"].T)
        if world.walls.rolling is not None:
            world.walls.rolling[:] = 0.0
            row = of_wall * world.walls.history.shape[1] + touching
            world.walls.rolling[row] = saved["wall_rolled"].T
        world.walls.force[:] = saved["wall_force"]
        world.counts[state.STEP] = saved["step"][0]
        world.counts[[state.STALE_INNER, state.STALE_WALL]] = 1
        world.balance[:] = saved["books"]
        self._counts_impacts = "impacts" in saved
        if self._counts_impacts:
            world.impacts[:, : state.YIELD] = saved["impacts"]
        else:
            world.impacts[:, state.FASTEST] = saved["fastest"]
        for name, array in self._of_host().items():
            array[:] = saved[f"host_{name}"]

    def _restore_particles(self, saved: dict[str, np.ndarray]) -> None:
        for name, array in self._kind.moving(self.world).items():
            array[:] = saved[name]
        self._kind.settle(self.world)

    def _restore_pairs(
        self, pairs: np.ndarray, histories: np.ndarray, rolled: np.ndarray | None
    ) -> None:
        """Give the next list the pairs in contact (n, 2) and their histories, by their keys."""
        while len(self.world.kept.key) < len(pairs):
            self.world = lengthened(self.world, "inner")
        kept, n = self.world.kept, len(pairs)
        most = int(np.diff(self._first).max())
        (a, b), (p, q) = (part.T for part in self._places(pairs.astype(np.int64)))
        kept.key[:n] = key_of_pair.py_func(most, self.n_particles, a, p, b, q)
        kept.history[:n] = histories
        if rolled is not None:
            kept.rolling[:n] = rolled.T
        kept.number[0] = n

    def begin_phase(self, **changes) -> None:
        """Change fields of the world (shaker, gravity, time_step, laws); clock and balance start.

        Positions stay where they are in the enclosure, which was at zero.
        """
        self.refresh()
        self.world = self.world._replace(**changes)
        if any(shift := enclosure_at(self.world.shaker, self.world.direction, 0.0)[0]):
            self._kind.moving(self.world)["position"][:, :3] += shift
        self.world.counts[[state.STEP, state.INNER_MADE, state.WALL_MADE]] = 0
        self.world.counts[[state.STALE_INNER, state.STALE_WALL]] = 1
        self.world.balance[:] = 0.0
        self.world.impacts[:, : state.YIELD] = 0.0
        self._counts_impacts = True
        self.world.walls.force[:] = 0.0
        self.world.particles.dissipated[:] = 0.0

    def state_digest(self) -> str:
        """Hash of positions, velocities and the histories of the contacts."""
        saved = self.save()
        text = hashlib.sha256()
        contacts = ("pairs", "springs", "wall_pairs", "wall_springs", "rolled", "wall_rolled")
        named = [name for name in contacts if name in saved]
        for name in (*self._moved(), *named, *(f"host_{name}" for name in self._of_host())):
            text.update(np.ascontiguousarray(saved[name]).tobytes())
        return text.hexdigest()[:16]

    def _moved(self) -> list[str]:
        """The saved arrays that say how the particles move; the others follow from them."""
        return [name for name in self._kind.moving(self.world) if not name.endswith("_now")]


def _touching(contacts: state.Contacts, n: int) -> np.ndarray:
    """Return which of the first n contacts of a list touch."""
    return np.flatnonzero(contacts.history[:n, state.DAMPING] >= 0.0)


class Together:
    """Beds of dampers that go on step by step together, on one host; or a single bed."""

    def __init__(self, beds: Sequence[Simulation]) -> None:
        self.beds = list(beds)

    def run(self, n_samples: int) -> list[dict[str, np.ndarray]]:
        """Go on for a number of samples; of each bed their columns, as Simulation.run has them."""
        if len(self.beds) == 1:
            return [self.beds[0].run(n_samples)]
        rows = [bed.room(n_samples) for bed in self.beds]
        for k in range(n_samples):
            self.step(self.beds[0].steps_per_sample)
            for bed, own in zip(self.beds, rows, strict=True):
                bed.write_sample(own[k])
        return [bed.named(own) for bed, own in zip(self.beds, rows, strict=True)]

    def step(self, n_steps: int) -> None:
        """Go on for a number of steps; raises as Simulation.run does."""
        at_a_time = max(min(bed.steps_at_a_time() for bed in self.beds) // len(self.beds), 1)
        while n_steps:
            worlds = tuple(bed.world for bed in self.beds)
            taken, outcome, which = advance_together(worlds, min(n_steps, at_a_time))
            n_steps -= taken
            if outcome != DONE:
                self.beds[which].answer(outcome)

    def compile(self) -> None:
        """Compile or load the kernels now; see Simulation.compile."""
        for bed in self.beds:
            bed.compile()
        if len(self.beds) > 1:
            advance_together(tuple(bed.world for bed in self.beds), 0)
