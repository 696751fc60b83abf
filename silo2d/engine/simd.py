"""The processor's vectors, spelt out where a compiler does not find them: forces to rows of bodies.

A pair adds three numbers to the row of each of its bodies, and where it does it number by number a
step waits for itself: the next pair often has the same bodies. Here four pairs are transposed in
registers, and each adds a row of four at once. What is left over at the end of a block, fewer than
four pairs, is done one by one. The plain form that this equals to the last bit stands in
tests/silo2d/test_engine_simd.py.
"""

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.extending import intrinsic

from granulab.contact.compiled.rows import (
    NOTHING,
    NUMBER,
    begin_of,
    data,
    load,
    named,
    pointer_to,
    transposed,
)
from granulab.contact.jit import inner
from silo2d.engine.state import FX, FY, NOBODY, TORQUE

_PLAIN = bool(config.DISABLE_JIT)  # kernels as Python: it has no such vectors
_ROW = 4  # fours of numbers in a body's row; the one from FX on ends with 1/mass, which stays


@intrinsic
def _add_four(
    typingctx, row, aside, to_j, to_i, fx, fy, torque_j, torque_i, begin, k,
):  # fmt: skip
    """Loads of pairs k ... k + 3 of a block, one after the other, to rows; see add_loads."""
    number, may_be_nobody = types.int64, isinstance(aside, types.Array)
    signature = types.void(row, aside, to_j, to_i, fx, fy, torque_j, torque_i, number, number)

    def row_from_fx(builder, row, aside, body):
        there = pointer_to(builder, row, begin_of(builder, body, _ROW), FX)
        if not may_be_nobody:
            return there
        is_nobody = builder.icmp_unsigned("==", body, ir.Constant(NUMBER, int(NOBODY)))
        return builder.select(is_nobody, pointer_to(builder, aside, ir.Constant(NUMBER, FX)), there)

    def generate(context, builder, signature, arguments):
        row, aside, to_j, to_i, fx, fy, torque_j, torque_i, begin, k = data(
            context, builder, signature, arguments
        )
        first = builder.add(begin, k)
        x, y, on_j, on_i = (load(builder, each, k) for each in (fx, fy, torque_j, torque_i))
        of_j = transposed(builder, [x, y, on_j, NOTHING])
        of_i = transposed(builder, [builder.fneg(x), builder.fneg(y), on_i, NOTHING])
        for n in range(4):
            for bodies, change in ((to_j, of_j[n]), (to_i, of_i[n])):
                at = row_from_fx(builder, row, aside, named(builder, bodies, first, n))
                builder.store(builder.fadd(builder.load(at, align=8), change), at, align=8)
        return context.get_dummy_value()

    return signature, generate


@inner
def add_loads(row, aside, to_j, to_i, forces, begin, n_pairs, sums):
    """Add forces and torques of a block to rows of bodies, in the order of the list.

    to_j, to_i (capacity,): rows that take the loads of the vertices' and of the edges' bodies;
    NOBODY where none does. aside: None where every load has its row, else a row that nobody reads.
    Returns what the pairs dissipate, sums that go on with those before: normal and tangential
    damping [W], friction [J].
    """
    normal, tangential, lost = sums
    fours = 0 if _PLAIN else n_pairs - n_pairs % 4
    for k in range(np.int64(0), fours, 4):
        _add_four(
            row, aside, to_j, to_i, forces.fx, forces.fy, forces.torque_j, forces.torque_i, begin, k
        )
        for m in range(np.uintp(k), np.uintp(k + 4)):
            normal += forces.normal_power[m]
            tangential += forces.tangential_power[m]
            lost += forces.lost[m]
    for k in range(fours, n_pairs):
        j, i = to_j[begin + k], to_i[begin + k]
        if aside is None:  # without looking whose load is kept, which takes a step a tenth longer
            add_to_vertex_body(row, j, forces, k)
            add_to_edge_body(row, i, forces, k)
        else:
            _add_one(row, j, i, forces, k)
        normal += forces.normal_power[k]
        tangential += forces.tangential_power[k]
        lost += forces.lost[k]
    return normal, tangential, lost


@inner
def _add_one(row, j, i, forces, k):
    """Loads of one pair of a block, to the rows that there are."""
    if j != NOBODY:
        add_to_vertex_body(row, j, forces, k)
    if i != NOBODY:
        add_to_edge_body(row, i, forces, k)


@inner
def add_to_vertex_body(row, j, loads, k):
    """Add load k to row j, of the vertex's body."""
    row[j, FX] += loads.fx[k]
    row[j, FY] += loads.fy[k]
    row[j, TORQUE] += loads.torque_j[k]


@inner
def add_to_edge_body(row, i, loads, k):
    """Add load k to row i, of the edge's body."""
    row[i, FX] -= loads.fx[k]
    row[i, FY] -= loads.fy[k]
    row[i, TORQUE] += loads.torque_i[k]
