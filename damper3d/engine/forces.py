"""Assembly: the forces of all contacts, added to spheres and walls, and what they dissipate.

Passes over blocks of the contacts that touch (touching.py): their spheres' rows (lanes.py), where
they touch (geometry.py), what the law says, and adding it up. The first three have no branch and
are vectorised; a contact that has just ended has overlap 0, which makes its forces exact zeros. The
last goes in the order of the list, which is that of the sphere numbers.

The displacement of a contact over a step is the mean of its velocities at both ends times the
step, so that no velocity need be gathered twice.
"""

import numpy as np

from damper3d.engine.geometry import between_spheres, place, put, vector
from damper3d.engine.kinds import find_at_wall, find_pairs
from damper3d.engine.simd import add_loads, gather, keep_history, whole
from damper3d.engine.state import (
    BLOCK,
    DAMPING,
    FRICTION,
    HERTZ,
    LAW_TERM,
    MASS,
    MOVED_X,
    MOVED_Y,
    MOVED_Z,
    N_MECHANISMS,
    NO_CONTACT,
    NORMAL_DAMPING,
    SLIP_COUNT,
    SPRING_X,
    SPRING_Y,
    SPRING_Z,
    STIFFNESS,
    TANGENTIAL_DAMPING,
    WALL_WORK,
)
from damper3d.engine.walls import place_wall, with_wall
from granulab.contact.hertz import damping_of_impact, hertz_force, mindlin_force, with_history
from granulab.contact.jit import inlined_inner, inner
from granulab.contact.spring_account import spring_account
from granulab.contact.vectors import add, cross, dot, scale


@inlined_inner
def apply_forces(world, shift, speed):
    """All contact forces of this step and the books; shift and speed are the enclosure's.

    The books are summed over all blocks of a class in the order of the list.
    """
    spheres, walls, block, books = world.spheres, world.walls, world.block, world.books
    sums = 0.0, 0.0, 0.0, 0.0, 0.0
    n_touching = find_pairs(world)
    for begin in range(np.int64(0), n_touching, BLOCK):
        n = min(n_touching - begin, BLOCK)
        gather(spheres, world.close, begin, n, block)
        between_spheres(whole(n), block)
        sums = push_and_count(world, world.pair_law, world.close, begin, n, 0, sums)
    keep_books(books, 0, sums, world.time_step)
    sums = 0.0, 0.0, 0.0, 0.0, 0.0
    for w in range(len(walls.force)):
        place_wall(spheres, walls, w, shift, speed)
        n_touching = find_at_wall(world, w)
        for begin in range(np.int64(0), n_touching, BLOCK):
            n = min(n_touching - begin, BLOCK)
            meet_wall(spheres, walls, world.wall, w, begin, n, block)
            sums = push_and_count(world, world.wall_law, world.wall, begin, n, 1, sums)
        books[WALL_WORK] -= world.time_step * take_push(spheres, walls.force[w])
    keep_books(books, N_MECHANISMS, sums, world.time_step)


@inlined_inner
def meet_wall(spheres, walls, contacts, w, begin, n_contacts, block):
    """Geometry of contacts with wall w."""
    gather(spheres, contacts, begin, n_contacts, block)
    with_wall(walls, w, whole(n_contacts), block)


@inlined_inner
def take_push(spheres, force):
    """Move the force that a wall's contacts left in the last row to the wall; its power."""
    last = len(spheres.inverse_mass)
    power = 0.0
    for c in range(3):
        power += spheres.force[last, c] * spheres.velocity[last, c]
        force[c] += spheres.force[last, c]
        spheres.force[last, c] = 0.0
    return power


@inlined_inner
def push_and_count(world, law, contacts, begin, n_contacts, which, sums):
    """Forces of a block of a class, 0 or 1, to their spheres; the sums of the books with theirs."""
    block, dt = world.block, world.time_step
    contact_law(law, whole(n_contacts), block, dt)
    begin_contacts(law, n_contacts, block, world.fastest, which)
    keep_history(contacts, begin, n_contacts, block)
    add_loads(world.spheres, contacts, begin, n_contacts, block)
    return add_heat(world.bodies.heat, contacts, begin, n_contacts, block, dt, sums)


@inner
def surface_motion(block, k):
    """Of contact k: normal, rate of the overlap [m/s], velocity of slip [m/s]."""
    normal, velocity = vector(block.normal, k), vector(block.velocity, k)
    rate = -dot(velocity, normal)
    return normal, rate, add(velocity, scale(rate, normal))


@inlined_inner
def contact_law(law, n_contacts, block, dt):
    """Forces, histories and dissipation of a block whose geometry is known."""
    if law.stored_force:  # out of the loop, where both ways would be calculated
        apply_law(with_history(law, True), n_contacts, block, dt)
    else:
        apply_law(with_history(law, False), n_contacts, block, dt)


