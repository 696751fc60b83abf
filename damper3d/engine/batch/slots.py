"""The arrays of many dampers of spheres, a slot each; from the world of a damper into one and back.

Arrays of what each sphere has of its own end with the spheres: neighbouring threads, which have
neighbouring spheres, then read neighbouring numbers. What contacts look up of other spheres stands
in rows of four numbers.
"""

from typing import Any, NamedTuple

import numpy as np

from damper3d.engine import state
from damper3d.engine.enclosures import Round
from damper3d.engine.motions import Sines
from damper3d.engine.simulation import Simulation
from damper3d.engine.spheres.particles import OneSphere
from granulab.contact.hertz import HertzLaw

# Entries of Slots.clock: number of spheres, of flat walls and of all walls; steps of this phase;
# steps taken into the sample that is begun; steps of a sample; samples that are wanted, and those
# of them that are written; the step at which lists were left; which of the two lists is in use; the
# step when it was made; and why the slot cannot go on, as a search ends (state.py).
(
    SPHERES, PLANES, WALLS, STEP, INTO, PER_SAMPLE, WANTED, WRITTEN, LEFT, IN_USE, MADE, OUTCOME
) = range(12)  # fmt: skip
N_CLOCK = 12
# Entries of Slots.numbers: time step [s], gravity [m/s2], direction, skin [m], radius of the round
# wall [m], whether curvature enters the law, velocities of yielding [m/s], time over which the
# motion grows [s].
TIME_STEP, GRAVITY, DIRECTION, SKIN, ROUND, CURVED, YIELDS, RAMP = 0, 1, 4, 7, 8, 9, 10, 12
N_NUMBERS = 13
# Columns of Slots.books, of each sphere: the balance, with half of what each wall contact loses;
# fastest impact of either class, impacts, impacts beyond yielding, since the last sample; heat; the
# forces on the walls, summed since the last sample.
IMPACTS = state.N_BALANCE
HEAT = IMPACTS + 2 * state.YIELD
WALL_FORCE = HEAT + 1
# Columns of Slots.parts: those of a sample from KINETIC to CONTACTS_PW, position and velocity times
# the mass, and the mass [kg].
N_HELD = state.CONTACTS_PW + 1 - state.KINETIC
MASS = N_HELD + 6
N_PARTS = MASS + 1
BITS = 63  # of a number that says which contacts of a sphere touched, all but its sign
SKIN_SHARE = 0.1  # skin over the largest radius: lists last some hundred steps


class Slots(NamedTuple):
    """Arrays of n_slots dampers of at most n spheres, w walls, c neighbours a sphere, r samples."""

    clock: np.ndarray  # (n_slots, N_CLOCK) int64
    numbers: np.ndarray  # (n_slots, N_NUMBERS)
    laws: np.ndarray  # (n_slots, 2, 8) HertzLaw of pairs and of walls
    sines: np.ndarray  # (n_slots, 3, k) amplitude [m], omega [rad/s], phase [rad]
    planes: np.ndarray  # (n_slots, w, 4) as Walls.planes
    position: np.ndarray  # (n_slots, n, 4) [m]; the fourth is the radius
    velocity_now: np.ndarray  # (n_slots, n, 4) at the time of the position; inverse mass [1/kg]
    spin_now: np.ndarray  # (n_slots, n, 4) likewise [rad/s]; inverse inertia [1/(kg m2)]
    velocity: np.ndarray  # (n_slots, 3, n) half a step back [m/s]
    spin: np.ndarray  # (n_slots, 3, n) likewise [rad/s]
    load: np.ndarray  # (n_slots, 6, n) force [N] and torque [N m]
    seen: np.ndarray  # (n_slots, 3, n) positions when the list was made [m]
    drift: np.ndarray  # (n_slots, 3) mean velocity then, about [m/s]
    listed: np.ndarray  # (n_slots, 2, n) int32, number of neighbours, of either list
    near: np.ndarray  # (n_slots, 2, c, n) int32, neighbours, ascending
    # Of the contacts with them, and then with walls: (4/3) E sqrt(R) [N/m^1.5] and the reduced mass
    # [kg], the history, and, as bits of a number, those that touched a step ago.
    constants: np.ndarray  # (n_slots, 2, c + w, 2, n)
    history: np.ndarray  # (n_slots, 2, c + w, N_HISTORY, n)
    lasting: np.ndarray  # (n_slots, n) int64
    books: np.ndarray  # (n_slots, WALL_FORCE + 3 w, n)
    parts: np.ndarray  # (n_slots, N_PARTS, n)
    rows: np.ndarray  # (n_slots, r, N_COLUMNS + N_BALANCE + 3 w) samples


