"""Steps of one silo that several threads share, with the bits of one thread's.

A thread works on consecutive parts: on the pairs whose first body is its own. The second body may
be another's. Such a particle "waits": its forces of other threads come first in the list, and are
added before those of its own thread. So of each pair with a body that waits, or is another's, the
load on that body is kept, and added when all threads have come so far: first what others hand over,
then the thread's own, both in the order of the list. All other loads are added at once. That is the
order in which one thread adds the loads of each particle.

The first thread also adds up the loads on walls, ends the step, and makes those lists that cannot
be shared; the others wait.
"""

from typing import NamedTuple

import numpy as np

from granulab.contact.compiled.threads import Crew, clock, rows_apart, wait
from granulab.contact.jit import inlined_inner, inner, uncounted
from silo2d.engine.beds.door import move_walls, take_loads
from silo2d.engine.forces import add_to_account, added, contact_forces
from silo2d.engine.integrate import end_step, move_live
from silo2d.engine.lists import measure_distances
from silo2d.engine.neighbours import begin_search, search_inner, search_outer, update_vertices
from silo2d.engine.simd import add_loads, add_to_edge_body, add_to_vertex_body
from silo2d.engine.state import (
    BLOCK,
    CARRIED_OUT,
    DONE,
    LIVE,
    NOBODY,
    OUTER,
    PARTICLE_PARTICLE,
    PARTICLE_WALL,
    STALE,
    Forces,
    World,
)


class Loads(NamedTuple):
    """Loads that are kept for a moment, each at its pair's place in the inner list; (capacity,)."""

    fx: np.ndarray  # force on the vertex's body [N]
    fy: np.ndarray
    torque_j: np.ndarray  # torque on the vertex's body [N m]
    torque_i: np.ndarray  # torque on the edge's body [N m]


class Team(NamedTuple):
    """Arrays that the threads of a silo share besides its world."""

    clock: np.ndarray  # of wait
    parts: np.ndarray  # (n_threads + 1,) which parts each thread works on
    bounds: np.ndarray  # (n_threads + 1,) where the particles of each begin
    blocks: Forces  # (n_threads, BLOCK) of the pairs that each thread is at
    aside: np.ndarray  # (n_threads, 32) rows that nobody reads, see simd.add_loads
    waits: np.ndarray  # (n_particles,) whether each waits
    to_j: np.ndarray  # (capacity,) uint32 row that takes the load of a vertex's body, or NOBODY
    to_i: np.ndarray  # (capacity,) uint32 and of the edge's
    kept: Loads
    own: np.ndarray  # (capacity,) uint32 pairs with a load that is kept, each thread's from where
    # its pairs of a class begin
    n_own: np.ndarray  # (n_threads, 2 or more) how many of each class
    foreign: np.ndarray  # (n_threads, capacity) uint32 those of each whose second body is another's
    n_foreign: np.ndarray  # (n_threads, 1 or more) how many
    sums: np.ndarray  # (2, n_parts, 8) what each part of each class dissipates in this step
    seen: np.ndarray  # (n_threads, 2 or more) whether a particle left its skin, or the silo
    outcome: np.ndarray  # (1,) of the search so far


@uncounted
def advance_shared(world, team, thread, n_steps):
    """Take n_steps steps, as simulation.advance; each thread calls it."""
    arrived, n_threads, counts = np.int64(0), len(team.n_foreign), world.counts
    load = 0.0
    for k in range(n_steps):
        if counts[STALE] > 0:
            arrived = _search(world, team, thread, arrived)
            if team.outcome[0] != DONE:
                return k, team.outcome[0]
        if thread == 0:
            load = take_loads(world)
        _push(world, team, thread, 0, world.particle_law)
        arrived = wait(team.clock, n_threads, arrived)
        _deliver(world, team, thread)
        _push(world, team, thread, 1, world.wall_law)
        first, last = _own_live(world, team, thread)
        far, low = move_live(world, first, last)
        team.seen[thread, 0], team.seen[thread, 1] = far, low
        arrived = wait(team.clock, n_threads, arrived)
        if thread == 0:
            _push_walls(world, team)
            end_step(world, team.seen[:, 0].any(), team.seen[:, 1].any())
            move_walls(world, load)
        arrived = wait(team.clock, n_threads, arrived)
    return n_steps, np.int64(DONE)


