"""Assembly: the forces of all contacts, added to spheres and walls, and what they dissipate.

Three passes over a block of contacts: where they touch (geometry.py), what the law says, and
adding it up. The first two have no branch and are vectorised; a contact that does not touch has
overlap 0, which makes its forces exact zeros, so that no bit depends on when a list was made. The
third goes in the order of the list, which is that of the sphere numbers.

The displacement of a contact over a step is the mean of its velocities at both ends times the
step, so that no velocity need be gathered twice.
"""

import numpy as np

from contact.hertz import damping_of_impact, hertz_force, mindlin_force
from contact.jit import njit
from contact.spring_books import spring_books
from contact.vectors import add, dot, scale
from damper3d.geometry import between_spheres, with_cylinder, with_planes
from damper3d.state import (
    BLOCK,
    CLOSE,
    DAMPING,
    FRICTION,
    LAW_TERM,
    MOVED_X,
    MOVED_Y,
    MOVED_Z,
    N_HISTORY,
    N_MECHANISMS,
    NO_CONTACT,
    NORMAL_DAMPING,
    PLANE,
    SLIP_COUNT,
    SPRING_X,
    SPRING_Y,
    SPRING_Z,
    STIFFNESS,
    TANGENTIAL_DAMPING,
    WALL,
    WALL_WORK,
)


@njit
def apply_forces(world, shift, speed):
    """All contact forces of this step and the books; shift and speed are the enclosure's.

    The books are summed over all blocks of a class in the order of the list.
    """
    n_close, n_planes, n_wall = world.counts[CLOSE], world.counts[PLANE], world.counts[WALL]
    block, dt, pushed = world.block, world.time_step, world.walls.push
    nothing = 0.0, 0.0, 0.0, 0.0, 0.0
    first = np.int64(0)  # a typed number: numba would compile the passes once more for a literal
    sums = nothing
    for begin in range(first, n_close, BLOCK):
        n = min(n_close - begin, BLOCK)
        between_spheres(world.spheres, world.close, begin, n, block)
        contact_law(world.pair_law, world.close, begin, n, block, dt)
        keep_history(world.close, begin, n, block)
        sums = add_to_spheres(
            world.spheres, world.bodies.heat, world.close, begin, n, block, dt, sums
        )
        begin_contacts(world.pair_law, world.close, begin, n, block, world.fastest, 0)
    keep_books(world.books, 0, sums, dt)
    sums = nothing
    for begin in range(first, n_planes, BLOCK):
        n = min(n_planes - begin, BLOCK)
        with_planes(world.spheres, world.walls.planes, world.wall, begin, n, shift, speed, block)
        contact_law(world.wall_law, world.wall, begin, n, block, dt)
        keep_history(world.wall, begin, n, block)
        sums = add_to_walls(
            world.spheres, world.bodies.heat, pushed, world.wall, begin, n, block, dt, sums
        )
        begin_contacts(world.wall_law, world.wall, begin, n, block, world.fastest, 1)
    for begin in range(n_planes, n_wall, BLOCK):
        n = min(n_wall - begin, BLOCK)
        with_cylinder(world.spheres, world.walls.radius, world.wall, begin, n, shift, speed, block)
        contact_law(world.wall_law, world.wall, begin, n, block, dt)
        keep_history(world.wall, begin, n, block)
        sums = add_to_walls(
            world.spheres, world.bodies.heat, pushed, world.wall, begin, n, block, dt, sums
        )
        begin_contacts(world.wall_law, world.wall, begin, n, block, world.fastest, 1)
    keep_books(world.books, N_MECHANISMS, sums, dt)
    for w in range(len(pushed)):
        for c in range(3):
            world.books[WALL_WORK] -= dt * speed[c] * pushed[w, c]
            world.walls.force[w, c] += pushed[w, c]
            pushed[w, c] = 0.0


@njit
def contact_law(law, contacts, begin, n_contacts, block, dt):
    """Forces, histories and dissipation of a block whose geometry is known."""
    history, later = contacts.history, block.history
    for k in range(np.uintp(n_contacts)):
        n = np.uintp(begin) + k
        overlap = block.overlap[k]
        touches = 1.0 if overlap > 0.0 else 0.0
        normal = block.normal_x[k], block.normal_y[k], block.normal_z[k]
        velocity = block.velocity_x[k], block.velocity_y[k], block.velocity_z[k]
        rate = -dot(velocity, normal)
        slip_rate = add(velocity, scale(rate, normal))
        known = history[DAMPING, n]
        damping = max(known, law.damping)
        stiffness, dashpot, f_n, inelastic = hertz_force(
            law, contacts.hertz[n], contacts.mass[n], damping, overlap, rate
        )
        kt, kt_before = law.tangential * stiffness, history[STIFFNESS, n]
        moved = scale(0.5 * dt, slip_rate)
        held_before, trial = without_slip(law, history, n, normal, kt_before, kt, moved)
        force, held, power, slides = mindlin_force(law, stiffness, dashpot, f_n, trial, slip_rate)
        rubbed, gained = spring_books(law, kt_before, kt, held_before, trial, held)

        held, moved = scale(touches, held), scale(touches, moved)
        later[SPRING_X, k], later[SPRING_Y, k], later[SPRING_Z, k] = held
        later[MOVED_X, k], later[MOVED_Y, k], later[MOVED_Z, k] = moved
        later[STIFFNESS, k] = kt
        later[DAMPING, k] = damping if overlap > 0.0 else NO_CONTACT
        block.begins[k] = touches * rate if known < 0.0 else 0.0
        total = add(force, scale(f_n, normal))
        block.force_x[k], block.force_y[k], block.force_z[k] = total
        block.normal_power[k] = inelastic * rate
        block.tangential_power[k] = power
        block.rubbed[k] = touches * rubbed
        block.gained[k] = touches * gained
        block.slip_power[k] = -slides * dot(force, slip_rate)


