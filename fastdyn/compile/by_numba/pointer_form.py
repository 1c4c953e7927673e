"""Numba's code of a user's function in its one compiled form ``function(t, y, n, block, out)``.

The form reads the parameters from the block, stores the result, and notes exceptions: see
`kernels/calls/user_function.py`.
"""

# Numba and llvmlite declare fewer attributes than their objects have.
# pyright: reportAttributeAccessIssue=false

import functools

import numpy as np
from llvmlite import ir
from numba import typeof, types
from numba.core import cgutils, errors
from numba.core.registry import cpu_target
from numba.extending import intrinsic, overload
from numba.np.numpy_support import from_dtype

from fastdyn.kernels.calls.block import FIRST
from fastdyn.kernels.calls.calling_convention import array_of
from fastdyn.kernels.calls.user_function import FORM
from fastdyn.kernels.jit_options import OWNING, OWNING_INLINED, njit
from fastdyn.kernels.state.elementwise import view
from fastdyn.trace.written import function_of

from .. import function_convention
from ..callables import Uncompilable
from ..parameters import BOOL, COMPLEX, FLOAT, INT, Constant, n_words
from .as_it_is import compiled, dispatcher

NUMBERS = {
    FLOAT: types.float64, INT: types.int64, BOOL: types.boolean, COMPLEX: types.complex128
}  # fmt: skip
ROW = types.Array(types.float64, 1, "C")
REAL = (types.Float, types.Integer, types.Boolean)


def signature():
    """The signature of the form."""
    return types.none(*FORM)


def pointer_form(parts, mode, layout):
    """The dispatcher of a function's compiled form.

    `layout` has "t", "y" or the type of a parameter for each positional argument.
    """
    _check_convention()
    ready = [Constant(k.token, compiled(k.value)) if isinstance(k, Constant) else k for k in layout]
    values, inner, one_number = _arguments(ready), dispatcher(parts), mode.one_number

    def body(t, y, n, block, out):
        found = inner(*values(t, _row(y, n, True), block))
        _store(found, _row(out, 1 if one_number else n, False))

    return _guarded(body, one_number)


@functools.cache
def _check_convention():
    """Refuse a version of Numba that calls functions in another way than kept kernels do."""
    numbas = _kinds(cpu_target.target_context.call_conv.get_function_type(types.none, FORM))
    if numbas != _kinds(function_convention.form()):
        raise Uncompilable(f"this version of Numba calls functions by {numbas}, which is new")


def _kinds(form):
    """The types of the result and the arguments; all pointers count as one type."""
    return ["ptr" if t.is_pointer else str(t) for t in (form.return_type, *form.args)]


def _guarded(body, one_number):
    """The function of FORM that runs `body`, and notes where `body` raised."""
    compiled_body = njit(**OWNING)(body)
    compiled_body.compile(FORM)  # here, so that Numba's exception reaches the caller

    @intrinsic
    def attempt(typingctx, t, y, n, block, out):
        result = compiled_body.get_compile_result(signature())

        def codegen(context, builder, signature, args):
            context.active_code_library.add_linking_library(result.library)
            status, _ = context.call_internal_no_propagate(
                builder, result.fndesc, result.signature, args
            )
            with builder.if_then(status.is_error, likely=False):
                t, y, n, block, out = args
                n_results = n.type(1) if one_number else n
                function_convention.note_fault(builder, t, y, block, out, n, n_results)
            return context.get_dummy_value()

        return signature(), codegen

    @njit(**OWNING)
    def function(t, y, n, block, out):
        attempt(t, y, n, block, out)

    return function


@intrinsic(prefer_literal=True)
def _row(typingctx, pointer, n, readonly):
    kind = ROW.copy(readonly=readonly.literal_value)
    return kind(pointer, n, readonly), lambda c, b, s, a: view(c, b, a[0], a[1])


# -- the arguments, read from the block


def _arguments(layout):
    """An intrinsic ``values(t, y, block)``: the positional arguments of the user's function."""

    @intrinsic
    def values(typingctx, t, y, block):
        whole = types.Tuple(
            tuple([t if k == "t" else y if k == "y" else _numba_type(k) for k in layout])
        )

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
                    parts.append(_read(context, builder, kind, args[2], at))
                    at += n_words(kind)
            return context.make_tuple(builder, whole, parts)

        return whole(t, y, block), codegen

    return values


def _numba_type(kind):
    """The Numba type of a parameter; arrays are read-only."""
    if isinstance(kind, Constant):
        return typeof(kind.value)
    if kind in NUMBERS:
        return NUMBERS[kind]
    return types.Array(from_dtype(np.dtype(kind[1])), kind[2], "C", readonly=True)


def _read(context, builder, kind, words, at):
    """The LLVM value of a parameter at word `at`."""
    ty = _numba_type(kind)

    def word(index, as_type=None):
        pointer = cgutils.gep(builder, words, index)
        return builder.load(builder.bitcast(pointer, as_type.as_pointer()) if as_type else pointer)

    if isinstance(ty, types.Dispatcher):  # the type identifies the function
        return context.get_constant_null(ty)
    if isinstance(kind, Constant):
        return context.get_constant_generic(builder, ty, kind.value)
    if isinstance(ty, types.Array):
        return array_of(context, builder, ty, (word(at + i) for i in range(1 + ty.ndim)))
    if kind == COMPLEX:
        number = context.make_complex(builder, ty)
        number.real, number.imag = (word(at + i, ir.DoubleType()) for i in (0, 1))
        return number._getvalue()
    if kind == FLOAT:
        return word(at, ir.DoubleType())
    value = word(at)
    return builder.icmp_signed("!=", value, value.type(0)) if kind == BOOL else value


# -- the result


def _store(value, out):
    """Write a user's result to `out`."""
    raise TypeError("compiled only")


@overload(_store, jit_options=OWNING_INLINED)
def _stored(value, out):
    items = value if isinstance(value, types.BaseTuple) else [getattr(value, "dtype", value)]
    if not all(isinstance(ty, REAL) for ty in items):
        raise errors.TypingError(f"the result is of type {value}, not real numbers")
    if isinstance(value, types.BaseTuple):
        lines = [f"    out[{i}] = value[{i}]\n" for i in range(len(value))]
        text = f"def stored(value, out):\n    _check(len(value), out)\n{''.join(lines)}"
        return function_of(text, "stored", "result of a function", {"_check": _check})
    if isinstance(value, types.List | types.ListType):
        return lambda value, out: _store(np.array(value), out)
    if isinstance(value, types.Array) and value.ndim == 1:
        return _store_row
    if isinstance(value, types.Array) and value.ndim == 0:
        return lambda value, out: _store(value[()], out)
    if isinstance(value, REAL):
        return _store_number
    raise errors.TypingError(f"the result is of type {value}, not a row of real numbers")


@njit(**OWNING_INLINED)
def _check(n, out):
    if n != len(out):
        raise ValueError("fun returned a sequence of the wrong length")


def _store_row(value, out):
    _check(len(value), out)
    for i in range(len(out)):
        out[i] = value[i]


def _store_number(value, out):
    _check(1, out)
    out[0] = value
