"""Assembly: the forces of all contacts, added to spheres and walls, and what they dissipate.

Passes over blocks of the contacts that touch (geometry.py): their spheres' rows (simd.py), where
they touch (geometry.py), what the law says, and adding it up. The first three have no branch and
are vectorised; a contact that has just ended has overlap 0, which makes its forces exact zeros. The
last goes in the order of the list, which is that of the sphere numbers.

The displacement of a contact over a step is the mean of its velocities at both ends times the
step, so that no velocity need be gathered twice.
"""

import numpy as np
from numba import types

from damper3d.engine.geometry import between_spheres, entry, put, surface_motion
from damper3d.engine.kinds import alone, find_at_wall, find_pairs
from damper3d.engine.laws.balance import (
    NO_LOSS,
    add_and_sum,
    add_to_balance,
    added,
    take_heat,
    take_totals,
)
from damper3d.engine.laws.rolling import roll
from damper3d.engine.laws.table import (
    face_wall,
    halo,
    law_of,
    normal_force,
    note_laws,
    tear,
    without_slip,
)
from damper3d.engine.motions.turning import count_turning, turn_wall, without_walls
from damper3d.engine.shared.results import keep_results
from damper3d.engine.simd import gather, keep_history, whole
from damper3d.engine.state import (
    BEGUN,
    BEYOND,
    BLOCK,
    DAMPING,
    FASTEST,
    HERTZ,
    MASS,
    MOVED_X,
    MOVED_Y,
    MOVED_Z,
    N_MECHANISMS,
    NO_CONTACT,
    SPRING_X,
    SPRING_Y,
    SPRING_Z,
    STEP,
    STIFFNESS,
    WALL_WORK,
    YIELD,
)
from damper3d.engine.walls import bend, place_wall, with_wall
from granulab.contact.hertz import (
    damping_of_impact,
    mindlin_force,
    spring_work,
    with_history,
)
from granulab.contact.jit import inlined_inner, specialised
from granulab.contact.vectors import add, cross, dot, scale

_LOOK = 16  # steps after which it is seen again how many pairs of a list touch
_MOST = 0.8  # of the pairs of a list


@inlined_inner
def apply_forces(world, shift, speed):
    """All contact forces of this step and the energy balance; shift and speed are the enclosure's.

    The balance is summed over all blocks of a part, or of the walls, in the order of the list.
    """
    walls, balance, bed = world.walls, world.balance, without_walls(world)
    sums = NO_LOSS
    for part in range(len(world.parts) - 1):
        sums = added(sums, push_pairs(bed, part))
    add_to_balance(balance, 0, sums, world.time_step)
    for w in range(len(walls.force)):
        place_wall(world.spheres, walls, w, shift, speed)
        face_wall(world.wall_law, w)
        push_at_wall(world, w, walls.first[w], walls.first[w + 1])
        balance[WALL_WORK] -= world.time_step * take_push(world, walls.force[w])
    add_to_balance(balance, N_MECHANISMS, take_totals(world.block), world.time_step)


@inlined_inner
def push_pairs(world, part):
    """Forces of the pairs of a part; sums of what they dissipate, see take_totals."""
    block = world.block
    first = world.first_pair[part]
    end = choose_pairs(world, part)
    for begin in range(first, end, BLOCK):
        n = min(end - begin, BLOCK)
        gather(world.spheres, world.inner, begin, n, block)
        between_spheres(whole(n), block)
        note_laws(world.pair_law, world.inner, begin, n, block, 2.0 * halo(world.pair_law))
        push_and_count(world, world.pair_law, world.inner, begin, n, 0)
    return take_totals(block)


@inlined_inner
def choose_pairs(world, part):
    """Let `touching` name the pairs of a part that act; where they end.

    All of them where most touched not long ago: those that do not touch add exact zeros, which
    takes less than to find them out.
    """
    first, last = world.first_pair[part], world.first_pair[part + 1]
    if world.packed[part] and world.counts[STEP] % _LOOK != 0:
        for n in range(np.uintp(first), np.uintp(last)):
            world.inner.touching[n] = n
        return last
    end = find_pairs(world, first, last)
    world.packed[part] = alone(world.shape) and end - first > _MOST * (last - first)
    return end


@inlined_inner
def push_at_wall(world, w, first, last):
    """Forces of contacts first ... last - 1, with wall w; where those that touch end."""
    block = world.block
    bend(world, w, first, last)
    end = find_at_wall(world, w, first, last)
    for begin in range(first, end, BLOCK):
        n = min(end - begin, BLOCK)
        meet_wall(world.spheres, world.walls, world.wall, w, begin, n, block)
        turn_wall(world, n, block)
        note_laws(world.wall_law, world.wall, begin, n, block, halo(world.wall_law))
        push_and_count(world, world.wall_law, world.wall, begin, n, 1)
        count_turning(world, n, block)
    return end


@inlined_inner
def meet_wall(spheres, walls, contacts, w, begin, n_contacts, block):
    """Geometry of contacts with wall w."""
    gather(spheres, contacts, begin, n_contacts, block)
    with_wall(walls, contacts, w, begin, n_contacts, block)


