"""Binds functions: compiled code for the function, and a block with its parameters.

`bind` takes a function as the user wrote it (function, lambda, method, partial, callable object,
jitted or not) and the current values that the function uses.  `bind` returns a Bound; kernels call
the function by the block of the Bound.  A function that cannot be compiled is called in Python
from the same kernels, after one warning.
"""

import functools

from fastdyn.code_store.numba_settings import DISABLED

from . import budget
from .bound import Bound, with_callback, with_code
from .by_numba.function import compiled_function
from .callables import numpy_errors
from .callables.diagnostics import FoundLater, GaveUp, Uncompilable, warn_once
from .callables.parts import Y, parts_of
from .compare import compare_around
from .derivatives.jacobian_block import constant_block, constant_function
from .derivatives.switched import Part
from .mode import CONSTANT
from .python_callback import Callback
from .traced import known_traces
from .traced.make import made, traced_function


def bind(fun, args, mode, n, near=None, probe=None, refused=None, varying=()):
    """The Bound of ``fun(t, y, *args)`` with the current values.

    Parameters
    ----------
    fun : callable
    args : tuple
    mode : mode.Mode
    n : int
        Length of the compiled function's y.
    near : traced.make.Near, optional
        The region of the first calls; without it, the function is not traced.
    probe : callable, optional
        Called before Numba compiles, to find the user's mistakes in Python.
    refused : str, optional
        The reason why the function must run in Python.
    varying : tuple of int
        The positions of arguments whose values in the block vary between calls.

    Returns
    -------
    Bound
    """

    if isinstance(fun, Part) and (made_of_nodes := fun.bound(mode, n, args)) is not None:
        return made_of_nodes
    keepalive = [fun, args]

    def as_written(t, y):  # `rebind` replaces the content of keepalive
        return keepalive[0](t, y, *keepalive[1])

    try:
        if numpy_errors.are_heard():
            refused = numpy_errors.REASON
        if refused:
            raise Uncompilable(refused)
        if reason := known_traces.left_to_python(fun, args, mode):
            raise FoundLater(reason)
        found, late = budget.within(
            known_traces.place_of(fun, args, mode, n, varying),
            lambda: _code(fun, args, mode, n, near, probe, varying),
            lambda: None if DISABLED else traced_function(fun, args, mode, n, near, varying, False),
        )
        if late is not None:
            return _in_python(as_written, keepalive, mode, n, account=late)
        function, parameters, at = found
        bound = with_code(function, as_written, keepalive, parameters, mode, n, at)
        if not made(function) and near is not None:
            _compare_with_python(bound, near)
        return bound
    except Uncompilable as reason:
        said = None if refused or isinstance(reason, FoundLater) else known_traces.why(
            fun, args, mode, n, varying
        )  # fmt: skip
        said = functools.partial(warn_once, fun, said or str(reason))
        return _in_python(as_written, keepalive, mode, n, said)
    except Exception as error:  # of the function, called by `probe`
        known_traces.forget_refusals(fun, args, mode, error)
        raise


def _compare_with_python(bound, near):
    """Compare Numba's code with the function once for each n; raise FoundLater if they differ."""
    compared = bound.function.notes.setdefault("compared", set())
    if bound.n in compared:
        return
    different = compare_around(bound, near)
    if different:
        leave_to_python(bound, different)
        raise FoundLater(different)
    compared.add(bound.n)


def _code(fun, args, mode, n, near, probe, varying):
    """(Function, (type, value) of each parameter, indices of the arguments among them)."""
    found = None if DISABLED else traced_function(fun, args, mode, n, near, varying)
    if found is None and (reason := known_traces.left_to_python(fun, args, mode)):
        raise FoundLater(reason)
    if found is None and known_traces.acts(fun, args, mode, n, varying):
        raise Uncompilable("it does more than give a value")
    if found is None and not mode.by_numba:
        raise Uncompilable("it cannot be traced, and Numba compiles derivatives and events only")
    if found is None:
        parts = parts_of(fun, args)
        found = *compiled_function(parts, mode, probe), arguments_at(parts)
    return found


def _in_python(as_written, keepalive, mode, n, announce=None, account=None):
    """The Bound of a function that runs in Python, for good or until its code is made."""
    callback = Callback(as_written, mode, n, announce)
    callback.account = account
    callback.raises = lambda error: known_traces.forget_refusals(
        keepalive[0], keepalive[1], mode, error
    )
    return with_callback(callback, as_written, keepalive, mode)


def bind_matrix(matrix):
    """The Bound of a constant Jacobian, an (n, n) array of floats."""
    return Bound(
        constant_function(matrix), constant_block(matrix), lambda t, y: matrix, [matrix], None, [],
        CONSTANT,
    )  # fmt: skip


def arguments_at(parts):
    """The indices of the parameters that are arguments, for a function that Numba compiles."""
    before = parts.positional.index(Y) - 1
    return tuple(range(before, before + len(parts.positional)))


def or_in_python(solve):
    """Call ``solve()``; if compiled code gives up, leave its function to Python and repeat.

    Compiled code gives up, for example, where an integer exceeds 64 bits.
    """
    while True:
        try:
            return solve()
        except GaveUp as reason:
            leave_to_python(reason.bound, reason)


def leave_to_python(bound, reason):
    """Make a function run in Python from now on, for all values; `reason` is text, or a GaveUp."""
    fun, args = bound.keepalive[:2]
    known_traces.leave_to_python(
        fun, args, bound.mode, str(reason), getattr(reason, "wrong", False)
    )
