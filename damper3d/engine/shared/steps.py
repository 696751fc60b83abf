"""Steps of one bed that several threads share, with the bits of one thread's.

A step has three stages, and all wait for one another after each: the forces of pairs; what is kept
of them (results.py) and those of the walls; the motion. All find near particles and carry the
histories of contacts over. The first thread lists, adds up the forces on the walls and samples.
"""

from typing import Any, NamedTuple

import numpy as np

from damper3d.engine import sampling
from damper3d.engine.enclosures.cavity import Triangles
from damper3d.engine.forces import (
    push_at_wall,
    push_pairs,
    take_push,
)
from damper3d.engine.geometry import copy
from damper3d.engine.integrate import force_so_far, place_now, ride, search
from damper3d.engine.kinds import first_sphere, measure_gaps, move
from damper3d.engine.laws.balance import NO_LOSS, add_to_balance, added, take_totals
from damper3d.engine.laws.cohesion import Jkr
from damper3d.engine.laws.table import LawTable, face_wall
from damper3d.engine.motions import Turning
from damper3d.engine.motions.host import rides
from damper3d.engine.motions.turning import without_shaker, without_walls
from damper3d.engine.neighbours import (
    begin_outer,
    begin_search,
    give_up_list,
    inherit_histories,
    keep_histories,
    know_outer,
    list_inner,
    near_pairs,
)
from damper3d.engine.shared.results import (
    FIRST_ROW,
    N_ROWS,
    Loads,
    Results,
    choose_rows,
    deliver,
    mark_waiting,
    push_enclosure,
    room_for,
)
from damper3d.engine.state import (
    BEGUN,
    BEYOND,
    DAMPING,
    DONE,
    FASTEST,
    INNER,
    N_MECHANISMS,
    NOT_FINITE,
    OUTER,
    OUTER_FULL,
    STALE_INNER,
    STALE_WALL,
    STEP,
    WALL_WORK,
    World,
    zeros,
)
from damper3d.engine.walls import place_wall
from damper3d.engine.world import block
from granulab.contact.compiled.threads import Crew, clock, rows_apart, wait
from granulab.contact.jit import inlined_inner, inner, specialised, uncounted


class Team(NamedTuple):
    """Arrays that the threads of a bed share besides its world."""

    clock: np.ndarray  # of wait
    parts: np.ndarray  # (n_threads + 1,) which parts each thread works on
    bounds: np.ndarray  # (n_threads + 1,) where the spheres of each begin
    counts: np.ndarray  # (N_COUNTS,) of the first thread, which are the world's
    lengths: np.ndarray  # (N_LENGTHS,) likewise
    stale: np.ndarray  # (n_threads, 2 or more) whether each thread saw that a list was left
    outcome: np.ndarray  # (1,) of the last search
    impacts: np.ndarray  # (n_threads, 2, 4) World.impacts of each; the first one's are not used
    left: np.ndarray  # (1,) what neighbours.begin_search gave
    near: np.ndarray  # (n_threads, 2, capacity) uint32, near pairs that each thread found
    n_own: np.ndarray  # (n_threads,) how many each found, or remembers; -1 for no room
    foreign: np.ndarray  # (n_threads, capacity) uint32 kept loads for others, rows of pairs.contact
    n_foreign: np.ndarray  # (n_threads, 1 or more) how many
    sums: np.ndarray  # (n_parts, 8) what they dissipate, see laws.balance
    wall_first: np.ndarray  # (n_walls, n_threads + 1) where the contacts of each thread begin
    wall_end: np.ndarray  # (n_threads, n_walls or more) where those that touch end