@inlined_inner
def take_push(world, force):
    """Move the force that a wall's contacts left in the last row to the wall; its power.

    And wipe the couples of rolling there, which do no work on a wall that does not turn.
    """
    spheres, last = world.spheres, len(world.spheres.inverse_mass)
    take_heat(world.particles.dissipated, spheres.torque, last)
    for c in range(4):
        spheres.torque[last, c] = 0.0
    power = 0.0
    for c in range(3):
        power += spheres.force[last, c] * spheres.velocity[last, c]
        force[c] += spheres.force[last, c]
        spheres.force[last, c] = 0.0
    return power


@inlined_inner
def push_and_count(world, law, contacts, begin, n_contacts, which):
    """Hand on the forces of a block of a class, 0 or 1, to their spheres."""
    block = world.block
    contact_law(law, whole(n_contacts), block, world.time_step)
    begin_contacts(law, n_contacts, block, world.impacts[which])
    keep_history(contacts, begin, n_contacts, block)
    hand_on(world, law, contacts, begin, n_contacts, which)


def hand_on(world, law, contacts, begin, n_contacts, which):
    """Add the forces of a block to their spheres, or keep them for threads that will."""


@specialised(hand_on)
def _hand_on(world, law, contacts, begin, n_contacts, which):
    if isinstance(world[world.fields.index("results")], types.NoneType):
        return lambda world, law, contacts, begin, n_contacts, which: add_at_once(
            world, law, contacts, begin, n_contacts
        )
    return lambda world, law, contacts, begin, n_contacts, which: keep_results(
        world, contacts, begin, n_contacts, which
    )


@inlined_inner
def add_at_once(world, law, contacts, begin, n_contacts):
    """Add the forces of a block, and what its contacts lose, to their spheres."""
    spheres, block, dt = world.spheres, world.block, world.time_step
    touching = contacts.touching
    add_and_sum(spheres, contacts.i, contacts.j, touching, begin, n_contacts, block)
    roll(world, law, contacts, begin, n_contacts)
    tear(law, spheres, contacts, begin, n_contacts, block, dt)


@inlined_inner
def contact_law(law, n_contacts, block, dt):
    """Forces, histories and dissipation of a block whose geometry is known."""
    if law.stored_force:  # out of the loop, where both ways would be calculated
        apply_law(law, True, n_contacts, block, dt)
    else:
        apply_law(law, False, n_contacts, block, dt)


@inlined_inner
def apply_law(laws, stored_force, n_contacts, block, dt):
    """See contact_law."""
    history, next_history = block.history, block.next_history
    for k in range(np.uintp(n_contacts)):
        overlap = block.overlap[k]
        touches = 1.0 if overlap > 0.0 else 0.0
        law = with_history(law_of(laws, k), stored_force)
        normal, rate, slip_rate = surface_motion(block, k)
        known = history[entry(DAMPING, k)]
        damping = max(known, law.damping)
        hertz, mass = block.constants[entry(HERTZ, k)], block.constants[entry(MASS, k)]
        stiffness, dashpot, f_n, inelastic, load = normal_force(
            laws, law, hertz, mass, damping, overlap, rate, k
        )
        kt, kt_before = law.tangential * stiffness, history[entry(STIFFNESS, k)]
        moved = scale(0.5 * dt, slip_rate)
        held_before, trial = without_slip(law, history, k, normal, kt_before, kt, moved)
        force, held, power, slides = mindlin_force(law, stiffness, dashpot, load, trial, slip_rate)
        friction_work, stiffness_work = spring_work(law, kt_before, kt, held_before, trial, held)

        nothing = 0.0, 0.0, 0.0  # not a product with 0: that may be -0
        held, moved = (held, moved) if overlap > 0.0 else (nothing, nothing)
        (
            next_history[entry(SPRING_X, k)],
            next_history[entry(SPRING_Y, k)],
            next_history[entry(SPRING_Z, k)],
        ) = held
        (
            next_history[entry(MOVED_X, k)],
            next_history[entry(MOVED_Y, k)],
            next_history[entry(MOVED_Z, k)],
        ) = moved
        next_history[entry(STIFFNESS, k)] = kt
        next_history[entry(DAMPING, k)] = damping if overlap > 0.0 else NO_CONTACT
        block.impact_speed[k] = touches * rate if known < 0.0 else 0.0
        put(block.couple, k, cross(normal, force))
        put(block.push, k, add(force, scale(f_n, normal)))
        block.normal_power[k] = inelastic * rate
        block.tangential_power[k] = power
        block.friction_work[k] = touches * friction_work
        block.stiffness_work[k] = touches * stiffness_work
        block.slip_power[k] = -slides * dot(force, slip_rate)
        block.lost[k] = touches * 0.5 * ((inelastic * rate + power) * dt + friction_work)


@inlined_inner
def begin_contacts(law, n_contacts, block, impacts):
    """Note the impacts that begin, and the damping that goes with their speeds."""
    for k in range(np.uintp(n_contacts)):
        speed = block.impact_speed[k]
        if speed > 0.0:
            impacts[FASTEST] = max(impacts[FASTEST], speed)
            impacts[BEGUN] += 1.0
            impacts[BEYOND] += 1.0 if speed > impacts[YIELD] else 0.0
            hertz, mass = block.constants[entry(HERTZ, k)], block.constants[entry(MASS, k)]
            block.next_history[entry(DAMPING, k)] = damping_of_impact(
                law_of(law, k), hertz, mass, speed
            )
