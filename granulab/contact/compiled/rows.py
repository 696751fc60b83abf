"""Rows of four numbers: instructions that write vector code into a kernel while numba compiles it.

Where a contact needs numbers of two bodies, which stand in rows, and passes over contacts want one
array a quantity, a compiler loads and inserts number by number. Rows are loaded whole here, and
transposed in registers. builder is llvmlite's; numbers are indices of doubles in an array.
"""

from llvmlite import ir
from numba import types

ROW = ir.VectorType(ir.DoubleType(), 4)
NUMBER = ir.IntType(64)
NOTHING = ir.Constant(ROW, [0.0] * 4)
_ONES = ir.Constant(ROW, [1.0] * 4)


def lanes(*numbers):
    """Lanes for a shuffle to choose."""
    return ir.Constant(ir.VectorType(ir.IntType(32), len(numbers)), list(numbers))


def transposed(builder, rows):
    """Four rows of four as four columns."""
    a, b, c, d = rows
    even, odd = lanes(0, 4, 2, 6), lanes(1, 5, 3, 7)
    ab0, ab1 = builder.shuffle_vector(a, b, even), builder.shuffle_vector(a, b, odd)
    cd0, cd1 = builder.shuffle_vector(c, d, even), builder.shuffle_vector(c, d, odd)
    low, high = lanes(0, 1, 4, 5), lanes(2, 3, 6, 7)
    return [
        builder.shuffle_vector(ab0, cd0, low),
        builder.shuffle_vector(ab1, cd1, low),
        builder.shuffle_vector(ab0, cd0, high),
        builder.shuffle_vector(ab1, cd1, high),
    ]


def spread(builder, vector, lane):
    """A vector with one lane of another in all of its own."""
    return builder.shuffle_vector(vector, vector, lanes(*[lane] * 4))


def spread_to_three(builder, vector, lane):
    """A vector with one lane of another in its first three, and 1 in the last."""
    return builder.shuffle_vector(vector, _ONES, lanes(lane, lane, lane, 4))


def pointer_to(builder, pointer, number, ahead=0):
    """The four numbers of an array of doubles from number + ahead on, as a pointer to a vector."""
    if ahead:
        number = builder.add(number, ir.Constant(NUMBER, ahead))
    return builder.bitcast(builder.gep(pointer, [number]), ROW.as_pointer())


def load(builder, pointer, number, ahead=0):
    """These four numbers."""
    return builder.load(pointer_to(builder, pointer, number, ahead), align=8)


def store(builder, vector, pointer, number, ahead=0):
    """Four numbers to there."""
    builder.store(vector, pointer_to(builder, pointer, number, ahead), align=8)


def named(builder, numbers, begin, lane):
    """Entry begin + lane of an array of uint32, as a number."""
    n = builder.add(begin, ir.Constant(NUMBER, lane))
    return builder.zext(builder.load(builder.gep(numbers, [n])), NUMBER)


def begin_of(builder, number, rows_of_four=1):
    """Return where a row begins that has so many times four numbers."""
    return builder.mul(number, ir.Constant(NUMBER, 4 * rows_of_four))


def store_columns(builder, rows, out, k, columns, height):
    """Four rows to lanes k ... of the columns named of an array whose columns are so long."""
    for c, column in zip(columns, transposed(builder, rows), strict=False):
        store(builder, column, out, k, c * height)


def data(context, builder, signature, arguments):
    """Pointers to the data of the arrays among the arguments; the numbers as they are."""
    return [
        context.make_array(kind)(context, builder, argument).data
        if isinstance(kind, types.Array)
        else argument
        for kind, argument in zip(signature.args, arguments, strict=True)
    ]


def filled(builder, number):
    """A row that has one number four times."""
    return spread(builder, row_of(builder, [number]), 0)


def row_of(builder, numbers):
    """A row that begins with these numbers; the others are zero."""
    made = NOTHING
    for lane, number in enumerate(numbers):
        made = builder.insert_element(made, number, ir.Constant(ir.IntType(32), lane))
    return made