@inner
def advance_shared(world, team, thread, n_steps, arrived):
    """Steps as integrate.take_steps has them; how many were taken, DONE or why no more, arrived.

    Each thread calls it with a world of its own, see SharedSteps; arrived: see wait.
    """
    n_threads = len(team.impacts)
    taken, outcome = np.int64(0), np.int64(DONE)
    if n_steps == 0:  # to compile, by one thread
        return taken, outcome, arrived
    room, bed = without_shaker(world), without_walls(world)
    shift, speed = place_now(world)
    while taken < n_steps:
        if world.counts[STALE_INNER] or world.counts[STALE_WALL]:
            outcome, arrived = _search(room, team, thread, shift, arrived)
            if outcome != DONE:
                break
        _push_own_pairs(bed, team, thread)
        arrived = wait(team.clock, n_threads, arrived)
        deliver(bed, team.foreign, team.n_foreign)
        _push_own_at_walls(room, team, thread, shift, speed)
        arrived = wait(team.clock, n_threads, arrived)
        if thread == 0:
            _push_enclosure(world, team)
        arrived = wait_for_host(world, team, arrived)
        world.counts[STEP] += 1
        shift, speed = place_now(world)
        first, last = world.parts[team.parts[thread]], world.parts[team.parts[thread + 1]]
        move(bed, shift, first, last)
        team.stale[thread, 0] = world.counts[STALE_INNER]
        team.stale[thread, 1] = world.counts[STALE_WALL]
        arrived = wait(team.clock, n_threads, arrived)
        for other in range(n_threads):
            world.counts[STALE_INNER] |= team.stale[other, 0]
            world.counts[STALE_WALL] |= team.stale[other, 1]
        taken += 1
    if thread == 0:
        _gather_impacts(bed, team)
    arrived = wait(team.clock, n_threads, arrived)
    return taken, outcome, arrived


@uncounted
def advance_sampling_shared(world, team, thread, steps_per_sample, rows):
    """Fill rows as sampling.advance_sampling does, by several threads."""
    arrived, n_threads = np.int64(0), len(team.impacts)
    if len(rows) == 0:
        taken, outcome, _ = advance_shared(world, team, thread, steps_per_sample, arrived)
        return 0, taken, outcome
    for k in range(len(rows)):
        taken, outcome, arrived = advance_shared(world, team, thread, steps_per_sample, arrived)
        if outcome == DONE:
            room, shift = without_shaker(world), place_now(world)[0]
            outcome, arrived = _search(room, team, thread, shift, arrived)
        if outcome != DONE:
            return k, taken, outcome
        if thread == 0:
            sampling.sample(world, steps_per_sample, rows[k])
        arrived = wait(team.clock, n_threads, arrived)
    return len(rows), np.int64(0), np.int64(DONE)


@inlined_inner
def _search(world, team, thread, shift, arrived):
    """Make stale lists again, and share out the contacts with walls; DONE or why not, arrived."""
    n_threads, is_first = len(team.impacts), thread == 0
    if is_first:
        team.outcome[0] = DONE
    if world.counts[STALE_INNER]:
        arrived = _search_pairs(without_walls(world), team, thread, shift, arrived)
    if is_first:
        if team.outcome[0] == DONE:
            team.outcome[0] = search(world, shift)  # of the walls
        _share_walls(world, team)
    arrived = wait(team.clock, n_threads, arrived)
    if not is_first:
        copy(world.counts, team.counts, len(team.counts))
        copy(world.lengths, team.lengths, len(team.lengths))
    return team.outcome[0], arrived


