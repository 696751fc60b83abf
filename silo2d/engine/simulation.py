"""The only caller of the kernels: advances a world, reads, saves and restores its state."""

import hashlib
from collections.abc import Sequence

import numpy as np

from granulab.contact.compiled.threads import Crew, crew_of
from granulab.contact.jit import uncounted
from granulab.errors import SimulationError
from silo2d.engine import state
from silo2d.engine.beds.door import move_walls, take_loads
from silo2d.engine.beds.plates import Plates, rub_plates
from silo2d.engine.beds.vibration import Vibration
from silo2d.engine.forces import apply_forces, note_overlapping
from silo2d.engine.integrate import energy_of_contacts, kinetic_energy, move
from silo2d.engine.neighbours import search
from silo2d.engine.pair_law import Law
from silo2d.engine.sampling import (
    FORCE_X,
    FORCE_Y,
    NORMAL_X,
    NORMAL_Y,
    OVERLAP,
    POINT_X,
    POINT_Y,
    SLIDES,
    WallSamples,
    energies,
    list_contacts,
)
from silo2d.engine.shared.steps import SharedSteps
from silo2d.engine.state import DONE, NOT_FINITE, OUTER_FULL, PAIRS_FULL, World
from silo2d.engine.world import longer_lists, more_pairs, with_laws

# Particles times steps of a call of the kernel, which hears no Ctrl-C: a quarter of a second.
_AT_A_TIME = 4_000_000
_SAMPLED = "sampled_"  # begins the names of what checkpoints hold of samples at the walls


@uncounted
def advance(world, n_steps):
    """Take n_steps steps; returns how many were taken and the outcome of the last search.

    Without any, stale lists are made again, in one kernel for both.
    """
    for k in range(max(n_steps, 1)):
        if world.counts[state.STALE] > 0:
            outcome = search(world)
            if outcome != DONE:
                return k, outcome
        if n_steps == 0:
            break
        load = take_loads(world)
        apply_forces(world)
        rub_plates(world, world.plates)
        move(world)
        move_walls(world, load)
    return n_steps, DONE


@uncounted
def look(world):
    """Make stale lists again; the outcome. For who does not compile advance."""
    return search(world)


