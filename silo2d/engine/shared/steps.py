"""Steps of one silo that several threads share, with the bits of one thread's.

A thread works on consecutive parts: on the pairs whose first body is its own. It keeps their
forces, since the second body may be another's. When all have done so, each adds up its own
particles' forces: first those of pairs that others worked on, then its own pairs', both in the
order of the list. That is the order in which one thread adds them, for a particle is the second
body of its pairs with particles before it, and the first of those with bodies after it.

The first thread also adds up the forces on walls, ends the step, and makes those lists that cannot
be shared; the others wait.
"""

from typing import NamedTuple

import numpy as np

from granulab.contact.compiled.threads import Crew, clock, rows_apart, wait
from granulab.contact.jit import inlined, inner, uncounted
from silo2d.engine.beds.door import move_walls, take_loads
from silo2d.engine.forces import add_to_account, added, contact_forces
from silo2d.engine.integrate import end_step, move_live
from silo2d.engine.lists import measure_distances
from silo2d.engine.neighbours import begin_search, search_inner, search_outer, update_vertices
from silo2d.engine.state import (
    BLOCK,
    CARRIED_OUT,
    DONE,
    FX,
    FY,
    LIVE,
    OUTER,
    PARTICLE_PARTICLE,
    PARTICLE_WALL,
    STALE,
    TORQUE,
    Forces,
    World,
)


class Team(NamedTuple):
    """Arrays that the threads of a silo share besides its world."""

    clock: np.ndarray  # of wait
    parts: np.ndarray  # (n_threads + 1,) which parts each thread works on
    bounds: np.ndarray  # (n_threads + 1,) where the particles of each begin
    forces: Forces  # of all inner pairs, (capacity,)
    sums: np.ndarray  # (2, n_parts, 8) what each part of each class dissipates in this step
    foreign: np.ndarray  # (n_threads, capacity) uint32 pairs of each that act on others' particles
    n_foreign: np.ndarray  # (n_threads, 1 or more) how many
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
        _push(world, team, thread)
        arrived = wait(team.clock, n_threads, arrived)
        _deliver(world, team, thread)
        if thread == 0:
            _push_walls(world, team)
        first, last = _own_live(world, team, thread)
        far, low = move_live(world, first, last)
        team.seen[thread, 0], team.seen[thread, 1] = far, low
        arrived = wait(team.clock, n_threads, arrived)
        if thread == 0:
            end_step(world, team.seen[:, 0].any(), team.seen[:, 1].any())
            move_walls(world, load)
        arrived = wait(team.clock, n_threads, arrived)
    return n_steps, np.int64(DONE)


@inlined
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
        _name_to_others(world, team, thread)
    return arrived


@uncounted
def _own_live(world, team, thread):
    """Return where the live particles of a thread begin and end."""
    live = world.bodies.live[: world.counts[LIVE]]
    return (
        np.searchsorted(live, team.bounds[thread]),
        np.searchsorted(live, team.bounds[thread + 1]),
    )


@inner
def _name_to_others(world, team, thread):
    """Name the pairs of a thread that act on others' particles."""
    inner = world.inner
    team.n_foreign[thread, 0] = 0
    first, last = (
        world.first_pair[0, team.parts[thread]],
        world.first_pair[0, team.parts[thread + 1]],
    )
    for n in range(first, last):
        second = max(inner.vertex_body[n], inner.edge_body[n])
        if second >= team.bounds[thread + 1]:
            team.foreign[thread, team.n_foreign[thread, 0]] = n
            team.n_foreign[thread, 0] += 1


@inner
def _push(world, team, thread):
    """Forces of a thread's pairs, and what they dissipate."""
    for part in range(team.parts[thread], team.parts[thread + 1]):
        first, last = world.first_pair[0, part], world.first_pair[0, part + 1]
        _push_class(world, team.forces, world.particle_law, first, last, team.sums[0, part])
        first, last = world.first_pair[1, part], world.first_pair[1, part + 1]
        _push_class(world, team.forces, world.wall_law, first, last, team.sums[1, part])


@inner
def _push_class(world, forces, law, first, last, sums):
    """Forces of pairs first ... last - 1, of one law; sums (8,): by mechanism."""
    for begin in range(first, last, BLOCK):
        end = min(begin + BLOCK, last)
        block = Forces(
            forces.fx[begin:end], forces.fy[begin:end], forces.torque_j[begin:end],
            forces.torque_i[begin:end], forces.normal_power[begin:end],
            forces.tangential_power[begin:end], forces.lost[begin:end],
        )  # fmt: skip
        contact_forces(
            world.bodies.row, world.inner, block, law, begin, end - begin, world.time_step
        )
    normal = tangential = lost = 0.0
    for n in range(first, last):
        normal += forces.normal_power[n]
        tangential += forces.tangential_power[n]
        lost += forces.lost[n]
    sums[0], sums[1], sums[2] = normal, tangential, lost


@inner
def _deliver(world, team, thread):
    """Add the forces on a thread's particles up."""
    row, inner, forces = world.bodies.row, world.inner, team.forces
    begins, ends = team.bounds[thread], team.bounds[thread + 1]
    for other in range(thread):
        for k in range(team.n_foreign[other, 0]):
            _add(row, inner, forces, team.foreign[other, k], begins, ends)
    for which in range(2):
        first = world.first_pair[which, team.parts[thread]]
        for n in range(first, world.first_pair[which, team.parts[thread + 1]]):
            _add(row, inner, forces, n, begins, ends)


@inlined
def _add(row, inner, forces, n, begins, ends):
    """Add the force of pair n to those of its bodies that are in a range."""
    j, i = inner.vertex_body[n], inner.edge_body[n]
    if begins <= j < ends:
        row[j, FX] += forces.fx[n]
        row[j, FY] += forces.fy[n]
        row[j, TORQUE] += forces.torque_j[n]
    if begins <= i < ends:
        row[i, FX] -= forces.fx[n]
        row[i, FY] -= forces.fy[n]
        row[i, TORQUE] += forces.torque_i[n]


@inner
def _push_walls(world, team):
    """Add the forces on the walls up, and what all pairs dissipate."""
    row, dt = world.bodies.row, world.time_step
    begins, ends = len(world.bodies.live), len(row)
    for n in range(world.first_pair[1, 0], world.first_pair[1, -1]):
        _add(row, world.inner, team.forces, n, begins, ends)
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
            forces=Forces(*(np.zeros(capacity) for _ in Forces._fields)),
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
