"""Binds functions: compiled code for the function, and a block with its parameters.

`bind` takes a function as the user wrote it (function, lambda, method, partial, callable object,
jitted or not) and the current values that the function uses.  `bind` returns a Bound; kernels call
the function by the block of the Bound.  A function that cannot be compiled is called in Python
from the same kernels, after one warning.
"""

import functools
from typing import Any

import numpy as np
from numpy._core import umath

from fastdyn.code_store.numba_settings import DISABLED

from . import budget
from .by_numba.function import compiled_function
from .callables import Uncompilable, Y, parts_of
from .compare import compare_around
from .derivatives.jacobian_block import constant_block, constant_function
from .derivatives.switched import Part
from .functions import BASE, Bound, with_callback, with_code
from .mode import CONSTANT
from .parameters import pack_all
from .python_callback import Callback, Held
from .remembered import warn_if_remembered
from .sentences import FoundLater, GaveUp, name_of, warn_once
from .traced.known import Attempt
from .traced.make import made, traced_function

# NumPy's error state, which not all versions have; each new setting is a new object.
_errors: Any = getattr(umath, "_extobj_contextvar", None)
current_errors: Any = object if _errors is None else _errors.get
USUAL_ERRORS = current_errors()
NUMPY_ERRORS = "NumPy's errors are exceptions here (np.errstate, np.seterr)"


def numpy_errors_are_heard():
    """Whether NumPy reports errors; functions then run in Python, as compiled code reports none."""
    if current_errors() is USUAL_ERRORS:
        return False
    return not {"ignore", "warn"}.issuperset(np.geterr().values())


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
    held = Held(fun, args)

    def as_written(t, y):  # of what `rebind` lets it hold
        return held.fun(t, y, *held.args)

    as_written.of = held  # pyright: ignore
    attempt = Attempt(fun, args, mode, n, varying)
    try:
        if numpy_errors_are_heard():
            refused = NUMPY_ERRORS
        if refused:
            raise Uncompilable(refused)
        if reason := attempt.left.reason:
            raise FoundLater(reason)
        found, late = budget.within(
            attempt.place(),
            lambda: _code(attempt, near, probe),
            lambda: None if DISABLED else traced_function(attempt, near, makes=False),
            name_of(fun),
        )
        if late is not None:
            return _in_python(as_written, held, mode, n, account=late)
        function, parameters, at = found
        bound = with_code(function, as_written, held, parameters, mode, n, at)
        if not made(function) and near is not None:
            _compare_with_python(bound, near)
        return bound
    except Uncompilable as reason:
        said = None if refused or isinstance(reason, FoundLater) else attempt.why()
        said = functools.partial(warn_once, fun, said or str(reason))
        if mode.argument == "fun":
            warn_if_remembered(fun)
        return _in_python(as_written, held, mode, n, said)
    except Exception as error:  # of the function, called by `probe`
        attempt.forget_refusals(error)
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


def _code(attempt, near, probe):
    """(Function, (type, value) of each parameter, indices of the arguments among them)."""
    found = None if DISABLED else traced_function(attempt, near)
    if found is not None:
        return found
    if reason := attempt.left.reason:
        raise FoundLater(reason)
    if attempt.facts().acts:
        raise Uncompilable("it does more than give a value")
    if getattr(attempt.fun, "only_traced", False):  # it reads the past, which Numba does not know
        raise Uncompilable(attempt.facts().refusal or "it cannot be traced")
    if not attempt.mode.by_numba:
        raise Uncompilable("it cannot be traced, and Numba compiles derivatives and events only")
    parts = parts_of(attempt.fun, attempt.args)
    return *compiled_function(parts, attempt.mode, probe), arguments_at(parts)


def _in_python(as_written, held, mode, n, announce=None, account=None):
    """The Bound of a function that runs in Python, for good or until its code is made."""
    callback = Callback(as_written, mode, n, announce)
    callback.account = account
    callback.raises = lambda error: Attempt(held.fun, held.args, mode, n).forget_refusals(error)
    return with_callback(callback, as_written, held, mode)


def rebind(bound, fun, args):
    """Write new arguments, and the current outside values of the function, into a block.

    `bound` is the result of `bind` for `fun`.  Returns False, with the block unchanged, if the new
    values need other code.
    """
    function = bound.function
    if function is None or bound.mode.constant:
        return function is not None
    mode = bound.mode
    n = bound.n
    varying = ()
    base = function.notes.get(BASE, function)
    if base is not function:
        fun, mode, n, varying = fun.as_traced()
    attempt = Attempt(fun, args, mode, n, varying)
    if numpy_errors_are_heard() or attempt.left.reason:
        return False
    known = bound.seen.get("known")
    if known is not None and _read(known, bound, fun, args):
        return True
    found = attempt.known(function.in_batches)
    if found is not None and found[0].function is base:
        bound.seen["known"] = found[0]
        return _read(found[0], bound, fun, args)
    if base is not function or made(function):
        return False
    try:
        found, parameters = compiled_function(parts_of(fun, args), bound.mode)
    except Uncompilable:
        return False
    if found is not function:
        return False
    bound.held.take(fun, args)
    if parameters:
        pack_all(parameters, bound.block, bound.held.memory)
    return True


def _read(known, bound, fun, args):
    """Write the values of a trace into a block; False if the trace does not hold."""
    given = known.read(fun, args, bound.block)
    if given is None:
        return False
    bound.held.take(fun, args, given)
    return True


def bind_matrix(matrix):
    """The Bound of a constant Jacobian, an (n, n) array of floats."""
    return Bound(
        constant_function(matrix), constant_block(matrix), lambda t, y: matrix, Held(matrix), None,
        [], CONSTANT,
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
    held = bound.held
    attempt = Attempt(held.fun, held.args, bound.mode, bound.n)
    attempt.leave(str(reason), getattr(reason, "wrong", False))