@inlined_inner
def _search_pairs(world, team, thread, shift, arrived):
    """Make the inner list again, as neighbours.search_pairs; the outcome is in team."""
    n_threads, is_first = len(team.impacts), thread == 0
    arrived = _keep_histories(world, team, thread, arrived)
    if is_first:
        team.left[0] = begin_search(world)
        if np.isnan(team.left[0]):
            team.outcome[0] = NOT_FINITE
        elif team.left[0] < 0.0:
            begin_outer(world, shift)
    arrived = wait(team.clock, n_threads, arrived)
    if team.left[0] < 0.0:
        arrived = _search_outer(world, team, thread, -team.left[0], arrived)
    n_outer = team.counts[OUTER]
    measure_gaps(world, n_outer * thread // n_threads, n_outer * (thread + 1) // n_threads)
    arrived = wait(team.clock, n_threads, arrived)
    if is_first and team.outcome[0] == DONE:
        team.outcome[0] = list_inner(world, abs(team.left[0]))
        _share_out(world, team)
    arrived = wait(team.clock, n_threads, arrived)
    if team.outcome[0] == DONE:
        arrived = _take_pairs(world, team, thread, arrived)
    return arrived


@inlined_inner
def _keep_histories(world, team, thread, arrived):
    """Remember the histories of the inner list, each thread those of its pairs."""
    n_threads = len(team.impacts)
    if team.counts[INNER] == 0:  # they are remembered already
        return wait(team.clock, n_threads, arrived)
    first = world.first_pair[team.parts[thread]]
    last = world.first_pair[team.parts[thread + 1]]
    own = np.int64(0)
    for m in range(first, last):
        own += np.int64(world.inner.history[m, DAMPING] >= 0.0)
    team.n_own[thread] = own
    arrived = wait(team.clock, n_threads, arrived)
    n = np.int64(0)
    for other in range(thread):
        n += team.n_own[other]
    n = keep_histories(world, first, last, n)
    arrived = wait(team.clock, n_threads, arrived)
    if thread == n_threads - 1:
        give_up_list(world, n)
        team.counts[INNER] = 0
    return wait(team.clock, n_threads, arrived)


@inlined_inner
def _take_pairs(world, team, thread, arrived):
    """Give a thread's pairs their histories, and choose the rows that take their loads."""
    n_threads = len(team.impacts)
    first = world.first_pair[team.parts[thread]]
    last = world.first_pair[team.parts[thread + 1]]
    world.results.rows[FIRST_ROW] = first
    inherit_histories(world, first, last)
    mark_waiting(world, first, last)
    arrived = wait(team.clock, n_threads, arrived)
    if thread == 0:
        world.kept.number[0] = 0
    choose_rows(world, first, last, len(world.spheres.inverse_mass) + 1 + 2 * thread)
    return arrived


@inlined_inner
def _search_outer(world, team, thread, skin, arrived):
    """Let each thread find the near pairs of its particles, and bring them to the outer list."""
    outer, near = world.outer, team.near[thread]
    begin, end = world.parts[team.parts[thread]], world.parts[team.parts[thread + 1]]
    team.n_own[thread] = near_pairs(near[0], near[1], world.cells, outer.now, skin, begin, end)
    arrived = wait(team.clock, len(team.impacts), arrived)
    n, total = np.int64(0), np.int64(0)
    for other in range(len(team.n_own)):
        own = team.n_own[other]
        n += own if other < thread else 0
        total = total + own if own >= 0 and total >= 0 else np.int64(-1)
    if total > team.near.shape[2]:
        total = np.int64(-1)
    if total >= 0:
        for k in range(team.n_own[thread]):
            outer.i[n + k], outer.j[n + k] = near[0, k], near[1, k]
    arrived = wait(team.clock, len(team.impacts), arrived)
    if thread == 0 and not know_outer(world, total):
        team.outcome[0] = OUTER_FULL
    return wait(team.clock, len(team.impacts), arrived)


@inner
def _share_out(world, team):
    """Share the parts out, so that each thread has as much work."""
    n_threads = len(team.impacts)
    world.results.waits[:] = False
    n_parts = len(world.parts) - 1
    total = world.first_pair[n_parts] + world.parts[n_parts]
    part = np.int64(0)
    for thread in range(1, n_threads):
        least, most = team.parts[thread - 1] + 1, n_parts - (n_threads - thread)
        while part < n_parts and _work_until(world, part) * n_threads <= total * thread:
            part += 1
        team.parts[thread] = min(max(part, least), most)
        team.bounds[thread] = first_sphere(world.shape, world.parts[team.parts[thread]])


@inner
def _share_walls(world, team):
    """Note where the contacts of each thread's spheres begin in the list of each wall."""
    walls, i = world.walls, world.wall.i
    for w in range(len(walls.force)):
        n = walls.first[w]
        for thread in range(len(team.bounds)):
            while n < walls.first[w + 1] and i[n] < team.bounds[thread]:
                n += 1
            team.wall_first[w, thread] = n


@inlined_inner
def _work_until(world, part):
    """Measure the work of a step up to the middle of a part, in pairs: a particle is worth one."""
    pairs = world.first_pair[part] + world.first_pair[part + 1]
    return (pairs + world.parts[part] + world.parts[part + 1]) // 2


@inlined_inner
def _push_own_pairs(world, team, thread):
    """Forces of the pairs of a thread, kept for those whose spheres they act on."""
    world.results.n_foreign[0] = 0
    world.results.rows[N_ROWS] = 0
    for part in range(team.parts[thread], team.parts[thread + 1]):
        sums = push_pairs(world, part)
        for c in range(len(sums)):
            team.sums[part, c] = sums[c]


@inlined_inner
def _push_own_at_walls(world, team, thread, shift, speed):
    """Forces of the walls on the spheres of a thread."""
    for w in range(len(world.walls.force)):
        place_wall(world.spheres, world.walls, w, shift, speed)
        face_wall(world.wall_law, w)
        first, last = team.wall_first[w, thread], team.wall_first[w, thread + 1]
        team.wall_end[thread, w] = push_at_wall(world, w, first, last)


@inlined_inner
def _push_enclosure(world, team):
    """Force of this step on the walls, wall by wall in the order of the list; the host takes it.

    And what pairs and walls dissipate.
    """
    sums, before, bed = NO_LOSS, force_so_far(world), without_walls(world)
    for part in range(len(team.sums)):
        own = team.sums[part]
        sums = added(sums, (own[0], own[1], own[2], own[3], own[4]))
    add_to_balance(world.balance, 0, sums, world.time_step)
    for w in range(len(world.walls.force)):
        for thread in range(len(team.impacts)):
            first, end = team.wall_first[w, thread], team.wall_end[thread, w]
            push_enclosure(bed, first, end)
        power = take_push(bed, world.walls.force[w])
        world.balance[WALL_WORK] -= world.time_step * power
    add_to_balance(world.balance, N_MECHANISMS, take_totals(world.block), world.time_step)
    ride(world, before)


def wait_for_host(world, team, arrived):
    """Wait until the enclosure's host has taken the force of this step, where there is one."""


@specialised(wait_for_host)
def _wait_for_host(world, team, arrived):
    if rides(world):
        return lambda world, team, arrived: wait(team.clock, len(team.impacts), arrived)
    return lambda world, team, arrived: arrived


@inner
def _gather_impacts(world, team):
    """Add the impacts that the other threads counted to the first one's."""
    for thread in range(1, len(team.impacts)):
        for c in range(2):
            own = team.impacts[thread, c]
            world.impacts[c, FASTEST] = max(world.impacts[c, FASTEST], own[FASTEST])
            world.impacts[c, BEGUN] += own[BEGUN]
            world.impacts[c, BEYOND] += own[BEYOND]
            own[FASTEST] = own[BEGUN] = own[BEYOND] = 0.0


def one_thread_only(world: World) -> str:
    """Name what keeps several threads from sharing the steps of a bed; empty where nothing does."""
    if world.walls.rolling is not None:
        return "rolling resistance"
    if isinstance(getattr(world.pair_law, "cohesion", None), Jkr):
        return "JKR cohesion"
    if world.walls.drive is not None:
        return "walls that move by themselves"
    if isinstance(world.walls.surface, Triangles):
        return "walls of triangles"
    if isinstance(world.shaker, Turning):
        return "an enclosure that turns"
    return ""


class SharedSteps:
    """A bed's steps shared by several threads; made anew when the arrays of the world change."""

    def __init__(self, world: World, crew: Crew, first_sphere: np.ndarray) -> None:
        """first_sphere (n + 1,): of each particle, and the number of spheres."""
        self.world, self._crew = world, crew
        n, n_parts = crew.n_threads, len(world.parts) - 1
        parts = np.arange(n + 1) * n_parts // n
        capacity, at_walls = len(world.inner.i), len(world.wall.i)
        n_walls = len(world.walls.force)
        self._team = Team(
            clock=clock(),
            parts=parts,
            bounds=first_sphere[world.parts[parts]],
            counts=world.counts,
            lengths=world.lengths,
            stale=rows_apart(n, 2),
            outcome=np.zeros(1, np.int64),
            impacts=np.stack([world.impacts * [0.0, 0.0, 0.0, 1.0]] * n),
            left=np.zeros(1),
            near=np.empty((n, 2, len(world.outer.i)), np.uint32),
            n_own=np.zeros(n, np.int64),
            foreign=np.empty((n, capacity), np.uint32),
            n_foreign=rows_apart(n, 1),
            sums=np.zeros((n_parts, 8)),
            wall_first=np.zeros((n_walls, n + 1), np.int64),
            wall_end=rows_apart(n, n_walls),
        )
        self._to = np.zeros((2, capacity), np.uint32)
        self._waits = np.zeros(len(world.spheres.inverse_mass), np.bool_)
        kept = room_for(capacity, 0), room_for(at_walls, at_walls)
        self._worlds = [self._world_of(thread, *kept) for thread in range(n)]
        self._shared_out = False  # the contacts of the lists that there are
        self._compiled = False

    def _world_of(self, thread: int, pairs: Loads, walls: Loads) -> World:
        """The world as a thread sees it: what it writes for itself is its own."""
        world, team = self.world, self._team
        unread = len(world.spheres.inverse_mass) + 1 + 2 * thread
        results = Results(
            pairs=pairs,
            walls=walls,
            to_i=self._to[0],
            to_j=self._to[1],
            of_wall=np.full(len(world.wall.i), unread, np.uint32),
            waits=self._waits,
            bounds=team.bounds,
            thread=thread,
            foreign=team.foreign[thread],
            n_foreign=team.n_foreign[thread],
            rows=np.zeros(2, np.int64),
        )
        if thread == 0:
            return world._replace(results=results)
        return world._replace(
            results=results,
            block=block(),
            counts=world.counts.copy(),
            lengths=world.lengths.copy(),
            impacts=team.impacts[thread],
            pair_law=_own(world.pair_law),
            wall_law=_own(world.wall_law),
        )

    def fill(self, n_steps: int, rows: np.ndarray) -> tuple[int, int, int]:
        """See sampling.advance_sampling."""
        if not self._compiled:  # in the caller's thread, which hears Ctrl-C
            advance_sampling_shared(self._worlds[0], self._team, 0, 0, rows[:0])
            self._compiled = True
        return self._run(advance_sampling_shared, (n_steps, rows)) if n_steps else (0, 0, DONE)

    def give_up_lists(self) -> None:
        """Share out anew: the lists that there are were made without the threads."""
        self._shared_out = False

    def _run(self, kernel: Any, arguments: tuple[Any, ...]) -> Any:
        """Call a kernel in each thread.

        Lists that were made before these threads came are made again, which shares them out.
        """
        if not self._shared_out:
            self.world.counts[STALE_INNER] = 1
        self._team.clock[0] = 0
        for world in self._worlds[1:]:
            world.counts[:], world.lengths[:] = self.world.counts, self.world.lengths
        ended = self._crew.run(
            kernel, [(world, self._team, t, *arguments) for t, world in enumerate(self._worlds)]
        )
        self._shared_out = True
        return ended


def _own(law: Any) -> Any:
    """A law that a thread may write the lanes of."""
    if isinstance(law, LawTable):
        return law._replace(lanes=zeros(len(law.lanes)), kind=law.kind.copy())
    return law