@inlined_inner
def _search(world, team, thread, arrived):
    """Make stale lists again, see neighbours.search; the outcome is in team."""
    n_threads, is_first = len(team.n_foreign), thread == 0
    if is_first:
        team.outcome[0] = begin_search(world)
    arrived = wait(team.clock, n_threads, arrived)
    first, last = _own_live(world, team, thread)
    update_vertices(world, first, last)
    arrived = wait(team.clock, n_threads, arrived)
    if is_first and team.outcome[0] == DONE:
        team.outcome[0] = search_outer(world)
    arrived = wait(team.clock, n_threads, arrived)
    if team.outcome[0] == DONE:
        last = world.counts[OUTER]
        begin, end = last * thread // n_threads, last * (thread + 1) // n_threads
        measure_distances(world.local, world.vertices, world.outer, begin, end)
    arrived = wait(team.clock, n_threads, arrived)
    if is_first and team.outcome[0] == DONE:
        team.outcome[0] = search_inner(world)
    arrived = wait(team.clock, n_threads, arrived)
    if team.outcome[0] == DONE:
        arrived = _share_out(world, team, thread, arrived)
    return arrived


@inner
def _own_live(world, team, thread):
    """Return where the live particles of a thread begin and end."""
    live = world.bodies.live[: world.counts[LIVE]]
    return (
        np.searchsorted(live, team.bounds[thread]),
        np.searchsorted(live, team.bounds[thread + 1]),
    )


@inlined_inner
def _share_out(world, team, thread, arrived):
    """Choose where the loads of a thread's pairs go; arrived."""
    n_threads = len(team.n_foreign)
    team.waits[team.bounds[thread] : team.bounds[thread + 1]] = False
    arrived = wait(team.clock, n_threads, arrived)
    _name_to_others(world, team, thread)
    arrived = wait(team.clock, n_threads, arrived)
    for which in range(2):
        _choose_rows(world, team, thread, which)
    return arrived


@inner
def _name_to_others(world, team, thread):
    """Name the pairs of a thread that act on others' particles, and let these wait."""
    inner, n_foreign = world.inner, np.int64(0)
    first, last = _own_pairs(world, team, thread, 0)
    for n in range(first, last):
        second = max(inner.vertex_body[n], inner.edge_body[n])
        if second >= team.bounds[thread + 1]:
            team.waits[second] = True
            team.foreign[thread, n_foreign] = n
            n_foreign += 1
    team.n_foreign[thread, 0] = n_foreign


@inner
def _choose_rows(world, team, thread, which):
    """Choose the rows of a thread's pairs of a class, and name those with a load that is kept.

    Loads on walls are all kept. Pairs with walls come after those that were kept are added, so that
    no particle waits.
    """
    inner, own_end = world.inner, team.bounds[thread + 1]
    first, last = _own_pairs(world, team, thread, which)
    n_own = np.int64(0)
    for n in range(first, last):
        j, i = inner.vertex_body[n], inner.edge_body[n]
        team.to_j[n] = _unless(j, j >= own_end or (which == 0 and team.waits[j]))
        team.to_i[n] = _unless(i, i >= own_end or (which == 0 and team.waits[i]))
        if team.to_j[n] == NOBODY or team.to_i[n] == NOBODY:
            team.own[first + n_own] = n
            n_own += 1
    team.n_own[thread, which] = n_own


@inlined_inner
def _unless(body, is_kept):
    return NOBODY if is_kept else body


@inlined_inner
def _own_pairs(world, team, thread, which):
    """Return where a thread's pairs of a class, 0 or 1, begin and end."""
    first_pair, parts = world.first_pair, team.parts
    return first_pair[which, parts[thread]], first_pair[which, parts[thread + 1]]


@inner
def _push(world, team, thread, which, law):
    """Loads of a thread's pairs of a class, 0 or 1, and what they dissipate."""
    m, _ = _own_pairs(world, team, thread, which)
    end_of_kept = m + team.n_own[thread, which]
    for part in range(team.parts[thread], team.parts[thread + 1]):
        last, sums = world.first_pair[which, part + 1], (0.0, 0.0, 0.0)
        for begin in range(world.first_pair[which, part], last, BLOCK):
            n_pairs = min(last - begin, BLOCK)
            block, sums = _push_block(world, team, thread, law, begin, n_pairs, sums)
            while m < end_of_kept and team.own[m] < begin + n_pairs:
                _keep(team.kept, team.own[m], block, team.own[m] - begin)
                m += 1
        own = team.sums[which, part]
        own[0], own[1], own[2] = sums


@inlined_inner
def _push_block(world, team, thread, law, begin, n_pairs, sums):
    """Add the loads of a block that are not kept; the block, and the sums with its own."""
    blocks, row = team.blocks, world.bodies.row
    block = Forces(
        blocks.fx[thread], blocks.fy[thread], blocks.torque_j[thread], blocks.torque_i[thread],
        blocks.normal_power[thread], blocks.tangential_power[thread], blocks.lost[thread],
    )  # fmt: skip
    contact_forces(row, world.inner, block, law, begin, n_pairs, world.time_step)
    sums = add_loads(row, team.aside[thread], team.to_j, team.to_i, block, begin, n_pairs, sums)
    return block, sums


