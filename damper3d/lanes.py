"""Rows of four numbers to lanes and back: where the processor's vectors are spelt out.

A contact needs six rows (position, velocity and spin of two spheres) and adds to four (their forces
and torques), while the passes over contacts want one array a quantity. A compiler makes of that
some forty scattered loads, insertions and stores a contact, which take half of the time of a step.
Here four contacts are worked at once: rows are loaded whole and transposed in registers. What is
left over at the end of a block, fewer than four contacts, is done one by one, in the plain form.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from contact.jit import inlined
from damper3d.state import BLOCK

_ROW = ir.VectorType(ir.DoubleType(), 4)
_NUMBER = ir.IntType(64)


def _lanes(*numbers):
    return ir.Constant(ir.VectorType(ir.IntType(32), len(numbers)), list(numbers))


def _transposed(builder, rows):
    """Four rows of four as four columns."""
    a, b, c, d = rows
    even, odd = _lanes(0, 4, 2, 6), _lanes(1, 5, 3, 7)
    ab0, ab1 = builder.shuffle_vector(a, b, even), builder.shuffle_vector(a, b, odd)
    cd0, cd1 = builder.shuffle_vector(c, d, even), builder.shuffle_vector(c, d, odd)
    low, high = _lanes(0, 1, 4, 5), _lanes(2, 3, 6, 7)
    return [
        builder.shuffle_vector(ab0, cd0, low),
        builder.shuffle_vector(ab1, cd1, low),
        builder.shuffle_vector(ab0, cd0, high),
        builder.shuffle_vector(ab1, cd1, high),
    ]


def _spread(builder, vector, lane):
    """A vector with one lane of another in all of its own."""
    return builder.shuffle_vector(vector, vector, _lanes(*[lane] * 4))


def _at(builder, pointer, number, ahead=0):
    """The four numbers of an array of doubles from number + ahead on, as a pointer to a vector."""
    if ahead:
        number = builder.add(number, ir.Constant(_NUMBER, ahead))
    return builder.bitcast(builder.gep(pointer, [number]), _ROW.as_pointer())


def _load(builder, pointer, number, ahead=0):
    return builder.load(_at(builder, pointer, number, ahead), align=8)


def _rows_of(builder, index, begin, k, lane):
    """Where the row of the sphere that contact begin + k + lane names begins."""
    n = builder.add(builder.add(begin, k), ir.Constant(_NUMBER, lane))
    sphere = builder.zext(builder.load(builder.gep(index, [n])), _NUMBER)
    return builder.shl(sphere, ir.Constant(_NUMBER, 2))


def _data(context, builder, signature, arguments):
    """Pointers to the data of the arrays among the arguments; the numbers as they are."""
    return [
        context.make_array(kind)(context, builder, argument).data
        if isinstance(kind, types.Array)
        else argument
        for kind, argument in zip(signature.args, arguments, strict=True)
    ]


@intrinsic
def _combine_four(typingctx, x, u, w, i, j, separation, passing, turning, spin, begin, k):
    """Contacts begin + k ... + 3: their spheres' rows, combined, to lanes k ... of the block."""
    number = types.int64
    signature = types.void(x, u, w, i, j, separation, passing, turning, spin, number, number)

    def generate(context, builder, signature, arguments):
        x, u, w, i, j, *columns, begin, k = _data(context, builder, signature, arguments)
        combined = [[] for _ in columns]
        for lane in range(4):
            at_i = _rows_of(builder, i, begin, k, lane)
            at_j = _rows_of(builder, j, begin, k, lane)
            xi, xj = _load(builder, x, at_i), _load(builder, x, at_j)
            wi, wj = _load(builder, w, at_i), _load(builder, w, at_j)
            turning_i = builder.fmul(_spread(builder, xi, 3), wi)
            turning_j = builder.fmul(_spread(builder, xj, 3), wj)
            combined[0].append(builder.fsub(xj, xi))
            combined[1].append(builder.fsub(_load(builder, u, at_j), _load(builder, u, at_i)))
            combined[2].append(builder.fadd(turning_i, turning_j))
            combined[3].append(builder.fadd(wi, wj))
        for rows, out in zip(combined, columns, strict=True):
            for c, column in enumerate(_transposed(builder, rows)[:3]):
                builder.store(column, _at(builder, out, k, c * BLOCK), align=8)
        return context.get_dummy_value()

    return signature, generate


