"""Rolling resistance: LAMMPS's `rolling sds`, a spring, a dashpot and a slider that resist rolling.

With the reduced radius R, the angular velocities w of two spheres and the normal n from the first
to the second, rolling is u = R (w_1 - w_2) x n and its displacement s the sum of u over time:

    f = k s + c u,   |f| <= mu F_n

with the torque -R n x f on the first sphere and its opposite on the second, or on an enclosure that
turns (motions/turning.py).
F_n is what limits friction too. A sliding spring holds what the dashpot leaves of the limit, s =
(f - c u)/k, as LAMMPS has it. It is model C of Ai et al., Powder Technol. 206 (2011) 269, who set
k R^2 = 2.25 kn (mu R)^2; LAMMPS and GranuLab take k as a constant. A sphere rolls down a slope
without end where its tangent is above mu.

In the balance the dashpot is tangential damping, the slider friction, and the spring holds
tangential elastic energy. Of a contact that slides all that the torque takes from the rolling, but
for what the spring gains, is friction; so is what the spring still holds when its contact ends,
-c u/k after sliding. A strong dashpot is capped as its contact begins, which loads the spring at
once: friction then gives what the dashpot takes later. All are works of the mean force of both ends
of a step: that of the dashpot is (c u_0 + c u_1)/2 S = c S^2/dt, with the way S = (u_0 + u_1) dt/2.
"""

import numpy as np
from numba import types

from damper3d.engine.geometry import entry, vector
from damper3d.engine.laws.table import (
    LOAD,
    ROLLING_DAMPING,
    ROLLING_FRICTION,
    ROLLING_STIFFNESS,
    SCALED_RADIUS,
)
from damper3d.engine.motions.turning import wall_spin
from damper3d.engine.state import FRICTION, SLIP_COUNT, TANGENTIAL_DAMPING
from granulab.contact.jit import inlined, inlined_inner, inner, specialised
from granulab.contact.vectors import add, cross, dot, norm, scale


def roll(world, law, contacts, begin, n_contacts):
    """Add the torques of a block that resist rolling, and what they dissipate."""


def rolling_energy(world, law, contacts, begin, k):
    """Energy that the spring of contact k of a block holds now [J]."""


@inlined
def roll_force(stiffness, damping, limit, trial, rate):
    """Force f [N], displacement after slip s [m] and whether it slides, from s without slip."""
    wanted = add(scale(stiffness, trial), scale(damping, rate))
    size = norm(wanted)
    if not size > limit:
        return wanted, trial, 0.0
    force = scale(limit / size, wanted)
    held = scale(1.0 / stiffness, add(force, scale(-damping, rate)))
    return force, held, 1.0


@inlined_inner
def _rolled(world, law, contacts, begin, k, spin):
    """Of contact k: force, s before, s without slip, s after, u, half a step's way, sliding.

    spin: that of a wall that turns about z [rad/s], which its row does not have.
    """
    block = world.block
    n = contacts.touching[np.uintp(begin) + k]
    i, j, row, normal = contacts.i[n], contacts.j[n], contacts.rolling, vector(block.normal, k)
    w, lanes = world.spheres.angular_velocity, law.lanes
    relative = w[i, 0] - w[j, 0], w[i, 1] - w[j, 1], w[i, 2] - w[j, 2] - spin
    rate = scale(lanes[entry(SCALED_RADIUS, k)], cross(relative, normal))
    before = _across((row[n, 0], row[n, 1], row[n, 2]), normal)
    ahead = _across((row[n, 3], row[n, 4], row[n, 5]), normal)
    moved = scale(0.5 * world.time_step, rate)
    trial = add(before, add(ahead, moved))
    limit = lanes[entry(ROLLING_FRICTION, k)] * lanes[entry(LOAD, k)]
    force, held, slides = roll_force(
        lanes[entry(ROLLING_STIFFNESS, k)], lanes[entry(ROLLING_DAMPING, k)], limit, trial, rate
    )
    return force, before, trial, held, rate, moved, slides


