"""From a body to its spheres and back, row by row: the processor's vectors, as in engine.rows.

A sphere at r from the centroid of its body is at x + r and has the velocity u + w x r; the force f
and torque t on it give f and t + r x f to the body.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from damper3d.engine.rows import NOTHING, begin_of, data, load, spread, store

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
    """Let row i of position, velocity and spin be those of sphere s of body b."""
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
        turning = load(builder, w, at_b)
        swing = _cross(builder, turning, arm)
        store(builder, builder.fadd(load(builder, u, at_b), swing), velocity, at_i)
        store(builder, turning, spin, at_i)
        return context.get_dummy_value()

    return signature, generate


@intrinsic
def take_load(typingctx, force, torque, position, x, total, turning, i, b):
    """Add force and torque of sphere i to the total and the turning of body b, and wipe them."""
    signature = types.void(force, torque, position, x, total, turning, i, b)

    def generate(context, builder, signature, arguments):
        force, torque, position, x, total, turning, i, b = data(
            context, builder, signature, arguments
        )
        at_b, at_i = begin_of(builder, b), begin_of(builder, i)
        push = load(builder, force, at_i)
        arm = builder.fsub(load(builder, position, at_i), load(builder, x, at_b))
        turn = builder.fadd(load(builder, torque, at_i), _cross(builder, arm, push))
        store(builder, builder.fadd(load(builder, total, at_b), push), total, at_b)
        store(builder, builder.fadd(load(builder, turning, at_b), turn), turning, at_b)
        store(builder, NOTHING, force, at_i)
        store(builder, NOTHING, torque, at_i)
        return context.get_dummy_value()

    return signature, generate
