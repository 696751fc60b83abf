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
from damper3d.engine.simd import add_loads
from damper3d.engine.state import zeros
from granulab.contact.jit import inlined_inner, inner
from granulab.contact.vectors import scale


class Kept(NamedTuple):
    """Loads of contacts that are kept for a moment; of each thread from its first contact on."""

    contact: np.ndarray  # (capacity,) uint32 which of the list
    push: np.ndarray  # (capacity, 4) force on the second, its opposite acts on the first [N]
    turn_i: np.ndarray  # (capacity, 4) torque on the first, but for its sign [N m]
    turn_j: np.ndarray  # (capacity, 4) and on the second
    lost: np.ndarray  # (capacity,) half of what is dissipated [J]
    powers: np.ndarray  # (capacity, 5) of contacts with walls: what forces.add_dissipated sums


class Results(NamedTuple):
    """Rows to which a thread adds the loads of its contacts, or where it keeps them."""

    pairs: Kept
    walls: Kept
    to_i: np.ndarray  # (capacity,) uint32 of each pair, row that takes the load of its first sphere
    to_j: np.ndarray  # (capacity,) uint32 and of its second; the unread one where the load is kept
    of_wall: np.ndarray  # (capacity,) uint32 unread rows, for the enclosure
    waits: np.ndarray  # (m,) of each sphere, whether it waits
    bounds: np.ndarray  # (n_threads + 1,) where the spheres of each thread begin
    thread: int
    foreign: np.ndarray  # (n_threads, capacity) uint32 rows of pairs.kept, by whose they are
    n_foreign: np.ndarray  # (n_threads,)
    own: np.ndarray  # (2,) row from which on pairs are kept, and how many are in this step


def room_for(capacity: int, n_powers: int) -> Kept:
    """Room for the loads of so many contacts."""
    rows = (zeros(capacity, 4) for _ in range(3))
    powers = np.zeros((n_powers, 5))
    return Kept(np.zeros(capacity, np.uint32), *rows, lost=np.zeros(capacity), powers=powers)


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
def keep_results(world, contacts, begin, n_contacts, which, sums):
    """Add the loads of a block of a class, 0 or 1, or keep them; the sums with those of pairs."""
    if which == 0:
        return _of_pairs(world, contacts, begin, n_contacts, sums)
    _of_walls(world, contacts, begin, n_contacts)
    return sums


@inlined_inner
def _of_pairs(world, contacts, begin, n_contacts, sums):
    results, block, heat = world.results, world.block, world.particles.dissipated
    to_i, to_j = results.to_i, results.to_j
    add_loads(world.spheres, to_i, to_j, contacts.touching, begin, n_contacts, block)
    normal, tangential, friction_work, stiffness_work, slipped = sums
    for k in range(np.uintp(n_contacts)):
        n, lost = contacts.touching[np.uintp(begin) + k], 0.0
        i, j = contacts.i[n], contacts.j[n]
        if block.overlap[k] > 0.0:
            lost = 0.5 * _lost(world, k)
            normal += block.normal_power[k]
            tangential += block.tangential_power[k]
            friction_work += block.friction_work[k]
            stiffness_work += block.stiffness_work[k]
            slipped += block.slip_power[k]
            if to_i[n] == i:
                heat[i] += lost
            if to_j[n] == j:
                heat[j] += lost
        if to_i[n] != i or to_j[n] != j:
            _keep_pair(world, n, j, lost, k)
    return normal, tangential, friction_work, stiffness_work, slipped


@inlined_inner
def _lost(world, k):
    """Energy that contact k of the block dissipates in this step [J]."""
    block = world.block
    power = block.normal_power[k] + block.tangential_power[k]
    return power * world.time_step + block.friction_work[k]


@inlined_inner
def _keep_pair(world, n, j, lost, k):
    """Keep the load of pair n, contact k of the block, and name it to whose sphere j is."""
    results, block = world.results, world.block
    row = results.own[0] + results.own[1]
    results.own[1] += 1
    _keep_load(results.pairs, row, n, block, k, lost)
    other = results.thread
    while j >= results.bounds[other + 1]:
        other += 1
    if other > results.thread:
        results.foreign[other, results.n_foreign[other]] = row
        results.n_foreign[other] += 1


@inlined_inner
def _keep_load(kept, row, n, block, k, lost):
    push, couple = vector(block.push, k), vector(block.couple, k)
    turn_i, turn_j = scale(block.arm_i[k], couple), scale(block.arm_j[k], couple)
    kept.contact[row], kept.lost[row] = n, lost
    for c in range(3):
        kept.push[row, c], kept.turn_i[row, c], kept.turn_j[row, c] = push[c], turn_i[c], turn_j[c]


@inlined_inner
def _of_walls(world, contacts, begin, n_contacts):
    """Add the loads of contacts with a wall to the spheres, and keep them for the enclosure."""
    results, block, heat = world.results, world.block, world.particles.dissipated
    kept, touching = results.walls, contacts.touching
    add_loads(world.spheres, contacts.i, results.of_wall, touching, begin, n_contacts, block)
    for k in range(np.uintp(n_contacts)):
        row = np.uintp(begin) + k
        touches = block.overlap[k] > 0.0
        lost = 0.5 * _lost(world, k) if touches else 0.0
        heat[contacts.i[touching[row]]] += lost
        push = vector(block.push, k)
        for c in range(3):
            kept.push[row, c] = push[c]
        kept.lost[row] = lost
        powers = (
            block.normal_power[k], block.tangential_power[k], block.friction_work[k],
            block.stiffness_work[k], block.slip_power[k],
        )  # fmt: skip
        for c in range(5):
            kept.powers[row, c] = powers[c] if touches else 0.0


@inlined_inner
def deliver(world, foreign, n_foreign):
    """Add the loads that were kept to the spheres of a thread.

    foreign (n_threads, n_threads, capacity), n_foreign: the pairs that each thread named to each.
    """
    results, pairs, heat = world.results, world.inner, world.particles.dissipated
    kept, thread = results.pairs, results.thread
    for other in range(thread):
        for m in range(n_foreign[other, thread]):
            row = foreign[other, thread, m]
            j = pairs.j[kept.contact[row]]
            _add_to_second(world.spheres, kept, row, j)
            heat[j] += kept.lost[row]
    own_end = results.bounds[thread + 1]
    for row in range(results.own[0], results.own[0] + results.own[1]):
        n = kept.contact[row]
        i, j = pairs.i[n], pairs.j[n]
        if results.to_i[n] != i:
            _add_to_first(world.spheres, kept, row, i)
            heat[i] += kept.lost[row]
        if j < own_end and results.to_j[n] != j:
            _add_to_second(world.spheres, kept, row, j)
            heat[j] += kept.lost[row]


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
def push_enclosure(world, first, end, sums):
    """Add the loads of contacts with a wall to the enclosure; the sums with what they dissipate."""
    kept, last = world.results.walls, len(world.spheres.inverse_mass)
    force, heat = world.spheres.force, world.particles.dissipated
    normal, tangential, friction_work, stiffness_work, slipped = sums
    for row in range(first, end):
        for c in range(3):
            force[last, c] += kept.push[row, c]
        heat[last] += kept.lost[row]
        normal += kept.powers[row, 0]
        tangential += kept.powers[row, 1]
        friction_work += kept.powers[row, 2]
        stiffness_work += kept.powers[row, 3]
        slipped += kept.powers[row, 4]
    return normal, tangential, friction_work, stiffness_work, slipped