@njit
def without_slip(law, history, n, normal, kt_before, kt, moved):
    """What the spring of contact n held at the step before, and would hold now if it did not slip.

    Both in the tangent plane of now. The displacement since then is the mean of the velocities of
    then and now times the step: half of it is known from then, the other half is `moved` [m].
    """
    held = history[SPRING_X, n], history[SPRING_Y, n], history[SPRING_Z, n]
    ahead = history[MOVED_X, n], history[MOVED_Y, n], history[MOVED_Z, n]
    held = add(held, scale(-dot(held, normal), normal))
    ahead = add(ahead, scale(-dot(ahead, normal), normal))
    if law.stored_force:
        return held, add(held, add(scale(kt_before, ahead), scale(kt, moved)))
    return held, add(held, add(ahead, moved))


@njit
def keep_history(contacts, begin, n_contacts, block):
    """Let the histories after this step be those of the contacts."""
    for h in range(N_HISTORY):
        for k in range(np.uintp(n_contacts)):
            contacts.history[h, np.uintp(begin) + k] = block.history[h, k]


@njit
def add_to_spheres(spheres, heat, contacts, begin, n_contacts, block, dt, sums):
    """Add the forces of a block of sphere contacts, and what they dissipate, to their spheres.

    Returns the sums of what is dissipated by each mechanism, with those of this block.
    """
    force, torque = spheres.force, spheres.torque
    normal, tangential, rubbed, gained, slipped = sums
    for k in range(np.uintp(n_contacts)):
        n = np.uintp(begin) + k
        if block.overlap[k] > 0.0:
            i, j = contacts.i[n], contacts.j[n]
            fx, fy, fz = block.force_x[k], block.force_y[k], block.force_z[k]
            nx, ny, nz = block.normal_x[k], block.normal_y[k], block.normal_z[k]
            tx, ty, tz = ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx
            arm_i, arm_j = block.arm_i[k], block.arm_j[k]
            force[i, 0] -= fx
            force[i, 1] -= fy
            force[i, 2] -= fz
            force[j, 0] += fx
            force[j, 1] += fy
            force[j, 2] += fz
            torque[i, 0] -= arm_i * tx
            torque[i, 1] -= arm_i * ty
            torque[i, 2] -= arm_i * tz
            torque[j, 0] -= arm_j * tx
            torque[j, 1] -= arm_j * ty
            torque[j, 2] -= arm_j * tz
            lost = (block.normal_power[k] + block.tangential_power[k]) * dt + block.rubbed[k]
            heat[i] += 0.5 * lost
            heat[j] += 0.5 * lost
            normal += block.normal_power[k]
            tangential += block.tangential_power[k]
            rubbed += block.rubbed[k]
            gained += block.gained[k]
            slipped += block.slip_power[k]
    return normal, tangential, rubbed, gained, slipped


@njit
def add_to_walls(spheres, heat, pushed, contacts, begin, n_contacts, block, dt, sums):
    """The same for contacts with walls, which are pushed (n_walls, 4) by the spheres."""
    force, torque = spheres.force, spheres.torque
    normal, tangential, rubbed, gained, slipped = sums
    for k in range(np.uintp(n_contacts)):
        n = np.uintp(begin) + k
        if block.overlap[k] > 0.0:
            i, j = contacts.i[n], contacts.j[n]
            fx, fy, fz = block.force_x[k], block.force_y[k], block.force_z[k]
            nx, ny, nz = block.normal_x[k], block.normal_y[k], block.normal_z[k]
            arm = block.arm_i[k]
            force[i, 0] -= fx
            force[i, 1] -= fy
            force[i, 2] -= fz
            torque[i, 0] -= arm * (ny * fz - nz * fy)
            torque[i, 1] -= arm * (nz * fx - nx * fz)
            torque[i, 2] -= arm * (nx * fy - ny * fx)
            pushed[j, 0] += fx
            pushed[j, 1] += fy
            pushed[j, 2] += fz
            heat[i] += (block.normal_power[k] + block.tangential_power[k]) * dt + block.rubbed[k]
            normal += block.normal_power[k]
            tangential += block.tangential_power[k]
            rubbed += block.rubbed[k]
            gained += block.gained[k]
            slipped += block.slip_power[k]
    return normal, tangential, rubbed, gained, slipped


@njit
def begin_contacts(law, contacts, begin, n_contacts, block, fastest, which):
    """Note the speeds of impacts that begin, and the damping that goes with them."""
    for k in range(np.uintp(n_contacts)):
        speed = block.begins[k]
        if speed > 0.0:
            n = np.uintp(begin) + k
            fastest[which] = max(fastest[which], speed)
            contacts.history[DAMPING, n] = damping_of_impact(
                law, contacts.hertz[n], contacts.mass[n], speed
            )


@njit
def keep_books(books, first, sums, dt):
    """Add what was dissipated in this step to the books of a class."""
    books[first + NORMAL_DAMPING] += sums[0] * dt
    books[first + TANGENTIAL_DAMPING] += sums[1] * dt
    books[first + FRICTION] += sums[2]
    books[first + LAW_TERM] += sums[3]
    books[first + SLIP_COUNT] += sums[4] * dt