@inlined
def combine(spheres, contacts, begin, n_contacts, block):
    """What contacts begin ... begin + n_contacts - 1 need of their spheres i and j.

    Fills rows of the block, (3, BLOCK): separation x_j - x_i [m], passing u_j - u_i [m/s], turning
    R_i w_i + R_j w_j [m/s] and spin w_i + w_j [rad/s].
    """
    x, u, w = spheres.position, spheres.velocity, spheres.spin
    whole = n_contacts - n_contacts % 4
    for k in range(np.int64(0), whole, 4):
        _combine_four(
            x, u, w, contacts.i, contacts.j, block.separation, block.passing, block.turning,
            block.spin, begin, k,
        )  # fmt: skip
    for k in range(whole, n_contacts):
        i, j = contacts.i[begin + k], contacts.j[begin + k]
        for c in range(3):
            block.separation[c, k] = x[j, c] - x[i, c]
            block.passing[c, k] = u[j, c] - u[i, c]
            block.turning[c, k] = x[i, 3] * w[i, c] + x[j, 3] * w[j, c]
            block.spin[c, k] = w[i, c] + w[j, c]


@intrinsic
def _add_four(typingctx, force, torque, i, j, push, couple, arm_i, arm_j, begin, k):
    """Contacts begin + k ... + 3, one after the other: their loads to their spheres."""
    number = types.int64
    signature = types.void(force, torque, i, j, push, couple, arm_i, arm_j, number, number)

    def generate(context, builder, signature, arguments):
        force, torque, i, j, push, couple, arm_i, arm_j, begin, k = _data(
            context, builder, signature, arguments
        )
        nothing = ir.Constant(_ROW, [0.0] * 4)

        def rows(columns):
            lanes = [_load(builder, columns, k, c * BLOCK) for c in range(3)]
            return _transposed(builder, [*lanes, nothing])

        pushes, couples = rows(push), rows(couple)
        arms_i, arms_j = _load(builder, arm_i, k), _load(builder, arm_j, k)
        for lane in range(4):
            at_i = _rows_of(builder, i, begin, k, lane)
            at_j = _rows_of(builder, j, begin, k, lane)
            turn_i = builder.fmul(_spread(builder, arms_i, lane), couples[lane])
            turn_j = builder.fmul(_spread(builder, arms_j, lane), couples[lane])
            for array, at, change, add in (
                (force, at_i, pushes[lane], builder.fsub),
                (force, at_j, pushes[lane], builder.fadd),
                (torque, at_i, turn_i, builder.fsub),
                (torque, at_j, turn_j, builder.fsub),
            ):
                place = _at(builder, array, at)
                builder.store(add(builder.load(place, align=8), change), place, align=8)
        return context.get_dummy_value()

    return signature, generate


@inlined
def add_loads(spheres, contacts, begin, n_contacts, block):
    """Add the forces of a block, and their torques about the centres, to its spheres i and j.

    In the order of the list. The force push acts on j and its opposite on i, at the distances arm_i
    and arm_j from the centres; couple is normal x push.
    """
    force, torque = spheres.force, spheres.torque
    whole = n_contacts - n_contacts % 4
    for k in range(np.int64(0), whole, 4):
        touching = block.overlap[k] + block.overlap[k + 1] + block.overlap[k + 2]
        if touching + block.overlap[k + 3] > 0.0:
            _add_four(
                force, torque, contacts.i, contacts.j, block.push, block.couple, block.arm_i,
                block.arm_j, begin, k,
            )  # fmt: skip
    for k in range(whole, n_contacts):
        i, j = contacts.i[begin + k], contacts.j[begin + k]
        for c in range(3):
            force[i, c] -= block.push[c, k]
            force[j, c] += block.push[c, k]
            torque[i, c] -= block.arm_i[k] * block.couple[c, k]
            torque[j, c] -= block.arm_j[k] * block.couple[c, k]
