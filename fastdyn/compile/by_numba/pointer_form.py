"""Numba's code of a user's function in its one compiled form ``function(t, y, n, block, out)``.

The form reads the parameters from the block, stores the result, and notes exceptions: see
`kernels/calls/user_function.py`.
"""

# Numba and llvmlite declare fewer attributes than their objects have.
# pyright: reportAttributeAccessIssue=false

import functools
import itertools

import numpy as np
from numba import types
from numba.core import cgutils
from numba.core.registry import cpu_target
from numba.extending import intrinsic
from numba.np.numpy_support import from_dtype

from fastdyn.kernels.calls.block import FIRST
from fastdyn.kernels.calls.calling_convention import values_of
from fastdyn.kernels.calls.user_function import FORM
from fastdyn.kernels.jit.options import OWNING, OWNING_INLINED, njit
from fastdyn.kernels.state.elementwise import ROW, view
from fastdyn.trace.written import function_of

from .. import function_convention
from ..callables import Uncompilable
from ..parameters import FLOAT, Constant
from .as_it_is import compiled, dispatcher


def signature():
    """The signature of the form."""
    return types.none(*FORM)


def pointer_form(parts, mode, layout):
    """The dispatcher of a function's compiled form.

    `layout` has "t", "y" or the type of a parameter for each positional argument.
    """
    _check_convention()
    call, named = _call(layout)
    length = 1 if mode.one_number else "n"
    text = f"""def body(t, y, n, block, out):
    found = parameters(block)
    store({call}, row(out, {length}, False))
"""
    named |= {"inner": dispatcher(parts), "row": _row, "store": _store}
    named["parameters"] = _parameters(layout)
    return _guarded(function_of(text, "body", "call of a function", named), mode.one_number)


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


# -- the arguments, read from the block, and the result


def _parameters(layout):
    """An intrinsic ``parameters(block)``: the tuple of the parameters in the block."""
    kinds = [_numba_type(k) for k in layout if k not in ("t", "y") and not isinstance(k, Constant)]

    @intrinsic
    def parameters(typingctx, block):
        whole = types.Tuple(kinds)

        def codegen(context, builder, signature, args):
            given = values_of(context, builder, kinds, cgutils.gep(builder, args[0], FIRST))
            return context.make_tuple(builder, whole, given)

        return whole(block), codegen

    return parameters


def _numba_type(kind):
    """The Numba type of a parameter; arrays are read-only."""
    if kind[0] == "array":
        return types.Array(from_dtype(np.dtype(kind[1])), kind[2], "C", readonly=True)
    return types.float64 if kind == FLOAT else types.int64


def _call(layout):
    """The text of a call with the arguments of a layout, and the values that the text names."""
    places = itertools.count()
    given = []
    named = {}
    for kind in layout:
        if isinstance(kind, Constant):
            given.append(f"constant_{len(named)}")
            named[given[-1]] = compiled(kind.value)
        else:
            own = {"t": "t", "y": "row(y, n, True)"}
            given.append(own.get(kind) or f"found[{next(places)}]")
    return f"inner({', '.join(given)})", named


@njit(**OWNING_INLINED)
def _store(value, out):
    """Write a user's result, numbers in a row or a single number, to `out`."""
    found = np.asarray(value)
    if found.size != len(out):
        raise ValueError("fun returned a sequence of the wrong length")
    out[:] = found
