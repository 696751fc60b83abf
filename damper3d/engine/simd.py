"""The processor's vectors, spelt out where a compiler does not find them: rows of four numbers.

A contact needs nine rows (position, velocity and rotation of two spheres, its own constants and its
history) and adds to four (forces and torques), while the passes over contacts want one array a
quantity. A compiler makes of that some forty scattered loads, insertions and stores a contact,
which take half of the time of a step. Here four contacts are worked at once: rows are loaded whole
and transposed in registers. What is left over at the end of a block, fewer than four contacts, is
done one by one, in the plain form.
In order, of instructions on rows (granulab/contact/compiled/rows.py): rows of contacts to lanes and
back; from a particle to its spheres and back; a step of a sphere, where a compiler would take all
rows number by number, as three numbers of one are summed for the lists. A sphere at r from the
centroid of its particle is at x + r and has the velocity u + w x r; the force f and torque t on it
give f and t + r x f to the particle. The plain forms that these equal to the last bit stand in
tests/damper3d/test_damper_engine_simd.py.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from damper3d.engine.state import BLOCK, LANES, N_CONSTANTS, N_HISTORY
from granulab.contact.compiled.rows import (
    NOTHING,
    begin_of,
    data,
    filled,
    load,
    named,
    row_of,
    spread,
    spread_to_three,
    store,
    store_columns,
    transposed,
)
from granulab.contact.jit import inlined_inner


def square(builder, row):
    """The sum of the squares of the first three numbers of a row."""
    x, y, z = (builder.extract_element(row, ir.Constant(ir.IntType(32), c)) for c in range(3))
    xx, yy, zz = (builder.fmul(number, number) for number in (x, y, z))
    return builder.fadd(builder.fadd(xx, yy), zz)


@inlined_inner
def whole(n_contacts):
    """So many lanes as the contacts fill, and then to the end of the processor's vector.

    What stands in the lanes beyond the contacts is of no meaning, and nobody reads the results.
    """
    return (n_contacts + LANES - 1) // LANES * LANES


@intrinsic
def _separate_four(typingctx, x, i, j, separation, begin, k):
    """x_j - x_i of contacts begin + k ... + 3 to lanes k ... of the block."""
    number = types.int64
    signature = types.void(x, i, j, separation, number, number)

    def generate(context, builder, signature, arguments):
        x, i, j, separation, begin, k = data(context, builder, signature, arguments)
        first = builder.add(begin, k)
        rows = []
        for lane in range(4):
            at_i = begin_of(builder, named(builder, i, first, lane))
            at_j = begin_of(builder, named(builder, j, first, lane))
            rows.append(builder.fsub(load(builder, x, at_j), load(builder, x, at_i)))
        store_columns(builder, rows, separation, k, range(3), BLOCK)
        return context.get_dummy_value()

    return signature, generate


@inlined_inner
def separate(spheres, contacts, begin, n_contacts, block):
    """Separations x_j - x_i [m] of contacts begin ... begin + n_contacts - 1, into the block."""
    x = spheres.position
    fours = n_contacts - n_contacts % 4
    for k in range(np.int64(0), fours, 4):
        _separate_four(x, contacts.i, contacts.j, block.separation, begin, k)
    for k in range(fours, n_contacts):
        i, j = contacts.i[begin + k], contacts.j[begin + k]
        for c in range(3):
            block.separation[c * BLOCK + k] = x[j, c] - x[i, c]


@intrinsic
def _gather_four(
    typingctx, x, u, w, i, j, constants, history, touching, separation, passing, rim, rotation,
    own, known, begin, k,
):  # fmt: skip
    """Load rows of the contacts that entries begin + k ... + 3 name to lanes k ... of the block."""
    number = types.int64
    signature = types.void(
        x, u, w, i, j, constants, history, touching, separation, passing, rim, rotation, own,
        known, number, number,
    )  # fmt: skip

    def generate(context, builder, signature, arguments):
        x, u, w, i, j, constants, history, touching, *columns, own, known, begin, k = data(
            context, builder, signature, arguments
        )
        first = builder.add(begin, k)
        combined = [[] for _ in columns]
        numbers = [named(builder, touching, first, lane) for lane in range(4)]
        for n in numbers:
            at_i = begin_of(builder, named(builder, i, n, 0))
            at_j = begin_of(builder, named(builder, j, n, 0))
            xi, xj = load(builder, x, at_i), load(builder, x, at_j)
            wi, wj = load(builder, w, at_i), load(builder, w, at_j)
            turning_i = builder.fmul(spread(builder, xi, 3), wi)
            turning_j = builder.fmul(spread(builder, xj, 3), wj)
            combined[0].append(builder.fsub(xj, xi))
            combined[1].append(builder.fsub(load(builder, u, at_j), load(builder, u, at_i)))
            combined[2].append(builder.fadd(turning_i, turning_j))
            combined[3].append(builder.fadd(wi, wj))
        for rows, out in zip(combined, columns, strict=True):
            store_columns(builder, rows, out, k, range(3), BLOCK)
        rows = [load(builder, constants, begin_of(builder, n)) for n in numbers]
        store_columns(builder, rows, own, k, range(N_CONSTANTS), BLOCK)
        for half in range(0, N_HISTORY, 4):
            rows = [load(builder, history, begin_of(builder, n, 2), half) for n in numbers]
            store_columns(builder, rows, known, k, range(half, half + 4), BLOCK)
        return context.get_dummy_value()

    return signature, generate


@inlined_inner
def gather(spheres, contacts, begin, n_contacts, block):
    """Load rows of the contacts that entries begin ... begin + n_contacts - 1 of `touching` name.

    Fills rows of the block: separation x_j - x_i [m], relative velocity u_j - u_i [m/s], rim
    velocity R_i w_i + R_j w_j [m/s], angular velocity w_i + w_j [rad/s], constants and history.
    """
    x, u, w = spheres.position, spheres.velocity, spheres.angular_velocity
    fours = n_contacts - n_contacts % 4
    for k in range(np.int64(0), fours, 4):
        _gather_four(
            x, u, w, contacts.i, contacts.j, contacts.constants, contacts.history,
            contacts.touching, block.separation, block.relative_velocity, block.rim_velocity,
            block.angular_velocity, block.constants, block.history, begin, k,
        )  # fmt: skip
    for k in range(fours, n_contacts):
        n = contacts.touching[begin + k]
        i, j = contacts.i[n], contacts.j[n]
        for c in range(3):
            block.separation[c * BLOCK + k] = x[j, c] - x[i, c]
            block.relative_velocity[c * BLOCK + k] = u[j, c] - u[i, c]
            block.rim_velocity[c * BLOCK + k] = x[i, 3] * w[i, c] + x[j, 3] * w[j, c]
            block.angular_velocity[c * BLOCK + k] = w[i, c] + w[j, c]
        for c in range(N_CONSTANTS):
            block.constants[c * BLOCK + k] = contacts.constants[n, c]
        for h in range(N_HISTORY):
            block.history[h * BLOCK + k] = contacts.history[n, h]


@intrinsic
def _keep_four(typingctx, history, touching, next_history, begin, k):
    """Histories in lanes k ... of the block to the contacts that entries begin + k ... + 3 name."""
    number = types.int64
    signature = types.void(history, touching, next_history, number, number)

    def generate(context, builder, signature, arguments):
        history, touching, next_history, begin, k = data(context, builder, signature, arguments)
        first = builder.add(begin, k)
        numbers = [named(builder, touching, first, lane) for lane in range(4)]
        for half in range(0, N_HISTORY, 4):
            columns = [load(builder, next_history, k, (half + c) * BLOCK) for c in range(4)]
            for n, row in zip(numbers, transposed(builder, columns), strict=True):
                store(builder, row, history, begin_of(builder, n, 2), half)
        return context.get_dummy_value()

    return signature, generate


@inlined_inner
def keep_history(contacts, begin, n_contacts, block):
    """Let the histories after this step be those of the contacts."""
    fours = n_contacts - n_contacts % 4
    for k in range(np.int64(0), fours, 4):
        _keep_four(contacts.history, contacts.touching, block.next_history, begin, k)
    for k in range(fours, n_contacts):
        for h in range(N_HISTORY):
            contacts.history[contacts.touching[begin + k], h] = block.next_history[h * BLOCK + k]


@intrinsic
def _add_four(
    typingctx, force, torque, i, j, touching, push, couple, lost, arm_i, arm_j, begin, k,
):  # fmt: skip
    """Loads of contacts k ... k + 3 of the block, one after the other, to their spheres."""
    number = types.int64
    signature = types.void(
        force, torque, i, j, touching, push, couple, lost, arm_i, arm_j, number, number
    )

    def generate(context, builder, signature, arguments):
        force, torque, i, j, touching, push, couple, lost, arm_i, arm_j, begin, k = data(
            context, builder, signature, arguments
        )
        first = builder.add(begin, k)

        def rows_of(columns, fourth):
            lanes = [load(builder, columns, k, c * BLOCK) for c in range(3)]
            return transposed(builder, [*lanes, fourth])

        pushes, couples = rows_of(push, NOTHING), rows_of(couple, load(builder, lost, k))
        arms_i, arms_j = load(builder, arm_i, k), load(builder, arm_j, k)
        for lane in range(4):
            n = named(builder, touching, first, lane)
            at_i = begin_of(builder, named(builder, i, n, 0))
            at_j = begin_of(builder, named(builder, j, n, 0))
            turn_i = builder.fmul(spread_to_three(builder, arms_i, lane), couples[lane])
            turn_j = builder.fmul(spread_to_three(builder, arms_j, lane), couples[lane])
            for array, begin_at, change, add in (
                (force, at_i, pushes[lane], builder.fsub),
                (force, at_j, pushes[lane], builder.fadd),
                (torque, at_i, turn_i, builder.fsub),
                (torque, at_j, turn_j, builder.fsub),
            ):
                store(builder, add(load(builder, array, begin_at), change), array, begin_at)
        return context.get_dummy_value()

    return signature, generate


@inlined_inner
def add_loads(spheres, to_i, to_j, touching, begin, n_contacts, block, sums):
    """Add the forces of a block, and their torques about the centres, to rows to_i and to_j.

    Those of its spheres i and j, or where several threads share a step some that nobody reads. In
    the order of the list. The force push acts on j and its opposite on i, at the distances arm_i
    and arm_j from the centres; couple is normal x push. What each dissipates is taken off the
    fourth number of its torque.
    Returns what the contacts dissipate by mechanism, sums (5,) in the order of the list which go on
    with those before: here they take no time, while the processor waits for rows.
    """
    force, torque = spheres.force, spheres.torque
    normal, tangential, friction_work, stiffness_work, slipped = sums
    fours = n_contacts - n_contacts % 4
    for k in range(np.int64(0), fours, 4):
        _add_four(
            force, torque, to_i, to_j, touching, block.push, block.couple, block.lost,
            block.arm_i, block.arm_j, begin, k,
        )  # fmt: skip
        for m in range(np.uintp(k), np.uintp(k + 4)):
            normal += block.normal_power[m]
            tangential += block.tangential_power[m]
            friction_work += block.friction_work[m]
            stiffness_work += block.stiffness_work[m]
            slipped += block.slip_power[m]
    for k in range(fours, n_contacts):
        n = touching[begin + k]
        i, j = to_i[n], to_j[n]
        for c in range(3):
            force[i, c] -= block.push[c * BLOCK + k]
            force[j, c] += block.push[c * BLOCK + k]
            torque[i, c] -= block.arm_i[k] * block.couple[c * BLOCK + k]
            torque[j, c] -= block.arm_j[k] * block.couple[c * BLOCK + k]
        torque[i, 3] -= block.lost[k]
        torque[j, 3] -= block.lost[k]
        normal += block.normal_power[k]
        tangential += block.tangential_power[k]
        friction_work += block.friction_work[k]
        stiffness_work += block.stiffness_work[k]
        slipped += block.slip_power[k]
    return normal, tangential, friction_work, stiffness_work, slipped


_LAST = ir.Constant(ir.IntType(32), 3)
_NEXT, _AFTER = (ir.Constant(ir.VectorType(ir.IntType(32), 4), lanes)
                 for lanes in ([1, 2, 0, 3], [2, 0, 1, 3]))  # fmt: skip


def _cross(builder, a, b):
    """a x b of the first three numbers of two rows."""
    turned = [
        builder.shuffle_vector(row, row, lanes) for row in (a, b) for lanes in (_NEXT, _AFTER)
    ]
    ahead = builder.fmul(turned[0], turned[3])
    return builder.fsub(ahead, builder.fmul(turned[1], turned[2]))


@intrinsic
def place_sphere(
    typingctx, x, u, w, axes, offset, position, velocity, spin, b, s, i,
):  # fmt: skip
    """Let row i of position, velocity and angular velocity be those of sphere s of particle b."""
    signature = types.void(x, u, w, axes, offset, position, velocity, spin, b, s, i)

    def generate(context, builder, signature, arguments):
        x, u, w, axes, offset, position, velocity, spin, b, s, i = data(
            context, builder, signature, arguments
        )
        at_b, at_i, at_axes = begin_of(builder, b), begin_of(builder, i), begin_of(builder, b, 3)
        own = load(builder, offset, begin_of(builder, s))
        parts = [
            builder.fmul(spread(builder, own, c), load(builder, axes, at_axes, 4 * c))
            for c in range(3)
        ]
        arm = builder.fadd(builder.fadd(parts[0], parts[1]), parts[2])
        place = builder.fadd(load(builder, x, at_b), arm)
        radius = builder.extract_element(own, _LAST)
        store(builder, builder.insert_element(place, radius, _LAST), position, at_i)
        rotation = load(builder, w, at_b)
        swing = _cross(builder, rotation, arm)
        store(builder, builder.fadd(load(builder, u, at_b), swing), velocity, at_i)
        store(builder, rotation, spin, at_i)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def take_load(typingctx, force, torque, position, x, total, torques, i, b):
    """Add force and torque of sphere i to those of particle b, and wipe them."""
    signature = types.void(force, torque, position, x, total, torques, i, b)

    def generate(context, builder, signature, arguments):
        force, torque, position, x, total, torques, i, b = data(
            context, builder, signature, arguments
        )
        at_b, at_i = begin_of(builder, b), begin_of(builder, i)
        push = load(builder, force, at_i)
        arm = builder.fsub(load(builder, position, at_i), load(builder, x, at_b))
        turn = builder.fadd(load(builder, torque, at_i), _cross(builder, arm, push))
        store(builder, builder.fadd(load(builder, total, at_b), push), total, at_b)
        store(builder, builder.fadd(load(builder, torques, at_b), turn), torques, at_b)
        store(builder, NOTHING, force, at_i)
        store(builder, NOTHING, torque, at_i)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def kick(typingctx, v, u, loads, factor, gain, i):
    """Row i of v += factor loads + gain; u is half of that further on; the loads are wiped.

    The fourth numbers of v and u stay 0, whatever that of the loads is.
    """
    signature = types.void(v, u, loads, factor, gain, i)

    def generate(context, builder, signature, arguments):
        v, u, loads, factor, gain, i = data(context, builder, signature, arguments)
        begin = begin_of(builder, i)
        factors = row_of(builder, [factor] * 3)
        change = builder.fmul(factors, load(builder, loads, begin))
        change = builder.fadd(change, row_of(builder, _three(builder, gain)))
        moved = builder.fadd(load(builder, v, begin), change)
        half = builder.fmul(filled(builder, ir.Constant(ir.DoubleType(), 0.5)), change)
        store(builder, moved, v, begin)
        store(builder, builder.fadd(moved, half), u, begin)
        store(builder, NOTHING, loads, begin)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def drift_on(typingctx, x, v, dt, i):
    """Row i of x += dt v; the fourth number, a radius, gains the zero that v has there."""
    signature = types.void(x, v, dt, i)

    def generate(context, builder, signature, arguments):
        x, v, dt, i = data(context, builder, signature, arguments)
        begin = begin_of(builder, i)
        change = builder.fmul(filled(builder, dt), load(builder, v, begin))
        store(builder, builder.fadd(load(builder, x, begin), change), x, begin)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def square_off(typingctx, x, other, carried, i):
    """Square of how far x is from another position, but for what carried it, in row i."""
    signature = types.float64(x, other, carried, i)

    def generate(context, builder, signature, arguments):
        x, other, carried, i = data(context, builder, signature, arguments)
        begin = begin_of(builder, i)
        off = builder.fsub(load(builder, x, begin), load(builder, other, begin))
        return square(builder, builder.fsub(off, row_of(builder, _three(builder, carried))))

    return signature, generate


def _three(builder, numbers):
    return [builder.extract_value(numbers, c) for c in range(3)]
