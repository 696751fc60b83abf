"""Multi-contact models: forces of the several contacts of a particle with another, or a wall.

    sum        each acts as if it were alone, as in the thesis: n of them are n times as stiff
    deepest    only the deepest acts; the spring goes with it from sphere to sphere
    scaled     together they hold the energy U = (sum of U_k^p)^(1/p), each with the share
               w_k = (U_k/U)^(p-1) of its force

U_k = (2/5) K_k d_k^2.5 is what a contact would hold alone: w_k K_k d_k^1.5 is the derivative of U
by d_k, so that scaled contacts have a potential, and the sum of w_k U_k is U. p = 1 is the sum,
p = infinity the deepest; p = 8 lets n equal contacts count for n^(1/8), 1.5 for 25. The reduced
mass is shared like the stiffness: then dashpots, and with them the restitution, scale like springs.
"""

import numpy as np

from damper3d.engine.geometry import touching_pairs
from damper3d.engine.multisphere.particles import DEEPEST, SUM
from damper3d.engine.state import DAMPING, HERTZ, MASS, N_HISTORY, NO_CONTACT
from damper3d.engine.walls import distance_to_wall, touching_wall
from granulab.contact.jit import inlined_inner, inner

_POWER = 8.0  # p


@inlined_inner
def acting_pairs(world, first, last):
    """Let `touching`, from `first` on, name those of pairs first ... last - 1 that act.

    Returns where they end.
    """
    end = touching_pairs(world.spheres, world.inner, first, last, world.block)
    return end if world.shape.treatment == SUM else treat_pairs(world, first, end)


@inlined_inner
def acting_at_wall(world, w, first, last):
    """The same of contacts with wall w."""
    end = touching_wall(world.spheres, world.walls, world.wall, w, first, last, world.block)
    return end if world.shape.treatment == SUM else treat_wall(world, w, first, end)


@inner
def treat_pairs(world, first, end):
    """Treat the touching pairs of each pair of particles."""
    contacts, x, depth = world.inner, world.spheres.position, world.shape.scratch.depth
    for t in range(first, end):
        n = contacts.touching[t]
        i, j = contacts.i[n], contacts.j[n]
        dx, dy, dz = x[j, 0] - x[i, 0], x[j, 1] - x[i, 1], x[j, 2] - x[i, 2]
        depth[t] = max(contacts.cutoff[n] - np.sqrt(dx * dx + dy * dy + dz * dz), 0.0)
    return treat(world, contacts, first, end)


@inner
def treat_wall(world, w, first, end):
    """Treat the touching contacts of each particle with wall w."""
    contacts, walls, x = world.wall, world.walls, world.spheres.position
    depth = world.shape.scratch.depth
    last = len(x) - 1
    for t in range(first, end):
        n = contacts.touching[t]
        i = contacts.i[n]
        px, py, pz = x[i, 0] - x[last, 0], x[i, 1] - x[last, 1], x[i, 2] - x[last, 2]
        distance = distance_to_wall(walls, w, px, py, pz)
        depth[t] = max(contacts.cutoff[n] - distance, 0.0)
    return treat(world, contacts, first, end)


@inner
def treat(world, contacts, first, last):
    """Treat the contacts that touch, group by group; where those that are left end."""
    begin = left = first
    while begin < last:
        end, group = begin + 1, contacts.group[contacts.touching[begin]]
        while end < last and contacts.group[contacts.touching[end]] == group:
            end += 1
        if world.shape.treatment == DEEPEST:
            contacts.touching[left] = keep_deepest(contacts, world.shape.scratch.depth, begin, end)
            left += 1
        else:
            share(contacts, contacts.whole, world.shape.scratch.depth, begin, end)
            left = end
        begin = end
    return left


@inner
def keep_deepest(contacts, depth, begin, end):
    """The deepest of a group, with the history of the one that was; or the one that has ended."""
    deepest, known = begin, -1
    for t in range(begin, end):
        if depth[t] > depth[deepest]:
            deepest = t
        if contacts.history[contacts.touching[t], DAMPING] >= 0.0:
            known = t
    if depth[deepest] == 0.0:
        return contacts.touching[max(known, begin)]  # none touches: a history lets it be named
    n = contacts.touching[deepest]
    if known >= 0 and known != deepest:
        old = contacts.touching[known]
        for h in range(N_HISTORY):
            contacts.history[n, h] = contacts.history[old, h]
            contacts.history[old, h] = 0.0
        contacts.history[old, DAMPING] = NO_CONTACT
    return n


@inner
def share(contacts, whole, depth, begin, end):
    """Scale stiffness and mass of the contacts of a group to their shares."""
    largest = total = 0.0
    for t in range(begin, end):
        largest = max(largest, energy(whole, contacts.touching[t], depth[t]))
    for t in range(begin, end):
        if largest > 0.0:
            total += (energy(whole, contacts.touching[t], depth[t]) / largest) ** _POWER
    for t in range(begin, end):
        n = contacts.touching[t]
        part = energy(whole, n, depth[t]) / largest if largest > 0.0 else 0.0
        of_all = part ** (_POWER - 1.0) / max(total, 1.0) ** (1.0 - 1.0 / _POWER)
        contacts.constants[n, HERTZ] = of_all * whole[n, 0]
        contacts.constants[n, MASS] = of_all * whole[n, 1]


@inner
def energy(whole, n, depth):
    """Return what contact n would hold alone, but for the factor 2/5 [J]."""
    return whole[n, 0] * depth * depth * np.sqrt(depth)
