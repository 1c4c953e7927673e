"""The stages of an implicit step as vectors: those of one component lie side by side.

`work` has blocks of s rows, read as n components of s stages each; a block is named by its first
row.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np import arrayobj

from ..state.constant import Constant
from ..state.elementwise import ROW
from ..vector.number import Vector

REAL = ir.DoubleType()


class Matrix(Constant):
    """A square matrix of constants known to the compiler, given by rows."""

    def __init__(self, rows):
        self.rows = tuple(tuple(map(float, row)) for row in rows)

    def __repr__(self):
        return f"Matrix({self.rows!r})"


def _stages_at(context, builder, work, args, s):
    """Pointer to the s stages of component args[2] in the block of rows from args[1] on."""
    array = arrayobj.make_array(work)(context, builder, args[0])
    n = builder.extract_value(array.shape, 1)
    at = builder.add(builder.mul(args[1], n), builder.mul(args[2], ir.Constant(n.type, s)))
    pointer = builder.gep(array.data, [at])
    return builder.bitcast(pointer, ir.VectorType(REAL, s).as_pointer())


def _splat(builder, value, s):
    vector = ir.VectorType(REAL, s)
    one = builder.insert_element(ir.Constant(vector, ir.Undefined), value, ir.IntType(32)(0))
    return builder.shuffle_vector(
        one, ir.Constant(vector, ir.Undefined), ir.Constant(ir.VectorType(ir.IntType(32), s), None)
    )


def _product(builder, matrix, stages, s):
    """matrix @ stages: a fused multiply-add of whole vectors for each column, in two chains."""
    vector = ir.VectorType(REAL, s)
    kind = ir.FunctionType(vector, [vector] * 3)
    fma = cgutils.get_or_insert_function(builder.module, kind, f"llvm.fma.v{s}f64")
    sums = [ir.Constant(vector, [0.0] * s)] * 2
    for j in range(s):
        column = ir.Constant(vector, [row[j] for row in matrix.known.rows])
        part = builder.extract_element(stages, ir.IntType(32)(j))
        sums[j % 2] = builder.call(fma, [column, _splat(builder, part, s), sums[j % 2]])
    return builder.fadd(*sums)


def _load(builder, pointer):
    value = builder.load(pointer)
    value.align = 8
    return value


@intrinsic
def predict(typingctx, matrix, work, row, c):
    """Stages of component c from those of the last step, in place."""
    s = len(matrix.known.rows)

    def codegen(context, builder, signature, args):
        pointer = _stages_at(context, builder, work, args[1:], s)
        result = _product(builder, matrix, _load(builder, pointer), s)
        builder.store(result, pointer).align = 8
        return context.get_dummy_value()

    return types.none(matrix, work, types.intp, types.intp), codegen


@intrinsic
def refine(typingctx, matrix, work, increments, stages, c, y, low):
    """Stages of component c from the increments: y + (low + mu L); the largest change."""
    s = len(matrix.known.rows)

    def codegen(context, builder, signature, args):
        _, array, first, second, component, y, low = args
        given = _stages_at(context, builder, work, (array, first, component), s)
        place = _stages_at(context, builder, work, (array, second, component), s)
        total = _product(builder, matrix, _load(builder, given), s)
        total = builder.fadd(_splat(builder, low, s), total)
        total = builder.fadd(_splat(builder, y, s), total)
        change = builder.fsub(total, _load(builder, place))
        builder.store(total, place).align = 8
        vector = ir.VectorType(REAL, s)
        fabs = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(vector, [vector]), f"llvm.fabs.v{s}f64"
        )
        largest = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(REAL, [vector]), f"llvm.vector.reduce.fmax.v{s}f64"
        )
        return builder.call(largest, [builder.call(fabs, [change])])

    numbers = (types.intp, types.intp, types.intp, types.float64, types.float64)
    return types.float64(matrix, work, *numbers), codegen


@intrinsic
def follow(typingctx, weights, work, increments, stages, k, of, h, end):
    """L of component k is h b times the stages of component `of`: positions follow velocities."""
    (b,) = weights.known.rows
    s = len(b)

    def codegen(context, builder, signature, args):
        _, array, first, second, k, of, h, end = args
        target = _stages_at(context, builder, work, (array, first, k), s)
        given = _stages_at(context, builder, work, (array, second, of), s)
        vector = builder.fmul(_splat(builder, h, s), ir.Constant(ir.VectorType(REAL, s), list(b)))
        for i in (0, s - 1):
            vector = builder.insert_element(vector, end, ir.IntType(32)(i))
        builder.store(builder.fmul(vector, _load(builder, given)), target).align = 8
        return context.get_dummy_value()

    numbers = (types.intp,) * 4 + (types.float64,) * 2
    return types.none(weights, work, *numbers), codegen


def _component(context, builder, work, array, row, s, c, i):
    """Pointer to stage i of component c."""
    value = arrayobj.make_array(work)(context, builder, array)
    n = builder.extract_value(value.shape, 1)
    at = builder.add(builder.mul(row, n), builder.add(builder.mul(c, n.type(s)), i))
    return builder.gep(value.data, [at])


@intrinsic
def stage_value(typingctx, form, place, work, row, matrix, i):
    """The state at stage i, as a value: a tuple, or the row `place`."""
    s = len(matrix.known.rows)
    signature_rest = (work, types.intp, matrix, types.intp)
    if isinstance(form, types.NoneType):

        def fill(context, builder, signature, args):
            _, target, array, row, _, i = args
            data = arrayobj.make_array(ROW)(context, builder, target)
            n = builder.extract_value(data.shape, 0)
            with cgutils.for_range(builder, n) as loop:
                source = _component(context, builder, work, array, row, s, loop.index, i)
                builder.store(builder.load(source), builder.gep(data.data, [loop.index]))
            return target

        return ROW(form, place, *signature_rest), fill

    def codegen(context, builder, signature, args):
        _, _, array, row, _, i = args
        parts = [
            builder.load(_component(context, builder, work, array, row, s, row.type(c), i))
            for c in range(len(form))
        ]
        return context.make_tuple(builder, form, parts)

    return form(form, place, *signature_rest), codegen


@intrinsic
def keep_increment(typingctx, value, work, row, matrix, i, weight):
    """L_i = weight * f, from a tuple or a row."""
    s = len(matrix.known.rows)

    def codegen(context, builder, signature, args):
        value_, array, row, _, i, weight = args

        def put(c, x):
            pointer = _component(context, builder, work, array, row, s, c, i)
            builder.store(builder.fmul(weight, x), pointer)

        if isinstance(value, types.BaseTuple):
            for c in range(len(value)):
                put(row.type(c), builder.extract_value(value_, c))
        else:
            data = arrayobj.make_array(ROW)(context, builder, value_)
            with cgutils.for_range(builder, builder.extract_value(data.shape, 0)) as loop:
                put(loop.index, builder.load(builder.gep(data.data, [loop.index])))
        return context.get_dummy_value()

    return types.none(value, work, types.intp, matrix, types.intp, types.float64), codegen


@intrinsic
def stage_times(typingctx, nodes, t, h):
    """t + c h of all stages, as an exact vector."""
    (c,) = nodes.known.rows
    s = len(c)

    def codegen(context, builder, signature, args):
        _, t, h = args
        shifts = builder.fmul(ir.Constant(ir.VectorType(REAL, s), list(c)), _splat(builder, h, s))
        return builder.fadd(_splat(builder, t, s), shifts)

    return Vector(s, exact=True)(nodes, types.float64, types.float64), codegen


@intrinsic
def keep_increments(typingctx, weights, work, row, first, value, h, end):
    """L of all stages from their derivatives, from component `first` on; see `follow`."""
    (b,) = weights.known.rows
    s = len(b)

    def codegen(context, builder, signature, args):
        _, array, row, first, value, h, end = args
        vector = builder.fmul(_splat(builder, h, s), ir.Constant(ir.VectorType(REAL, s), list(b)))
        for i in (0, s - 1):
            vector = builder.insert_element(vector, end, ir.IntType(32)(i))
        for c in range(len(signature.args[4])):
            component = builder.add(first, first.type(c))
            target = _stages_at(context, builder, work, (array, row, component), s)
            product = builder.fmul(vector, builder.extract_value(value, c))
            builder.store(product, target).align = 8
        return context.get_dummy_value()

    numbers = (types.float64,) * 2
    return types.none(weights, work, types.intp, types.intp, value, *numbers), codegen