@inlined_inner
def _across(a, normal):
    return add(a, scale(-dot(a, normal), normal))


@specialised(roll)
def _roll(world, law, contacts, begin, n_contacts):
    if nothing_rolls(contacts):
        return lambda world, law, contacts, begin, n_contacts: None
    return lambda world, law, contacts, begin, n_contacts: _roll_block(
        world, law, contacts, begin, n_contacts
    )


def nothing_rolls(contacts):
    """Return whether contacts of a type have no rolling resistance."""
    return isinstance(contacts[contacts.fields.index("rolling")], types.NoneType)


@inner
def _roll_block(world, law, contacts, begin, n_contacts):
    block, dt, spin = world.block, world.time_step, wall_spin(world)
    totals, rows, torque = block.own_totals, contacts.rolling, world.spheres.torque
    for k in range(np.uintp(n_contacts)):
        n = contacts.touching[np.uintp(begin) + k]
        i, j = contacts.i[n], contacts.j[n]
        force, before, trial, held, rate, moved, slides = _rolled(
            world, law, contacts, begin, k, spin
        )
        stiffness = law.lanes[entry(ROLLING_STIFFNESS, k)]
        damping, way = law.lanes[entry(ROLLING_DAMPING, k)] / dt, add(trial, scale(-1.0, before))
        if not block.overlap[k] > 0.0:  # it ends, or did before and holds nothing
            drag = damping * dot(add(way, scale(-1.0, moved)), way)
            work = 0.5 * stiffness * dot(before, trial) + drag
            torque[i, 3] -= 0.5 * work
            torque[j, 3] -= 0.5 * work
            totals[FRICTION] += work
            for c in range(rows.shape[1]):
                rows[n, c] = 0.0
            continue
        drag = damping * dot(way, way)
        slip = add(trial, scale(-1.0, held))
        work = 0.5 * stiffness * dot(add(before, held), slip) + slides * drag
        drag *= 1.0 - slides
        turn = scale(law.lanes[entry(SCALED_RADIUS, k)], cross(vector(block.normal, k), force))
        for c in range(3):
            rows[n, c], rows[n, 3 + c] = held[c], moved[c]
            torque[i, c] -= turn[c]
            torque[j, c] += turn[c]
        lost = 0.5 * (drag + work)
        torque[i, 3] -= lost
        torque[j, 3] -= lost
        totals[TANGENTIAL_DAMPING] += drag / dt
        totals[FRICTION] += work
        totals[SLIP_COUNT] += slides * dot(force, rate)


@specialised(rolling_energy)
def _rolling_energy(world, law, contacts, begin, k):
    if nothing_rolls(contacts):
        return lambda world, law, contacts, begin, k: 0.0
    return lambda world, law, contacts, begin, k: _spring_energy(world, law, contacts, begin, k)


@inner
def _spring_energy(world, law, contacts, begin, k):
    held = _rolled(world, law, contacts, begin, k, wall_spin(world))[3]
    return 0.5 * law.lanes[entry(ROLLING_STIFFNESS, k)] * dot(held, held)


def copy_rolled(to, a, rows, b):
    """Let row a of an array be row b of another; nothing where nothing rolls."""


def wipe_rolled(rows, first, last):
    """Let rows first ... last - 1 be zero; nothing where nothing rolls."""


@specialised(copy_rolled)
def _copy_rolled(to, a, rows, b):
    if isinstance(to, types.NoneType):
        return lambda to, a, rows, b: None
    return lambda to, a, rows, b: _copy_row(to, a, rows, b)


@inner
def _copy_row(to, a, rows, b):
    for c in range(rows.shape[1]):
        to[a, c] = rows[b, c]


@specialised(wipe_rolled)
def _wipe_rolled(rows, first, last):
    if isinstance(rows, types.NoneType):
        return lambda rows, first, last: None
    return lambda rows, first, last: _wipe_rows(rows, first, last)


@inner
def _wipe_rows(rows, first, last):
    for k in range(first, last):
        for c in range(rows.shape[1]):
            rows[k, c] = 0.0