@inlined_inner
def apply_law(law, n_contacts, block, dt):
    """See contact_law."""
    history, later = block.history, block.later
    for k in range(np.uintp(n_contacts)):
        overlap = block.overlap[k]
        touches = 1.0 if overlap > 0.0 else 0.0
        normal, rate, slip_rate = surface_motion(block, k)
        known = history[place(DAMPING, k)]
        damping = max(known, law.damping)
        hertz, mass = block.constants[place(HERTZ, k)], block.constants[place(MASS, k)]
        stiffness, dashpot, f_n, inelastic = hertz_force(law, hertz, mass, damping, overlap, rate)
        kt, kt_before = law.tangential * stiffness, history[place(STIFFNESS, k)]
        moved = scale(0.5 * dt, slip_rate)
        held_before, trial = without_slip(law, history, k, normal, kt_before, kt, moved)
        force, held, power, slides = mindlin_force(law, stiffness, dashpot, f_n, trial, slip_rate)
        rubbed, gained = spring_account(law, kt_before, kt, held_before, trial, held)

        nothing = 0.0, 0.0, 0.0  # not a product with 0: that may be -0
        held, moved = (held, moved) if overlap > 0.0 else (nothing, nothing)
        later[place(SPRING_X, k)], later[place(SPRING_Y, k)], later[place(SPRING_Z, k)] = held
        later[place(MOVED_X, k)], later[place(MOVED_Y, k)], later[place(MOVED_Z, k)] = moved
        later[place(STIFFNESS, k)] = kt
        later[place(DAMPING, k)] = damping if overlap > 0.0 else NO_CONTACT
        block.begins[k] = touches * rate if known < 0.0 else 0.0
        put(block.couple, k, cross(normal, force))
        put(block.push, k, add(force, scale(f_n, normal)))
        block.normal_power[k] = inelastic * rate
        block.tangential_power[k] = power
        block.rubbed[k] = touches * rubbed
        block.gained[k] = touches * gained
        block.slip_power[k] = -slides * dot(force, slip_rate)


@inner
def without_slip(law, history, k, normal, kt_before, kt, moved):
    """Load of the spring of contact k at the step before, and the one of now if it did not slip.

    Both in the tangent plane of now. The displacement since then is the mean of the velocities of
    then and now times the step: half of it is known from then, the other half is `moved` [m].
    """
    held = history[place(SPRING_X, k)], history[place(SPRING_Y, k)], history[place(SPRING_Z, k)]
    ahead = history[place(MOVED_X, k)], history[place(MOVED_Y, k)], history[place(MOVED_Z, k)]
    held = add(held, scale(-dot(held, normal), normal))
    ahead = add(ahead, scale(-dot(ahead, normal), normal))
    if law.stored_force:
        return held, add(held, add(scale(kt_before, ahead), scale(kt, moved)))
    return held, add(held, add(ahead, moved))


@inlined_inner
def begin_contacts(law, n_contacts, block, fastest, which):
    """Note the speeds of impacts that begin, and the damping that goes with them."""
    for k in range(np.uintp(n_contacts)):
        speed = block.begins[k]
        if speed > 0.0:
            fastest[which] = max(fastest[which], speed)
            block.later[place(DAMPING, k)] = damping_of_impact(
                law, block.constants[place(HERTZ, k)], block.constants[place(MASS, k)], speed
            )


@inlined_inner
def add_heat(heat, contacts, begin, n_contacts, block, dt, sums):
    """Half of what each contact dissipates to each of its spheres; the sums by mechanism.

    A wall's half goes to the enclosure's entry, the last.
    """
    normal, tangential, rubbed, gained, slipped = sums
    for k in range(np.uintp(n_contacts)):
        if block.overlap[k] > 0.0:
            n = contacts.touching[np.uintp(begin) + k]
            lost = (block.normal_power[k] + block.tangential_power[k]) * dt + block.rubbed[k]
            heat[contacts.i[n]] += 0.5 * lost
            heat[contacts.j[n]] += 0.5 * lost
            normal += block.normal_power[k]
            tangential += block.tangential_power[k]
            rubbed += block.rubbed[k]
            gained += block.gained[k]
            slipped += block.slip_power[k]
    return normal, tangential, rubbed, gained, slipped


@inlined_inner
def keep_books(books, first, sums, dt):
    """Add what was dissipated in this step to the books of a class."""
    books[first + NORMAL_DAMPING] += sums[0] * dt
    books[first + TANGENTIAL_DAMPING] += sums[1] * dt
    books[first + FRICTION] += sums[2]
    books[first + LAW_TERM] += sums[3]
    books[first + SLIP_COUNT] += sums[4] * dt