def slot_of(slots: Slots, s: int) -> Slots:
    """The arrays of slot s alone; kernels have it too, hence the names one by one."""
    return Slots(
        slots.clock[s], slots.numbers[s], slots.laws[s], slots.sines[s], slots.planes[s],
        slots.position[s], slots.velocity_now[s], slots.spin_now[s], slots.velocity[s],
        slots.spin[s], slots.load[s], slots.seen[s], slots.drift[s], slots.listed[s],
        slots.near[s], slots.constants[s], slots.history[s], slots.lasting[s], slots.books[s],
        slots.parts[s], slots.rows[s],
    )  # fmt: skip


# What says where a damper is: the arrays that `take` reads.
MOVING = ("position", "velocity_now", "spin_now", "velocity", "spin", "listed", "near", "history",
          "books")  # fmt: skip


TOO_MANY_NEIGHBOURS = "a particle has more neighbours than a slot holds, or overlaps too much"


def reason_against(sim: Simulation) -> str | None:
    """Names of what a simulation has that slots do not; None where it can have one."""
    world = sim.world
    lacking = {
        "particles of several spheres": not isinstance(world.shape, OneSphere),
        "contacts with cohesion, rolling resistance or unlike materials": not isinstance(
            world.pair_law, HertzLaw
        ),
        "a motion that is no sum of sines along one direction": type(world.shaker) is not Sines,
        "curved walls other than a cylinder's": not isinstance(world.walls.surface, Round),
        "walls that move each by itself": world.walls.drive is not None,
    }
    return next((words for words, has in lacking.items() if has), None)


def _most_bits(slots: Slots, world: state.World) -> int:
    """Bits of a sphere's contacts: of its neighbours at most, then of its walls."""
    return slots.near.shape[2] + len(world.walls.force)


def lacks_room(slots: Slots, sim: Simulation) -> str | None:
    """Names of what a simulation has more of than slots hold; None where they hold it."""
    world = sim.world
    lacking = {
        "more particles": sim.n_particles > slots.position.shape[1],
        "more walls": len(world.walls.force) > slots.planes.shape[1],
        "more contacts of a sphere, with walls and neighbours": _most_bits(slots, world) > BITS,
        "more sines in its motion": len(world.shaker.amplitude) > slots.sines.shape[2],
    }
    return next((f"{words} than a slot holds" for words, has in lacking.items() if has), None)


def empty(
    n_slots: int, n_spheres: int, n_walls: int, *, n_sines: int = 1, room: int = 24, rows: int = 100
) -> Slots:
    """Slots without dampers; room: neighbours a sphere; rows: samples that a slot can hold."""
    n = n_spheres
    shapes: dict[str, Any] = {
        "clock": (N_CLOCK,), "numbers": (N_NUMBERS,), "laws": (2, len(HertzLaw._fields)),
        "sines": (3, n_sines), "planes": (n_walls, 4), "position": (n, 4),
        "velocity_now": (n, 4), "spin_now": (n, 4), "velocity": (3, n), "spin": (3, n),
        "load": (6, n), "seen": (3, n), "drift": (3,), "listed": (2, n), "near": (2, room, n),
        "constants": (2, room + n_walls, 2, n), "history": (2, room + n_walls, state.N_HISTORY, n),
        "lasting": (n,),
        "books": (WALL_FORCE + 3 * n_walls, n), "parts": (N_PARTS, n),
        "rows": (rows, state.N_COLUMNS + state.N_BALANCE + 3 * n_walls),
    }  # fmt: skip
    kinds = {"clock": np.int64, "lasting": np.int64, "listed": np.int32, "near": np.int32}
    return Slots(**{name: np.zeros((n_slots, *shape), kinds.get(name, float))
                    for name, shape in shapes.items()})  # fmt: skip


