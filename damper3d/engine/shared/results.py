"""Forces of contacts that are handed to other threads, where several share a step.

A thread works on consecutive parts: on the pairs whose first sphere is its own. The second sphere
may be another's, with a number beyond its own. Such a sphere "waits": its forces of other threads
come first in the list, and are added before those of its own thread. So of each pair that has a
sphere which waits or is another's the force is kept, and added when all threads have come so far:
first what others hand over, then the thread's own, both in the order of the list. All other forces
are added at once. That is the order in which one thread adds the forces of each sphere, so that the
sums have the same bits.
"""

from typing import NamedTuple

import numpy as np

from damper3d.engine.geometry import vector
from damper3d.engine.laws.balance import NO_LOSS, add_and_sum
from damper3d.engine.simd import add_loads
from damper3d.engine.state import N_MECHANISMS, zeros
from granulab.contact.jit import inlined_inner, inner
from granulab.contact.vectors import scale

FIRST_ROW, N_ROWS = range(2)  # entries of Results.rows


class Loads(NamedTuple):
    """Loads of contacts that are kept for a moment; of each thread from its first contact on."""

    contact: np.ndarray  # (capacity,) uint32 which of the list
    push: np.ndarray  # (capacity, 4) force on the second, its opposite acts on the first [N]
    turn_i: np.ndarray  # (capacity, 4) torque on the first, but for its sign [N m], heat [J]
    turn_j: np.ndarray  # (capacity, 4) and on the second
    powers: np.ndarray  # (capacity, N_MECHANISMS) of contacts with walls, see laws.balance


class Results(NamedTuple):
    """Rows to which a thread adds the loads of its contacts, or where it keeps them."""

    pairs: Loads
    walls: Loads
    to_i: np.ndarray  # (capacity,) uint32 of each pair, row that takes the load of its first sphere
    to_j: np.ndarray  # (capacity,) uint32 and of its second; the unread one where the load is kept
    of_wall: np.ndarray  # (capacity,) uint32 unread rows, for the enclosure
    waits: np.ndarray  # (m,) of each sphere, whether it waits
    bounds: np.ndarray  # (n_threads + 1,) where the spheres of each thread begin
    thread: int
    foreign: np.ndarray  # (capacity,) uint32 those rows of `pairs` whose second is another's
    n_foreign: np.ndarray  # (1 or more,) how many
    rows: np.ndarray  # (2,) of `pairs` that this thread fills: the first, and how many this step


def room_for(capacity: int, n_powers: int) -> Loads:
    """Room for the loads of so many contacts."""
    rows = (zeros(capacity, 4) for _ in range(3))
    powers = np.zeros((n_powers, N_MECHANISMS))
    return Loads(np.zeros(capacity, np.uint32), *rows, powers=powers)


@inner
def mark_waiting(world, first, last):
    """Mark the other threads' spheres of pairs first ... last - 1, which a thread works on."""
    results, j = world.results, world.inner.j
    own_end = results.bounds[results.thread + 1]
    for n in range(first, last):
        if j[n] >= own_end:
            results.waits[j[n]] = True


@inner
def choose_rows(world, first, last, unread):
    """Choose the rows that take the loads of pairs first ... last - 1 of a thread."""
    results, pairs = world.results, world.inner
    own_end = results.bounds[results.thread + 1]
    for n in range(first, last):
        i, j = pairs.i[n], pairs.j[n]
        results.to_i[n] = unread if results.waits[i] else i
        results.to_j[n] = unread if j >= own_end or results.waits[j] else j


@inlined_inner
def keep_results(world, contacts, begin, n_contacts, which):
    """Add the loads of a block of a class, 0 or 1, or keep them."""
    if which == 0:
        _of_pairs(world, contacts, begin, n_contacts)
    else:
        _of_walls(world, contacts, begin, n_contacts)


