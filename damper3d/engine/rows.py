"""Instructions on rows of four numbers, of which the kernels' own vector code is made.

Functions that write them into a kernel while numba compiles it (builder is llvmlite's). What a
compiler finds by itself needs none of this; see lanes.py and integrate.py for what it does not.
"""

from llvmlite import ir
from numba import types

from damper3d.engine.state import BLOCK

_ROW = ir.VectorType(ir.DoubleType(), 4)
_NUMBER = ir.IntType(64)
NOTHING = ir.Constant(_ROW, [0.0] * 4)


def _lanes(*numbers):
    return ir.Constant(ir.VectorType(ir.IntType(32), len(numbers)), list(numbers))


def transposed(builder, rows):
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


def spread(builder, vector, lane):
    """A vector with one lane of another in all of its own."""
    return builder.shuffle_vector(vector, vector, _lanes(*[lane] * 4))


def pointer_to(builder, pointer, number, ahead=0):
    """The four numbers of an array of doubles from number + ahead on, as a pointer to a vector."""
    if ahead:
        number = builder.add(number, ir.Constant(_NUMBER, ahead))
    return builder.bitcast(builder.gep(pointer, [number]), _ROW.as_pointer())


def load(builder, pointer, number, ahead=0):
    """These four numbers."""
    return builder.load(pointer_to(builder, pointer, number, ahead), align=8)


def store(builder, vector, pointer, number, ahead=0):
    """Four numbers to there."""
    builder.store(vector, pointer_to(builder, pointer, number, ahead), align=8)


def store_columns(builder, rows, out, k, columns):
    """Four rows to lanes k ... of columns of a block, as many as are named."""
    for c, column in zip(columns, transposed(builder, rows), strict=False):
        store(builder, column, out, k, c * BLOCK)


def named(builder, numbers, begin, lane):
    """Entry begin + lane of an array of uint32, as a number."""
    n = builder.add(begin, ir.Constant(_NUMBER, lane))
    return builder.zext(builder.load(builder.gep(numbers, [n])), _NUMBER)


def begin_of(builder, number, rows_of_four=1):
    """Where a row begins that has so many times four numbers."""
    return builder.mul(number, ir.Constant(_NUMBER, 4 * rows_of_four))


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


def square(builder, row):
    """The sum of the squares of the first three numbers of a row."""
    x, y, z = (builder.extract_element(row, ir.Constant(ir.IntType(32), c)) for c in range(3))
    xx, yy, zz = (builder.fmul(number, number) for number in (x, y, z))
    return builder.fadd(builder.fadd(xx, yy), zz)