def put(slots: Slots, s: int, sim: Simulation, wanted: int) -> bool:
    """Bring a damper into slot s, to write so many samples; False where it has no room there.

    The slot needs room for its spheres, walls, sines and samples, as `empty` was asked for it.
    """
    world, saved, one = sim.world, sim.save(), slot_of(slots, s)
    n, walls, shaker = sim.n_particles, world.walls, world.shaker
    for array in one:
        array[...] = 0
    of_clock = {SPHERES: n, PLANES: len(walls.planes), WALLS: len(walls.force), STEP: sim.steps,
                WANTED: wanted, PER_SAMPLE: sim.steps_per_sample, LEFT: sim.steps}  # fmt: skip
    one.clock[list(of_clock)] = list(of_clock.values())
    one.numbers[:] = (
        world.time_step, *world.gravity[:3], *world.direction[:3],
        SKIN_SHARE * saved["position"][:, 3].max(), walls.surface.radius, walls.curved,
        *world.impacts[:, state.YIELD], shaker.ramp_time,
    )  # fmt: skip
    one.laws[:] = world.pair_law, world.wall_law
    one.sines[:, : len(shaker.amplitude)] = shaker.amplitude, shaker.omega, shaker.phase
    one.planes[: len(walls.planes)] = walls.planes
    for name, array in (("position", one.position), ("velocity_now", one.velocity_now),
                        ("spin_now", one.spin_now)):  # fmt: skip
        array[:n] = saved[name]
    one.velocity_now[:n, 3] = world.particles.inverse_mass
    one.spin_now[:n, 3] = world.particles.inverse_inertia
    one.velocity[:, :n], one.spin[:, :n] = saved["velocity"][:, :3].T, saved["spin"][:, :3].T
    # What was counted so far is given to the first sphere, as only sums are asked for.
    one.books[: state.N_BALANCE, 0] = saved["books"]
    one.books[IMPACTS:HEAT, 0] = world.impacts[:, : state.YIELD].ravel()
    one.books[HEAT, :n] = saved["heat"][:n]
    one.books[WALL_FORCE : WALL_FORCE + walls.force.size, 0] = walls.force.ravel()
    one.history[:, :, state.DAMPING] = state.NO_CONTACT
    touching, of_wall = saved["wall_pairs"].astype(np.int64).T
    one.history[0, one.near.shape[1] + of_wall, :, touching] = saved["wall_springs"].T
    return _put_pairs(one, saved["pairs"].astype(np.int64), saved["springs"].T)


def _put_pairs(one: Slots, pairs: np.ndarray, histories: np.ndarray) -> bool:
    """The contacts of pairs (k, 2) with their histories (k, N_HISTORY), seen from either sphere.

    Seen from the second, spring and displacement point the other way. False: there is no room.
    """
    turned = histories.copy()
    turned[:, : state.STIFFNESS] *= -1.0
    i, j = np.concatenate([pairs, pairs[:, ::-1]]).T
    both = np.concatenate([histories, turned])
    order = np.lexsort((j, i))
    i, j, both = i[order], j[order], both[order]
    place = np.arange(len(i)) - np.searchsorted(i, i)
    if (place >= one.near.shape[1]).any():
        return False
    one.listed[0] = np.bincount(i, minlength=one.listed.shape[1])
    one.near[0, place, i] = j
    one.history[0, place, :, i] = both
    return True


def take(slots: Slots, s: int, sim: Simulation) -> np.ndarray:
    """Give a simulation the state to which its damper in slot s has come; its samples, by rows."""
    one, saved = slot_of(slots, s), sim.save()
    n, n_walls = sim.n_particles, len(sim.world.walls.force)
    in_use, room = one.clock[IN_USE], one.near.shape[1]
    near, history = one.near[in_use, :, :n], one.history[in_use, :, :, :n]
    lasts = history[:, state.DAMPING] >= 0.0
    listed = np.arange(room)[:, None] < one.listed[in_use, :n]
    i, place = np.nonzero((listed & (near > np.arange(n)) & lasts[:room]).T)
    at_wall, touching = np.nonzero(lasts[room:])
    for name, array in (("position", one.position), ("velocity_now", one.velocity_now),
                        ("spin_now", one.spin_now)):  # fmt: skip
        saved[name][:, :3] = array[:n, :3]
    saved["velocity"][:, :3], saved["spin"][:, :3] = one.velocity[:, :n].T, one.spin[:, :n].T
    sums = one.books[:, :n].sum(axis=1)
    walls_lost = sums[state.N_MECHANISMS : state.N_MECHANISMS + state.LAW_TERM].sum()
    impacts = one.books[IMPACTS:HEAT, :n].reshape(2, state.YIELD, n)
    sim.restore({
        **saved,
        "heat": np.append(one.books[HEAT, :n], 0.5 * walls_lost),
        "pairs": np.stack([i, near[place, i]], axis=1).astype(saved["pairs"].dtype),
        "springs": history[place, :, i].T,
        "wall_pairs": np.stack([touching, at_wall], axis=1),
        "wall_springs": history[room + at_wall, :, touching].T,
        "wall_force": sums[WALL_FORCE:][: 3 * n_walls].reshape(n_walls, 3),
        "step": one.clock[[STEP]],
        "books": sums[: state.N_BALANCE],
        "impacts": np.column_stack([impacts[:, state.FASTEST].max(axis=1),
                                    impacts[:, state.BEGUN :].sum(axis=2)]),
    })  # fmt: skip
    n_columns = state.N_COLUMNS + state.N_BALANCE + 3 * n_walls
    return one.rows[: one.clock[WRITTEN], :n_columns].copy()