@inlined_inner
def _of_pairs(world, contacts, begin, n_contacts):
    results, block = world.results, world.block
    to_i, to_j = results.to_i, results.to_j
    add_and_sum(world.spheres, to_i, to_j, contacts.touching, begin, n_contacts, block)
    for k in range(np.uintp(n_contacts)):
        n = contacts.touching[np.uintp(begin) + k]
        if to_i[n] != contacts.i[n] or to_j[n] != contacts.j[n]:
            _keep_pair(world, n, contacts.j[n], k)


@inlined_inner
def _keep_pair(world, n, j, k):
    """Keep the load of pair n, contact k of the block, and name it if sphere j is another's."""
    results = world.results
    row = results.rows[FIRST_ROW] + results.rows[N_ROWS]
    results.rows[N_ROWS] += 1
    _keep_load(results.pairs, row, n, world.block, k)
    if j >= results.bounds[results.thread + 1]:
        results.foreign[results.n_foreign[0]] = row
        results.n_foreign[0] += 1


@inlined_inner
def _keep_load(kept, row, n, block, k):
    push, couple = vector(block.push, k), vector(block.couple, k)
    turn_i, turn_j = scale(block.arm_i[k], couple), scale(block.arm_j[k], couple)
    kept.contact[row] = n
    for c in range(3):
        kept.push[row, c], kept.turn_i[row, c], kept.turn_j[row, c] = push[c], turn_i[c], turn_j[c]
    kept.turn_i[row, 3] = kept.turn_j[row, 3] = block.lost[k]


@inlined_inner
def _of_walls(world, contacts, begin, n_contacts):
    """Add the loads of contacts with a wall to the spheres, and keep them for the enclosure."""
    results, block = world.results, world.block
    kept, touching = results.walls, contacts.touching
    to_wall = results.of_wall
    add_loads(world.spheres, contacts.i, to_wall, touching, begin, n_contacts, block, NO_LOSS)
    for k in range(np.uintp(n_contacts)):
        row = np.uintp(begin) + k
        _keep_load(kept, row, touching[row], block, k)
        powers = (
            block.normal_power[k], block.tangential_power[k], block.friction_work[k],
            block.stiffness_work[k], block.slip_power[k],
        )  # fmt: skip
        for c in range(N_MECHANISMS):
            kept.powers[row, c] = powers[c]


@inlined_inner
def deliver(world, foreign, n_foreign):
    """Add the loads that were kept to the spheres of a thread.

    foreign (n_threads, capacity), n_foreign (n_threads, 1 or more): what each thread named.
    """
    results, pairs = world.results, world.inner
    kept, thread = results.pairs, results.thread
    own_begin, own_end = results.bounds[thread], results.bounds[thread + 1]
    for other in range(thread):
        for m in range(n_foreign[other, 0]):
            row = foreign[other, m]
            j = pairs.j[kept.contact[row]]
            if own_begin <= j < own_end:
                _add_to_second(world.spheres, kept, row, j)
    for row in range(results.rows[FIRST_ROW], results.rows[FIRST_ROW] + results.rows[N_ROWS]):
        n = kept.contact[row]
        i, j = pairs.i[n], pairs.j[n]
        if results.to_i[n] != i:
            _add_to_first(world.spheres, kept, row, i)
        if j < own_end and results.to_j[n] != j:
            _add_to_second(world.spheres, kept, row, j)


@inlined_inner
def _add_to_first(spheres, kept, row, i):
    for c in range(4):
        spheres.force[i, c] -= kept.push[row, c]
        spheres.torque[i, c] -= kept.turn_i[row, c]


@inlined_inner
def _add_to_second(spheres, kept, row, j):
    for c in range(4):
        spheres.force[j, c] += kept.push[row, c]
        spheres.torque[j, c] -= kept.turn_j[row, c]


@inlined_inner
def push_enclosure(world, first, end):
    """Add the loads of contacts with a wall to the enclosure, and to the totals."""
    kept, last, totals = world.results.walls, len(world.spheres.inverse_mass), world.block.totals
    for row in range(first, end):
        _add_to_second(world.spheres, kept, row, last)
        for c in range(N_MECHANISMS):
            totals[c] += kept.powers[row, c]