class Simulation:
    """A world with a clock: run it, read it, save and restore it."""

    def __init__(self, world: World, advice: str = "try a smaller time step or stiffer contacts"):
        self.world = world
        self._advice = advice  # for the one whose simulation fails
        self._wall_steps = 0
        self._samples = WallSamples()
        self._crew: Crew | None = None
        self._shared: SharedSteps | None = None

    @property
    def n_particles(self) -> int:
        """Number of particles, those that have left included."""
        return len(self.world.bodies.live)

    @property
    def n_out(self) -> int:
        """Number of particles whose centroid has passed y = 0."""
        return int(self.world.counts[state.OUT])

    @property
    def door_moves(self) -> bool:
        """True while a door is being drawn."""
        return bool(self.world.counts[state.DOOR])

    @property
    def steps(self) -> int:
        """Steps since the phase began."""
        return int(self.world.counts[state.STEP])

    @property
    def time_step(self) -> float:
        """Length of a step [s]."""
        return float(self.world.time_step)

    @time_step.setter
    def time_step(self, seconds: float) -> None:
        self.world = self.world._replace(time_step=seconds)

    @property
    def time(self) -> float:
        """Seconds since the phase began."""
        return self.steps * self.world.time_step

    @property
    def out_time(self) -> np.ndarray:
        """Times at which the particles passed y = 0 (n_particles,) [s], NaN before."""
        return self.world.bodies.out_time[: self.n_particles]

    @property
    def live(self) -> np.ndarray:
        """Indices of the particles that are still simulated."""
        return self.world.bodies.live[: self.world.counts[state.LIVE]]

    @property
    def rows(self) -> np.ndarray:
        """Rows of the particles (n_particles, 16), columns as in state.py."""
        return self.world.bodies.row[: self.n_particles]

    def poses(self) -> np.ndarray:
        """Position and angle of the particles (n_particles, 3) [m, rad], copied."""
        return self.rows[:, [state.X, state.Y, state.ANGLE]]

    def run(self, n_steps: int) -> None:
        """Advance by n_steps; lists that turn out too short are made longer.

        Raises SimulationError where the state is no longer finite or a vertex is about to pass
        through an edge.
        """
        left, at_a_time = n_steps, max(_AT_A_TIME // max(self.n_particles, 1), 1)
        while left:
            taken, outcome = self._advance(min(left, at_a_time))
            left -= taken
            self._wall_steps += taken
            if outcome != DONE:
                self._resolve(outcome)
        if not np.isfinite(self.rows[self.live]).all():
            raise self.failure("the state is no longer finite")

    def compile(self) -> None:
        """Compile or load the kernels now, so that their time is not taken for a step's."""
        self._advance(0)
        self.energies()
        self.touching()
        self.contacts()

    def share(self, n_threads: int) -> int:
        """Let so many threads share the steps from now on; how many do, with the same bits.

        Not more than the bed has parts; and one as long as plates rub, which needs what presses on
        a particle, summed over all its contacts.
        """
        n_threads = min(n_threads, len(self.world.parts) - 1)
        self._crew, self._shared = crew_of(n_threads), None
        return n_threads if self._crew else 1

    @property
    def _by_threads(self) -> bool:
        return self._crew is not None and self.world.plates is None

    def _advance(self, n_steps: int) -> tuple[int, int]:
        """Take steps, by as many threads as share them; see advance."""
        if not self._by_threads:
            return advance(self.world, n_steps)
        if self._shared is None or self._shared.world is not self.world:
            self._shared = SharedSteps(self.world, self._crew)
        return self._shared.step(n_steps)

    def refresh(self) -> None:
        """Make stale lists again now."""
        while self.world.counts[state.STALE] > 0:
            if self._shared:
                self._shared.give_up_lists()
            if self._by_threads:
                outcome = look(self.world)
            else:
                _, outcome = advance(self.world, 0)
            if outcome != DONE:
                self._resolve(outcome)

    def _resolve(self, outcome: int) -> None:
        """Give a search the capacity that it lacked, or raise what is wrong."""
        if outcome == PAIRS_FULL:
            self.world = more_pairs(self.world)
        elif outcome == OUTER_FULL:
            self.world = longer_lists(self.world)
        elif outcome == NOT_FINITE:
            raise self.failure("a position is no longer a finite number")
        else:
            raise self.failure("an overlap reached half the sum of the spheroradii")

    def failure(self, what: str) -> SimulationError:
        """An error that says what happened, when, and what to try."""
        return SimulationError(
            f"the simulation failed at t = {self.time:.6f} s, in steps of "
            f"{self.world.time_step * 1e6:g} us: {what}; {self._advice}"
        )

    def energies(self) -> dict[str, float]:
        """Kinetic, potential and elastic energies, dissipation so far, carried out [J].

        With what a moving door took of them; they add up to a constant.
        """
        self.refresh()
        world = self.world
        kinetic, potential, normal, tangential = energies(
            world.bodies,
            world.inner,
            world.counts,
            world.particle_law,
            world.wall_law,
            world.gravity,
        )
        table = {
            "kinetic": kinetic,
            "potential": potential,
            "elastic_normal": normal,
            "elastic_tangential": tangential,
            "carried_out": float(world.account[state.CARRIED_OUT]),
            "given_to_door": float(world.account[state.GIVEN_TO_DOOR]),
        }
        for first, pair in (
            (state.PARTICLE_PARTICLE, "grain_grain"),
            (state.PARTICLE_WALL, "grain_wall"),
        ):
            for entry, how in enumerate(("normal_damping", "tangential_damping", "friction")):
                table[f"{how}_{pair}"] = float(world.account[first + entry])
        return table

    def wall_forces(self) -> np.ndarray:
        """Mean force on each wall since the last call (n_walls, 2) [N]."""
        load = self.world.bodies.row[self.n_particles :, state.FX : state.TORQUE + 1]
        mean = load[:, :2] / max(self._wall_steps, 1)
        load[:] = 0.0
        self._wall_steps = 0
        return mean

    def sample_walls(self, most: int | None = None) -> None:
        """Keep the contacts at the walls as they are now, for wall_samples; changes no bit.

        most: of the samples, the last ones, that are kept.
        """
        self.refresh()
        self._samples.take(self.world, self.time, most)

    def wall_samples(self) -> dict[str, np.ndarray]:
        """Contacts at the walls in the samples since the last call, see WallSamples.table."""
        table = self._samples.table()
        self._samples = WallSamples()
        return table

    def remove_wall(self, index: int) -> None:
        """Take a wall away (open a door); what its contacts hold is carried out."""
        self.refresh()
        self.world.account[state.CARRIED_OUT] += energy_of_contacts(
            self.world, self.n_particles + index
        )
        self.world.bodies.layout[self.n_particles + index, [state.N_CORNERS, state.N_EDGES]] = 0
        self.world.counts[state.STALE] = 3

    def put_back_wall(self, index: int) -> None:
        """Close a wall that was taken away; see take_out for what stands in it."""
        layout = self.world.bodies.layout
        layout[self.n_particles + index, state.N_EDGES] = 1  # corners of a door are its neighbours'
        self.world.counts[state.STALE] = 3

    def take_out(self, particles: Sequence[int]) -> None:
        """Take live particles out of the silo now; they count as out, and carry their energy."""
        if not len(particles):
            return
        world, before = self.world, self.energies()
        counts, out_time = world.counts, world.bodies.out_time
        new = [i for i in particles if np.isnan(out_time[i])]
        out_time[new] = self.time
        counts[state.OUT] += len(new)
        self._set_live(self.live[~np.isin(self.live, particles)])
        after = self.energies()
        # What their tangential springs held has gone to friction.
        gone = sum(before.values()) - sum(after.values())
        world.account[state.CARRIED_OUT] += gone

    def put(self, which: np.ndarray, poses: np.ndarray) -> None:
        """Put particles, inside or gone, at rest to other places, where none touches another.

        which (k,), poses (k, 3) [m, rad]. They count as inside again, and have not left. The energy
        that they lose so, with that of their contacts, is carried out; springs go to friction.
        """
        self.refresh()
        world, bodies = self.world, self.world.bodies
        inside = set(self.live.tolist())
        for i, (x, y, angle) in zip(which.tolist(), poses.tolist(), strict=True):
            row = bodies.row[i]
            weight = world.gravity / row[state.INV_MASS]
            if i in inside:
                own = kinetic_energy(row) + weight * row[state.Y] + energy_of_contacts(world, i)
                world.account[state.CARRIED_OUT] += own
            row[: state.INV_MASS] = 0.0
            row[[state.X, state.Y, state.ANGLE]] = x, y, angle
            row[[state.COS, state.SIN]] = np.cos(angle), np.sin(angle)
            world.account[state.CARRIED_OUT] -= weight * y
        bodies.out_time[which] = np.nan
        self._set_live(np.union1d(self.live, which))

    def keep_back(self, n: int) -> None:
        """Leave the last n particles out until they are put."""
        self._set_live(np.arange(self.n_particles - n))

    def _set_live(self, live: np.ndarray) -> None:
        self.world.bodies.live[: len(live)] = live
        self.world.counts[[state.LIVE, state.STALE]] = len(live), 3

    def draw_door(self, index: int, speed: float) -> None:
        """Begin to draw a level wall to the right [m/s]; it ends at its right end and is gone."""
        world, door = self.world, self.n_particles + index
        start = world.vertices[world.bodies.layout[door, state.FIRST]]
        world.bodies.row[door, [state.X, state.Y]] = start[[state.VERTEX_X, state.VERTEX_Y]]
        world.bodies.row[door, [state.VX, state.UX]] = speed
        world.bodies.layout[door, state.N_CORNERS] = 1
        world.counts[[state.DOOR, state.STALE]] = door, 3

    def push(self, which: np.ndarray, velocity: np.ndarray) -> None:
        """Give particles inside other velocities (k, 2) [m/s]; what that costs is carried in."""
        row, account = self.world.bodies.row, self.world.account
        for i, (vx, vy) in zip(which.tolist(), velocity.tolist(), strict=True):
            account[state.CARRIED_OUT] += kinetic_energy(row[i])
            row[i, [state.VX, state.UX]], row[i, [state.VY, state.UY]] = vx, vy
            account[state.CARRIED_OUT] -= kinetic_energy(row[i])

    def set_plates(self, friction: float, ratio: float, length: float, areas: np.ndarray) -> None:
        """Let front and back plate rub from now on, see beds/plates.py.

        length of the prisms [m], areas (n_particles,) [m2].
        """
        arm = 2 / 3 * np.sqrt(areas / np.pi)
        self.world = self.world._replace(
            plates=Plates(friction, ratio, length, arm, np.zeros(self.n_particles))
        )

    def vibrate(self, amplitude: tuple[float, float], frequency: float) -> None:
        """Let all walls vibrate from the beginning of the phase on: amplitudes [m], [Hz]."""
        bodies, walls = self.world.bodies, slice(self.n_particles, None)
        bodies.skin[walls] = 2 * float(np.hypot(*amplitude))
        bodies.row[walls, state.UX : state.UY + 1] = 2 * np.pi * frequency * np.array(amplitude)
        home = bodies.row[walls, state.X : state.Y + 1].copy()
        self.world = self.world._replace(
            vibration=Vibration(
                np.array(amplitude), 2 * np.pi * frequency, home, np.zeros_like(home)
            )
        )
        self.world.counts[state.STALE] = 3

    def begin_phase(
        self, particle_law: Law, wall_law: Law, time_step: float, keep_slips: bool = False
    ) -> None:
        """Set laws and time step; clock and energy account start from zero, slips unless kept.

        Slips are kept where friction holds the particles already.
        """
        self.world = with_laws(self.world, particle_law, wall_law)._replace(time_step=time_step)
        self.world.counts[[state.STEP, state.BODY_SEARCHES, state.OUTER_SEARCHES]] = 0
        self.world.counts[state.INNER_SEARCHES] = 0
        if not keep_slips:
            self.world.inner.slip[:] = 0.0
            self.world.outer.slip[:] = 0.0
        self.world.account[:] = 0.0
        self.wall_forces()

    def touching(self) -> np.ndarray:
        """Indices in the inner list of the pairs that touch now."""
        n_pairs = int(self.world.counts[state.INNER])
        found = np.zeros(n_pairs, np.int64)
        return found[: note_overlapping(self.world.bodies.row, self.world.inner, n_pairs, found)]

    def contacts(self) -> dict[str, np.ndarray]:
        """The n vertex-edge contacts of now, with the forces that the next step will apply.

        bodies     (n, 2) particles, then walls; ascending in each contact
        point      (n, 2) where the force acts [m]
        force      (n, 2) on the second body, damping included [N]; the first takes its opposite
        normal     (n, 2) unit vector towards the second body
        overlap    (n,) [m]
        slides     (n,) whether the tangential spring is at its Coulomb limit
        """
        self.refresh()
        world = self.world
        most = int(world.counts[state.INNER])
        bodies, numbers = np.zeros((most, 2), np.uint32), np.zeros((most, 8))
        n = list_contacts(
            world.bodies.row, world.inner, world.forces, world.counts,
            (world.particle_law, world.wall_law), world.time_step, bodies, numbers,
        )  # fmt: skip
        return {
            "bodies": bodies[:n],
            "point": numbers[:n, [POINT_X, POINT_Y]],
            "force": numbers[:n, [FORCE_X, FORCE_Y]],
            "normal": numbers[:n, [NORMAL_X, NORMAL_Y]],
            "overlap": numbers[:n, OVERLAP],
            "slides": numbers[:n, SLIDES] > 0,
        }

    def coordination(self) -> float:
        """Mean number of bodies (particles and walls) that a live particle touches."""
        inner, touching = self.world.inner, self.touching()
        pairs = np.stack([inner.vertex_body[touching], inner.edge_body[touching]], axis=1)
        pairs = np.unique(np.sort(pairs, axis=1), axis=0)
        return float((pairs < self.n_particles).sum() / max(len(self.live), 1))

    def save(self) -> dict[str, np.ndarray]:
        """All that is needed to go on with the same bits, as arrays.

        Of the lists only the slips are kept: they are made again in the same order.
        """
        world = self.world
        inner = slice(0, int(world.counts[state.INNER]))
        return {
            "row": world.bodies.row.copy(),
            "layout": world.bodies.layout.copy(),
            "out_time": world.bodies.out_time.copy(),
            "live": self.live.copy(),
            "key": world.outer.key[world.inner.outer[inner]],
            "slip": world.inner.slip[inner].copy(),
            "counts": world.counts.copy(),
            "books": world.account.copy(),
            "wall_steps": np.array([self._wall_steps]),
            **{f"{_SAMPLED}{name}": column for name, column in self._samples.table().items()},
        }

    def restore(self, saved: dict[str, np.ndarray]) -> None:
        """Put back what `save` gave."""
        while len(self.world.outer.key) <= len(saved["key"]):
            self.world = longer_lists(self.world)
        world = self.world
        world.bodies.row[:] = saved["row"]
        world.bodies.layout[:] = saved["layout"]
        world.bodies.out_time[:] = saved["out_time"]
        world.bodies.live[: len(saved["live"])] = saved["live"]
        world.counts[:] = saved["counts"]
        world.account[:] = saved["books"]
        n = len(saved["key"])
        world.outer.key[:n] = saved["key"]
        world.outer.slip[:n] = saved["slip"]
        world.counts[[state.OUTER, state.INNER, state.STALE]] = n, 0, 3
        self.world = with_laws(world, world.particle_law, world.wall_law)
        self._wall_steps = int(saved["wall_steps"][0])
        sampled = {k.removeprefix(_SAMPLED): v for k, v in saved.items() if k.startswith(_SAMPLED)}
        self._samples = WallSamples([sampled] if sampled else [])

    def state_digest(self) -> str:
        """Hash of positions, orientations, velocities and the history of the contacts."""
        inner = slice(0, int(self.world.counts[state.INNER]))
        slip = self.world.inner.slip[inner]
        keys = self.world.outer.key[self.world.inner.outer[inner]]
        moving = np.ascontiguousarray(self.rows[:, [*range(state.FX), state.ANGLE]])
        text = hashlib.sha256(moving.tobytes())
        text.update(self.out_time.tobytes())
        text.update(keys[slip != 0].tobytes() + slip[slip != 0].tobytes())
        return text.hexdigest()[:16]
