"""Rows of four numbers to lanes and back: where the processor's vectors are spelt out.

A contact needs nine rows (position, velocity and spin of two spheres, its own constants and its
history) and adds to four (forces and torques), while the passes over contacts want one array a
quantity. A compiler makes of that some forty scattered loads, insertions and stores a contact,
which take half of the time of a step. Here four contacts are worked at once: rows are loaded whole
and transposed in registers. What is left over at the end of a block, fewer than four contacts, is
done one by one, in the plain form.
"""

import numpy as np
from numba import types
from numba.extending import intrinsic

from damper3d.engine.rows import (
    NOTHING,
    begin_of,
    data,
    load,
    named,
    spread,
    store,
    store_columns,
    transposed,
)  # fmt: skip
from damper3d.engine.state import BLOCK, LANES, N_CONSTANTS, N_HISTORY
from granulab.contact.jit import inlined


@inlined
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
        store_columns(builder, rows, separation, k, range(3))
        return context.get_dummy_value()

    return signature, generate


@inlined
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
    typingctx, x, u, w, i, j, constants, history, touching, separation, passing, turning, spin,
    own, known, begin, k,
):  # fmt: skip
    """What the contacts that entries begin + k ... + 3 name need, to lanes k ... of the block."""
    number = types.int64
    signature = types.void(
        x, u, w, i, j, constants, history, touching, separation, passing, turning, spin, own,
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
            store_columns(builder, rows, out, k, range(3))
        rows = [load(builder, constants, begin_of(builder, n)) for n in numbers]
        store_columns(builder, rows, own, k, range(N_CONSTANTS))
        for half in range(0, N_HISTORY, 4):
            rows = [load(builder, history, begin_of(builder, n, 2), half) for n in numbers]
            store_columns(builder, rows, known, k, range(half, half + 4))
        return context.get_dummy_value()

    return signature, generate


@inlined
def gather(spheres, contacts, begin, n_contacts, block):
    """What the contacts need that entries begin ... begin + n_contacts - 1 of `touching` name.

    Fills rows of the block: separation x_j - x_i [m], passing u_j - u_i [m/s], turning
    R_i w_i + R_j w_j [m/s] and spin w_i + w_j [rad/s], constants and history of the contacts.
    """
    x, u, w = spheres.position, spheres.velocity, spheres.spin
    fours = n_contacts - n_contacts % 4
    for k in range(np.int64(0), fours, 4):
        _gather_four(
            x, u, w, contacts.i, contacts.j, contacts.constants, contacts.history,
            contacts.touching, block.separation, block.passing, block.turning, block.spin,
            block.constants, block.history, begin, k,
        )  # fmt: skip
    for k in range(fours, n_contacts):
        n = contacts.touching[begin + k]
        i, j = contacts.i[n], contacts.j[n]
        for c in range(3):
            block.separation[c * BLOCK + k] = x[j, c] - x[i, c]
            block.passing[c * BLOCK + k] = u[j, c] - u[i, c]
            block.turning[c * BLOCK + k] = x[i, 3] * w[i, c] + x[j, 3] * w[j, c]
            block.spin[c * BLOCK + k] = w[i, c] + w[j, c]
        for c in range(N_CONSTANTS):
            block.constants[c * BLOCK + k] = contacts.constants[n, c]
        for h in range(N_HISTORY):
            block.history[h * BLOCK + k] = contacts.history[n, h]


@intrinsic
def _keep_four(typingctx, history, touching, later, begin, k):
    """Histories in lanes k ... of the block to the contacts that entries begin + k ... + 3 name."""
    number = types.int64
    signature = types.void(history, touching, later, number, number)

    def generate(context, builder, signature, arguments):
        history, touching, later, begin, k = data(context, builder, signature, arguments)
        first = builder.add(begin, k)
        numbers = [named(builder, touching, first, lane) for lane in range(4)]
        for half in range(0, N_HISTORY, 4):
            columns = [load(builder, later, k, (half + c) * BLOCK) for c in range(4)]
            for n, row in zip(numbers, transposed(builder, columns), strict=True):
                store(builder, row, history, begin_of(builder, n, 2), half)
        return context.get_dummy_value()

    return signature, generate


@inlined
def keep_history(contacts, begin, n_contacts, block):
    """Let the histories after this step be those of the contacts."""
    fours = n_contacts - n_contacts % 4
    for k in range(np.int64(0), fours, 4):
        _keep_four(contacts.history, contacts.touching, block.later, begin, k)
    for k in range(fours, n_contacts):
        for h in range(N_HISTORY):
            contacts.history[contacts.touching[begin + k], h] = block.later[h * BLOCK + k]


@intrinsic
def _add_four(typingctx, force, torque, i, j, touching, push, couple, arm_i, arm_j, begin, k):
    """Loads of contacts k ... k + 3 of the block, one after the other, to their spheres."""
    number = types.int64
    signature = types.void(
        force, torque, i, j, touching, push, couple, arm_i, arm_j, number, number
    )

    def generate(context, builder, signature, arguments):
        force, torque, i, j, touching, push, couple, arm_i, arm_j, begin, k = data(
            context, builder, signature, arguments
        )
        first = builder.add(begin, k)

        def rows_of(columns):
            lanes = [load(builder, columns, k, c * BLOCK) for c in range(3)]
            return transposed(builder, [*lanes, NOTHING])

        pushes, couples = rows_of(push), rows_of(couple)
        arms_i, arms_j = load(builder, arm_i, k), load(builder, arm_j, k)
        for lane in range(4):
            n = named(builder, touching, first, lane)
            at_i = begin_of(builder, named(builder, i, n, 0))
            at_j = begin_of(builder, named(builder, j, n, 0))
            turn_i = builder.fmul(spread(builder, arms_i, lane), couples[lane])
            turn_j = builder.fmul(spread(builder, arms_j, lane), couples[lane])
            for array, begin_at, change, add in (
                (force, at_i, pushes[lane], builder.fsub),
                (force, at_j, pushes[lane], builder.fadd),
                (torque, at_i, turn_i, builder.fsub),
                (torque, at_j, turn_j, builder.fsub),
            ):
                store(builder, add(load(builder, array, begin_at), change), array, begin_at)
        return context.get_dummy_value()

    return signature, generate


@inlined
def add_loads(spheres, contacts, begin, n_contacts, block):
    """Add the forces of a block, and their torques about the centres, to its spheres i and j.

    In the order of the list. The force push acts on j and its opposite on i, at the distances arm_i
    and arm_j from the centres; couple is normal x push.
    """
    force, torque = spheres.force, spheres.torque
    fours = n_contacts - n_contacts % 4
    for k in range(np.int64(0), fours, 4):
        _add_four(
            force, torque, contacts.i, contacts.j, contacts.touching, block.push, block.couple,
            block.arm_i, block.arm_j, begin, k,
        )  # fmt: skip
    for k in range(fours, n_contacts):
        n = contacts.touching[begin + k]
        i, j = contacts.i[n], contacts.j[n]
        for c in range(3):
            force[i, c] -= block.push[c * BLOCK + k]
            force[j, c] += block.push[c * BLOCK + k]
            torque[i, c] -= block.arm_i[k] * block.couple[c * BLOCK + k]
            torque[j, c] -= block.arm_j[k] * block.couple[c * BLOCK + k]
