"""The user's functions -> compiled functions of one known form; their arguments -> parameters.

`bind` takes what the user wrote (function, lambda, method, partial, callable object, already
jitted or not) and the current values of everything it uses, and returns a block that kernels can
call.  What Numba cannot compile is called in Python from the same kernels, with one warning.
"""

import functools
import sys
from typing import Any, NamedTuple

import numpy as np

from fastdyn.code_store.numba_settings import DISABLED
from fastdyn.kernels.calls.block import FAULT, FIRST

from . import budget
from .callables import numpy_errors
from .callables.at_sight import refuse_at_sight
from .callables.compiled import Function
from .callables.diagnostics import FoundLater, GaveUp, LeftToSciPy, Uncompilable, warn_once
from .callables.parts import Y, parts_of
from .compare import compare_around, machine_value
from .derivatives.jacobian_block import constant_block, constant_function
from .mode import CONSTANT, Mode
from .parameters import n_words, pack_all
from .python_callback import Callback, evaluate
from .traced import met
from .traced.find import made, traced_function


class Bound(NamedTuple):
    """A function with the values of one solve, (type, value) each.

    `python(t, y)` is the function as written; of a Pair, `pair` are its two functions; `seen` is
    a place for what `rebind` remembers.
    """

    function: Function | None
    block: np.ndarray
    python: Any
    keepalive: list
    callback: Callback | None
    values: list
    mode: Mode
    pair: tuple = ()
    seen: Any = None
    at: tuple = ()

    def word(self, j):
        """The word of the block at which argument j lies."""
        return FIRST + sum([n_words(k) for k, _ in self.values[: self.at[j]]])


def bind(fun, args, mode, n, near=None, probe=None, refused=None, varying=()):
    """A block to call `fun(t, y, *args)` by, with the values that hold now.

    Parameters
    ----------
    fun : callable
    args : tuple
    mode : mode.Mode
    n : int
        Length of the y that the function gets.
    near : traced.find.Near, optional
        Where it will be called; a function is not traced without.
    probe : callable, optional
        Called before a function is compiled, to find in Python what is wrong with it.
    refused : str, optional
        Why the function must run in Python.
    varying : tuple of int
        The positions of arguments that differ from one call of the block to the next.

    Returns
    -------
    Bound
    """

    keepalive = [fun, args]

    def as_written(t, y):  # for whatever `rebind` was given last
        return keepalive[0](t, y, *keepalive[1])

    try:
        if numpy_errors.are_heard():
            refused = "NumPy's errors are exceptions here (np.errstate, np.seterr)"
        if refused:
            raise Uncompilable(refused)
        if reason := met.left_to_python(fun, args, mode):
            raise FoundLater(reason)
        found, late = budget.within(
            met.place_of(fun, args, mode, n, varying),
            lambda: _code(fun, args, mode, n, near, probe, varying),
        )
        if late is not None:
            return _in_python(as_written, keepalive, mode, n, account=late)
        function, parameters, at = found
        bound = _with_block(function, as_written, keepalive, parameters, mode, n, at)
        if not made(function) and near is not None:
            _compare_with_python(bound, near, n)
        return bound
    except Uncompilable as reason:
        said = None if refused or isinstance(reason, FoundLater) else met.why(
            fun, args, mode, n, varying
        )  # fmt: skip
        said = functools.partial(warn_once, fun, said or str(reason))
        return _in_python(as_written, keepalive, mode, n, said)


def _with_block(function, as_written, keepalive, parameters, mode, n, at):
    """The Bound of a compiled function."""
    end = FIRST + function.n_words
    block = np.zeros(end + n, np.int64)  # the state is kept behind the parameters on a fault
    block[0], block[FAULT] = function.address, end
    if parameters:
        pack_all(parameters, block, keepalive)
    keepalive.append(function)
    return Bound(function, block, as_written, keepalive, None, parameters, mode, (), {}, at)


def _compare_with_python(bound, near, n):
    """Raise Uncompilable where what Numba made is not the function; asked once."""
    compared = bound.function.notes.setdefault("compared", set())
    if n in compared:
        return
    different = compare_around(
        lambda t, y: evaluate(bound.python, bound.mode, t, y),
        lambda t, y: machine_value(bound, t, y), near, n,
    )  # fmt: skip
    if different:
        leave_to_python(bound, different)
        raise FoundLater(different)
    compared.add(n)


def _code(fun, args, mode, n, near, probe, varying):
    """The compiled function, (kind, value) of its parameters, and which are arguments."""
    found = None if DISABLED else traced_function(fun, args, mode, n, near, varying)
    if found is None and mode.complex_numbers:
        raise LeftToSciPy
    if found is None and met.acts(fun, args, mode, n, varying):
        raise Uncompilable("it does more than give a value")
    if found is None and not mode.by_numba:
        raise Uncompilable("it cannot be traced, and Numba compiles derivatives and events only")
    if found is None:
        parts = parts_of(fun, args)
        refuse_at_sight(parts)
        if "numba" not in sys.modules:
            budget.not_here()  # it is not imported in a moment
        from .by_numba.find import compiled_function

        found = *compiled_function(parts, mode, probe), arguments_at(parts)
    return found


def _in_python(as_written, keepalive, mode, n, announce=None, account=None):
    """A function that stays in Python, for good or until its code is made."""
    callback = Callback(as_written, mode, n, announce)
    callback.account = account
    block = np.zeros(FIRST, np.int64)
    block[0] = callback.address
    return Bound(None, block, as_written, [*keepalive, callback], callback, [], mode)


def bind_matrix(matrix):
    """A constant Jacobian, (n, n) floats, as a Bound."""
    return Bound(
        constant_function(matrix), constant_block(matrix), lambda t, y: matrix, [matrix], None, [],
        CONSTANT,
    )  # fmt: skip


def arguments_at(parts):
    """Among the parameters of a function that Numba compiles, those of its arguments."""
    before = parts.positional.index(Y) - 1
    return tuple(range(before, before + len(parts.positional)))


def or_in_python(solve):
    """``solve()``, repeated with a function left to Python where its code is not the function.

    A whole number grew beyond 64 bits, a matrix has complex eigenvalues: Python goes on.
    """
    while True:
        try:
            return solve()
        except GaveUp as reason:
            leave_to_python(reason.bound, str(reason))


def leave_to_python(bound, reason):
    """Let a function run in Python from now on, whatever values it gets."""
    fun, args = bound.keepalive[:2]
    met.leave_to_python(fun, args, bound.mode, reason)
