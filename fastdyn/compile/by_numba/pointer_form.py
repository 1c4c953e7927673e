"""Wraps a user's function: reads its parameters from the block, stores its result, notes errors.

`pointer_form` gives a function its one compiled form ``function(t, y, n, block, out)``; see
`kernels/calls/user_function.py`.
"""

from numba import types
from numba.extending import intrinsic

from fastdyn.kernels.calls.user_function import FORM
from fastdyn.kernels.jit_options import OWNING, njit
from fastdyn.kernels.state.elementwise import view

from .. import function_convention
from .result import ROW, store

READONLY = types.Array(types.float64, 1, "C", readonly=True)


@intrinsic
def _readonly(typingctx, y, n):
    return READONLY(y, n), lambda c, b, s, a: view(c, b, a[0], a[1])


@intrinsic
def _array(typingctx, y, n):
    return ROW(y, n), lambda c, b, s, a: view(c, b, a[0], a[1])


def pointer_form(inner, values, mode):
    """The compiled form of a user's function.

    Parameters
    ----------
    inner : dispatcher
        Called with the tuple that ``values(t, y, block)`` makes.
    values : intrinsic
    mode : mode.Mode
    """
    one_number = mode.one_number

    def body(t, y, n, block, out):
        found = inner(*values(t, _readonly(y, n), block))
        store(found, _array(out, 1 if one_number else n))

    return _guarded(body, one_number)


def _guarded(body, one_number):
    """The function of FORM that runs `body`, and notes where `body` raised."""
    compiled_body = njit(**OWNING)(body)
    compiled_body.compile(FORM)  # here, so that Numba's exception reaches the caller

    @intrinsic
    def attempt(typingctx, t, y, n, block, out):
        result = compiled_body.get_compile_result(types.none(*FORM))

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

        return types.none(*FORM), codegen

    @njit(**OWNING)
    def function(t, y, n, block, out):
        attempt(t, y, n, block, out)

    return function
