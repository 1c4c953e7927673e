"""The arguments of a user's function, read from the block of its parameters."""

import numpy as np
from llvmlite import ir
from numba import typeof, types
from numba.core import cgutils
from numba.extending import intrinsic
from numba.np.numpy_support import from_dtype

from fastdyn.kernels.calls.block import FIRST
from fastdyn.kernels.calls.calling_convention import array_of

from ..parameters import BOOL, COMPLEX, FLOAT, INT, Constant

NUMBERS = {
    FLOAT: types.float64, INT: types.int64, BOOL: types.boolean, COMPLEX: types.complex128
}  # fmt: skip


def arguments(layout):
    """An intrinsic ``values(t, y, block)``: the positional arguments of the user's function.

    `layout` has "t", "y" or the type of a parameter for each argument.
    """

    @intrinsic
    def values(typingctx, t, y, block):
        kinds = [t if kind == "t" else y if kind == "y" else numba_type(kind) for kind in layout]
        whole = types.Tuple(tuple(kinds))

        def codegen(context, builder, signature, args):
            parts, at = [], FIRST
            for kind in layout:
                if kind == "t":
                    parts.append(args[0])
                elif kind == "y":
                    parts.append(args[1])
                    if context.enable_nrt:
                        context.nrt.incref(builder, y, args[1])  # the tuple owns y, too
                else:
                    part, at = _read(context, builder, kind, args[2], at)
                    parts.append(part)
            return context.make_tuple(builder, whole, parts)

        return whole(t, y, block), codegen

    return values


def numba_type(kind):
    """The Numba type of a parameter: arrays are read-only; an unaligned array stands for a list."""
    if isinstance(kind, Constant):
        return typeof(kind.value)
    if kind in NUMBERS:
        return NUMBERS[kind]
    if kind[0] == "tuple":
        return types.BaseTuple.from_types([numba_type(each) for each in kind[1]])
    item, plain = from_dtype(np.dtype(kind[1])), kind[0] != "list"
    return types.Array(item, kind[2], "C", readonly=True, aligned=plain)


def is_list(ty):
    """True if a type stands for a list of the user, which is passed as an array."""
    return isinstance(ty, types.Array) and not ty.aligned


def _read(context, builder, kind, words, at):
    """The LLVM value of a parameter at word `at`, and the index of the next word."""
    ty = numba_type(kind)

    def word(index, as_type=None):
        pointer = cgutils.gep(builder, words, index)
        return builder.load(builder.bitcast(pointer, as_type.as_pointer()) if as_type else pointer)

    if isinstance(ty, types.Dispatcher):  # the type identifies the function
        return context.get_constant_null(ty), at
    if isinstance(kind, Constant):
        return context.get_constant_generic(builder, ty, kind.value), at
    if kind[0] == "tuple":
        parts = []
        for each in kind[1]:
            part, at = _read(context, builder, each, words, at)
            parts.append(part)
        return context.make_tuple(builder, ty, parts), at
    if isinstance(ty, types.Array):
        here = (word(at + i) for i in range(1 + ty.ndim))
        return array_of(context, builder, ty, here), at + 1 + ty.ndim
    if kind == COMPLEX:
        number = context.make_complex(builder, ty)
        number.real, number.imag = (word(at + i, ir.DoubleType()) for i in (0, 1))
        return number._getvalue(), at + 2
    if kind == FLOAT:
        return word(at, ir.DoubleType()), at + 1
    value = word(at)
    return builder.icmp_signed("!=", value, value.type(0)) if kind == BOOL else value, at + 1
