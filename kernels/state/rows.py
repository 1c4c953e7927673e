"""Rows of the work array as values of the state, and back.

LLVM, because a slice of Numba looks for negative bounds (see `elementwise.py`), and because Numba
returns no array on the stack and loads no vector from a row.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..jit.arrays import borrowed, shape_of
from ..jit.options import INTERNAL, njit
from .elementwise import ROW, data_of, length_of, load, view


def _row_pointer(context, builder, ty, work, index, number=types.float64):
    """The address of a row of numbers of the type `number`."""
    _, n = shape_of(context, builder, ty, work)
    row = builder.gep(data_of(context, builder, ty, work), [builder.mul(index, n)])
    return builder.bitcast(row, context.get_value_type(number).as_pointer())


def _row(context, builder, ty, work, index):
    _, n = shape_of(context, builder, ty, work)
    return view(context, builder, _row_pointer(context, builder, ty, work, index), n)


@intrinsic
def numbers_of(typingctx, work):
    """All numbers of `work` as one row."""

    def codegen(context, builder, signature, args):
        rows, n = shape_of(context, builder, work, args[0])
        return view(
            context, builder, data_of(context, builder, work, args[0]), builder.mul(rows, n)
        )

    return ROW(work), codegen


@intrinsic
def after(typingctx, row, offset):
    """The numbers of a row from `offset` on; the length of the row is not checked."""

    def codegen(context, builder, signature, args):
        pointer = builder.gep(data_of(context, builder, row, args[0]), [args[1]])
        n = builder.sub(length_of(context, builder, row, args[0]), args[1])
        return view(context, builder, pointer, n)

    return ROW(row, types.intp), codegen


@njit(**INTERNAL)
def numbers_from(work, first, offset):
    """The numbers of `work` from row `first` on, without the first `offset`, as one row."""
    return after(numbers_of(work), first * work.shape[1] + offset)


def scratch(size):
    """A function that returns a row of `size` numbers on the stack."""

    @intrinsic
    def row(typingctx):
        def codegen(context, builder, signature, args):
            place = cgutils.alloca_once(builder, ir.ArrayType(ir.DoubleType(), size))
            n = context.get_constant(types.intp, size)
            return view(context, builder, cgutils.gep(builder, place, 0, 0), n)

        return ROW(), codegen

    return row


@intrinsic
def vector_at(typingctx, form, row, at):
    """The numbers of a row from `at` on, as a vector of this form."""
    vector = form.known.value.dtype

    def codegen(context, builder, signature, args):
        return load(builder, _vector_pointer(context, builder, vector, *args[1:]))

    return vector(form, row, types.intp), codegen


@intrinsic
def keep_vector(typingctx, form, row, at, value):
    """Store a number or a vector as a vector of this form, from `at` on."""
    vector = form.known.value.dtype

    def codegen(context, builder, signature, args):
        _, *place, value = args
        builder.store(value, _vector_pointer(context, builder, vector, *place)).align = 8
        return context.get_dummy_value()

    return types.none(form, row, types.intp, vector), codegen


def _vector_pointer(context, builder, vector, row, at):
    place = builder.gep(data_of(context, builder, ROW, row), [at])
    return builder.bitcast(place, context.get_value_type(vector).as_pointer())


@intrinsic
def slot(typingctx, form, work, index):
    """Row `index` of `work` as the place for a result; None when values are tuples."""
    if isinstance(form, types.NoneType):
        return ROW(form, work, types.intp), lambda c, b, s, a: _row(c, b, work, a[1], a[2])
    return types.none(form, work, types.intp), lambda c, *_: c.get_dummy_value()


@intrinsic
def fetch(typingctx, form, work, index):
    """Row `index` of `work` as a value.

    `form` is None for the row itself, a tuple of n numbers, or a `layout.Form`.
    """
    if isinstance(form, types.NoneType):
        return ROW(form, work, types.intp), lambda c, b, s, a: _row(c, b, work, a[1], a[2])

    value = form if isinstance(form, types.BaseTuple) else form.known.value

    def codegen(context, builder, signature, args):
        pointer = _row_pointer(context, builder, work, args[1], args[2], value.dtype)
        parts = [load(builder, cgutils.gep(builder, pointer, i)) for i in range(len(value))]
        return context.make_tuple(builder, value, parts)

    return value(form, work, types.intp), codegen


@intrinsic(prefer_literal=True)
def rows_on_stack(typingctx, n_rows, width):
    """An array of shape (n_rows, width), both constants, on the stack of the function."""
    shape, kind = (n_rows.literal_value, width.literal_value), types.Array(types.float64, 2, "C")

    def codegen(context, builder, signature, args):
        place = cgutils.alloca_once(builder, ir.ArrayType(ir.DoubleType(), shape[0] * shape[1]))
        data = builder.bitcast(place, ir.DoubleType().as_pointer())
        extents = [context.get_constant(types.intp, extent) for extent in shape]
        return borrowed(context, builder, kind, data, extents)

    return kind(n_rows, width), codegen


@njit(**INTERNAL)
def copy_row(row, out):
    # A loop, because an assignment of a row to a row allocates memory, in case the rows overlap.
    for i in range(len(row)):
        out[i] = row[i]


@intrinsic
def keep(typingctx, work, index, values):
    """Store a tuple of values in consecutive rows of `work`, from `index` on.

    Values that are rows of `work` are in place already.
    """
    signature = types.none(work, types.intp, values)
    if values[0] == ROW:
        return signature, lambda context, *_: context.get_dummy_value()

    def codegen(context, builder, signature, args):
        for j, ty in enumerate(values):
            row = builder.add(args[1], ir.Constant(args[1].type, j))
            pointer = _row_pointer(context, builder, work, args[0], row, ty.dtype)
            value = builder.extract_value(args[2], j)
            for i in range(len(ty)):
                part = builder.extract_value(value, i)
                builder.store(part, cgutils.gep(builder, pointer, i)).align = 8
        return context.get_dummy_value()

    return signature, codegen
