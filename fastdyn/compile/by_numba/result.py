"""The result of a user's function, written by compiled code."""

import numpy as np
from numba import types
from numba.core import errors
from numba.extending import intrinsic, overload
from numba.np import arrayobj

from fastdyn.kernels.jit_options import OWNING, OWNING_INLINED, njit

ROW = types.Array(types.float64, 1, "C")
REAL = (types.Float, types.Integer, types.Boolean)


def store(value, out):
    """Write a user's result to `out`."""
    raise TypeError("compiled only")


@overload(store, jit_options=OWNING)
def _store(value, out):
    items = value if isinstance(value, types.BaseTuple) else [getattr(value, "dtype", value)]
    if not all(isinstance(ty, REAL) for ty in items):
        raise errors.TypingError(f"the result is of type {value}, not real numbers")
    if isinstance(value, types.BaseTuple):
        return _store_tuple_of(len(value))
    if isinstance(value, types.Array) and value.ndim == 1:
        return lambda value, out: _store_row(value, out)
    if isinstance(value, types.Array) and value.ndim == 0:
        return lambda value, out: _store_number(value[()], out)
    if isinstance(value, types.List | types.ListType):
        return lambda value, out: _store_row(np.array(value), out)
    if isinstance(value, REAL):
        return lambda value, out: _store_number(value, out)
    raise errors.TypingError(f"the result is of type {value}, not a row of real numbers")


@njit(**OWNING_INLINED)
def _store_number(value, out):
    if len(out) != 1:
        raise ValueError("fun returned a number")
    out[0] = value


@njit(**OWNING_INLINED)
def _store_row(value, out):
    if len(value) != len(out):
        raise ValueError("fun returned an array of the wrong length")
    for i in range(len(out)):
        out[i] = value[i]


def _store_tuple_of(n):
    def store_tuple(value, out):
        if n != len(out):
            raise ValueError("fun returned a sequence of the wrong length")
        _store_tuple(value, out)

    return store_tuple


@intrinsic
def _store_tuple(typingctx, value, out):
    def codegen(context, builder, signature, args):
        data = arrayobj.make_array(ROW)(context, builder, args[1]).data
        for i, ty in enumerate(value):
            number = context.cast(builder, builder.extract_value(args[0], i), ty, types.float64)
            builder.store(number, builder.gep(data, [context.get_constant(types.intp, i)]))
        return context.get_dummy_value()

    return types.none(value, out), codegen