@inlined_inner
def _keep(kept, n, block, k):
    """Keep the load of pair n, number k of a block."""
    kept.fx[n], kept.fy[n] = block.fx[k], block.fy[k]
    kept.torque_j[n], kept.torque_i[n] = block.torque_j[k], block.torque_i[k]


@inner
def _deliver(world, team, thread):
    """Add the loads that were kept to the particles of a thread."""
    row, inner, kept = world.bodies.row, world.inner, team.kept
    begins, ends = team.bounds[thread], team.bounds[thread + 1]
    for other in range(thread):
        for k in range(team.n_foreign[other, 0]):
            n = team.foreign[other, k]
            _add_to_vertex_body(row, inner, kept, n, begins, ends)
            _add_to_edge_body(row, inner, kept, n, begins, ends)
    first, _ = _own_pairs(world, team, thread, 0)
    for m in range(first, first + team.n_own[thread, 0]):
        n = team.own[m]
        if team.to_j[n] == NOBODY:
            _add_to_vertex_body(row, inner, kept, n, begins, ends)
        if team.to_i[n] == NOBODY:
            _add_to_edge_body(row, inner, kept, n, begins, ends)


@inlined_inner
def _add_to_vertex_body(row, inner, kept, n, begins, ends):
    """Add the load of pair n to the body of its vertex, if it is in a range."""
    j = inner.vertex_body[n]
    if begins <= j < ends:
        add_to_vertex_body(row, j, kept, n)


@inlined_inner
def _add_to_edge_body(row, inner, kept, n, begins, ends):
    """Likewise to that of its edge."""
    i = inner.edge_body[n]
    if begins <= i < ends:
        add_to_edge_body(row, i, kept, n)


@inner
def _push_walls(world, team):
    """Add the forces on the walls up, and what all pairs dissipate."""
    row, dt = world.bodies.row, world.time_step
    begins, ends = len(world.bodies.live), len(row)
    for n in range(world.first_pair[1, 0], world.first_pair[1, -1]):
        _add_to_vertex_body(row, world.inner, team.kept, n, begins, ends)
        _add_to_edge_body(row, world.inner, team.kept, n, begins, ends)
    for which in range(2):
        total = 0.0, 0.0, 0.0
        for part in range(team.sums.shape[1]):
            own = team.sums[which, part]
            total = added(total, (own[0], own[1], own[2]))
        if which == 0:
            add_to_account(world.account[PARTICLE_PARTICLE:PARTICLE_WALL], total, dt)
        else:
            add_to_account(world.account[PARTICLE_WALL:CARRIED_OUT], total, dt)


class SharedSteps:
    """A silo's steps shared by several threads; made anew when the arrays of the world change."""

    def __init__(self, world: World, crew: Crew) -> None:
        self.world, self._crew = world, crew
        n, capacity = crew.n_threads, len(world.inner.outer)
        parts = np.arange(n + 1) * (len(world.parts) - 1) // n
        self._team = Team(
            clock=clock(),
            parts=parts,
            bounds=world.parts[parts],
            blocks=Forces(*(np.zeros((n, BLOCK)) for _ in Forces._fields)),
            aside=np.zeros((n, 32)),
            waits=np.zeros(len(world.bodies.live), bool),
            to_j=np.zeros(capacity, np.uint32),
            to_i=np.zeros(capacity, np.uint32),
            kept=Loads(*(np.zeros(capacity) for _ in Loads._fields)),
            own=np.zeros(capacity, np.uint32),
            n_own=rows_apart(n, 2),
            sums=np.zeros((2, len(world.parts) - 1, 8)),
            foreign=np.empty((n, capacity), np.uint32),
            n_foreign=rows_apart(n, 1),
            seen=rows_apart(n, 2),
            outcome=np.full(1, DONE),
        )
        self._shared_out = False  # the pairs of the lists that there are

    def step(self, n_steps: int) -> tuple[int, int]:
        """See simulation.advance.

        Lists that were made before these threads came are made again, which shares them out.
        """
        if not n_steps:  # to compile: in the caller's thread, which hears Ctrl-C
            return advance_shared(self.world, self._team, 0, 0)
        counts = self.world.counts
        if not self._shared_out:
            counts[STALE] = max(counts[STALE], 1)
        self._team.clock[0] = 0
        arguments = [(self.world, self._team, t, n_steps) for t in range(self._crew.n_threads)]
        taken, outcome = self._crew.run(advance_shared, arguments)
        self._shared_out = True
        return taken, outcome

    def give_up_lists(self) -> None:
        """Share out anew: the lists that there are were made without the threads."""
        self._shared_out = False
