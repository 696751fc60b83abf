"""The processor's vectors, spelt out where a compiler does not find them: forces to rows of bodies.

A pair adds three numbers to the row of each of its bodies, and where it does it number by number a
step waits for itself: the next pair often has the same bodies. Here four pairs are transposed in
registers, and each adds a row of four at once. What is left over at the end of a block, fewer than
four pairs, is done one by one. The plain form that this equals to the last bit stands in
tests/silo2d/test_engine_simd.py.
"""

import numpy as np
from numba import config, types
from numba.extending import intrinsic

from granulab.contact.compiled.rows import NOTHING, begin_of, data, load, named, store, transposed
from granulab.contact.jit import uncounted
from silo2d.engine.state import FX, FY, TORQUE

_PLAIN = bool(config.DISABLE_JIT)  # kernels as Python: it has no such vectors
_ROW = 4  # fours of numbers in a body's row; the one from FX on ends with 1/mass, which stays


@intrinsic
def _add_four(
    typingctx, row, vertex_body, edge_body, fx, fy, torque_j, torque_i, begin, k,
):  # fmt: skip
    """Loads of pairs k ... k + 3 of a block, one after the other, to the rows of their bodies."""
    number = types.int64
    signature = types.void(row, vertex_body, edge_body, fx, fy, torque_j, torque_i, number, number)

    def generate(context, builder, signature, arguments):
        row, vertex_body, edge_body, fx, fy, torque_j, torque_i, begin, k = data(
            context, builder, signature, arguments
        )
        first = builder.add(begin, k)
        x, y, on_j, on_i = (load(builder, each, k) for each in (fx, fy, torque_j, torque_i))
        of_j = transposed(builder, [x, y, on_j, NOTHING])
        of_i = transposed(builder, [builder.fneg(x), builder.fneg(y), on_i, NOTHING])
        for n in range(4):
            for bodies, change in ((vertex_body, of_j[n]), (edge_body, of_i[n])):
                at = begin_of(builder, named(builder, bodies, first, n), _ROW)
                store(builder, builder.fadd(load(builder, row, at, FX), change), row, at, FX)
        return context.get_dummy_value()

    return signature, generate


@uncounted
def add_loads(row, inner, forces, begin, n_pairs, sums):
    """Add forces and torques of a block to its bodies, in the order of the list.

    Returns what the pairs dissipate, sums that go on with those before: normal and tangential
    damping [W], friction [J].
    """
    normal, tangential, lost = sums
    fours = 0 if _PLAIN else n_pairs - n_pairs % 4
    for k in range(np.int64(0), fours, 4):
        _add_four(
            row, inner.vertex_body, inner.edge_body, forces.fx, forces.fy, forces.torque_j,
            forces.torque_i, begin, k,
        )  # fmt: skip
        for m in range(np.uintp(k), np.uintp(k + 4)):
            normal += forces.normal_power[m]
            tangential += forces.tangential_power[m]
            lost += forces.lost[m]
    for k in range(fours, n_pairs):
        j, i = inner.vertex_body[begin + k], inner.edge_body[begin + k]
        row[j, FX] += forces.fx[k]
        row[j, FY] += forces.fy[k]
        row[j, TORQUE] += forces.torque_j[k]
        row[i, FX] -= forces.fx[k]
        row[i, FY] -= forces.fy[k]
        row[i, TORQUE] += forces.torque_i[k]
        normal += forces.normal_power[k]
        tangential += forces.tangential_power[k]
        lost += forces.lost[k]
    return normal, tangential, lost
