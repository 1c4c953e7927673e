"""The stages of an implicit step as vectors: the s stages of a component lie side by side.

s rows of `work` hold n components of s stages each.

LLVM, because Numba has no fused product and sum, and no vectors whose elements could be
read or replaced.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ...state.constant import Constant
from ...state.elementwise import ROW, data_of, length_of
from ...vector.instructions import INDEX, REAL, constant, intrinsic_of, splat
from ...vector.number import Vector


class Matrix(Constant):
    """A matrix of constants known to the compiler, given by rows."""

    def __init__(self, rows):
        self.rows = tuple(tuple(map(float, row)) for row in rows)

    def __repr__(self):
        return f"Matrix({self.rows!r})"


@intrinsic
def first_row(typingctx, matrix):
    """The first row of a matrix as an exact vector."""
    row = matrix.known.rows[0]
    vector = Vector(len(row), exact=True)
    value = ir.Constant(ir.VectorType(REAL, len(row)), list(row))
    return vector(matrix), lambda context, builder, signature, args: value


@intrinsic
def with_ends(typingctx, x, end):
    """The vector x with its first and its last number replaced."""

    def codegen(context, builder, signature, args):
        first = builder.insert_element(*args, INDEX(0))
        return builder.insert_element(first, args[1], INDEX(x.width - 1))

    return x(x, types.float64), codegen


@intrinsic
def product(typingctx, matrix, x):
    """matrix @ x: a fused multiply-add of whole vectors for each column, in two chains."""

    def codegen(context, builder, signature, args):
        kind = args[1].type
        fma = intrinsic_of(builder, "fma", kind, 3)
        sums = [constant(kind, 0)] * 2
        for j in range(x.width):
            column = ir.Constant(kind, [row[j] for row in matrix.known.rows])
            part = splat(builder, builder.extract_element(args[1], INDEX(j)), x.width)
            sums[j % 2] = builder.call(fma, [column, part, sums[j % 2]])
        return builder.fadd(*sums)

    return x(matrix, x), codegen


@intrinsic
def largest(typingctx, x):
    """The largest number of a vector."""

    def codegen(context, builder, signature, args):
        kind = ir.FunctionType(REAL, [args[0].type])
        name = f"llvm.vector.reduce.fmax.v{x.width}f64"
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), args)

    return types.float64(x), codegen


@intrinsic
def stage_value(typingctx, form, place, numbers, at, step):
    """Every `step`-th number from `at` on as a value: a tuple, or the row `place`."""
    value = ROW if isinstance(form, types.NoneType) else form

    def codegen(context, builder, signature, args):
        _, target, numbers, at, step = args
        source = data_of(context, builder, ROW, numbers)

        def component(i):
            return builder.load(builder.gep(source, [builder.add(at, builder.mul(i, step))]))

        if value != ROW:
            parts = [component(step.type(i)) for i in range(len(form))]
            return context.make_tuple(builder, form, parts)
        data = data_of(context, builder, ROW, target)
        with cgutils.for_range(builder, length_of(context, builder, ROW, target)) as loop:
            builder.store(component(loop.index), builder.gep(data, [loop.index]))
        return target

    return value(form, place, numbers, types.intp, types.intp), codegen


@intrinsic
def keep_increments(typingctx, value, weight, numbers, at, step):
    """Store weight * value, its components `step` numbers apart from `at` on."""

    def codegen(context, builder, signature, args):
        given, weight, numbers, at, step = args
        data = data_of(context, builder, ROW, numbers)

        def keep(i, x):
            place = builder.gep(data, [builder.add(at, builder.mul(i, step))])
            place = builder.bitcast(place, x.type.as_pointer())
            builder.store(builder.fmul(weight, x), place).align = 8

        if isinstance(value, types.BaseTuple):
            for i in range(len(value)):
                keep(step.type(i), builder.extract_value(given, i))
        else:
            source = data_of(context, builder, ROW, given)
            with cgutils.for_range(builder, length_of(context, builder, ROW, given)) as loop:
                keep(loop.index, builder.load(builder.gep(source, [loop.index])))
        return context.get_dummy_value()

    return types.none(value, weight, numbers, types.intp, types.intp), codegen
