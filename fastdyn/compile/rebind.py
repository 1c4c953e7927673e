"""Gives new arguments to a bound function, as a prepared solver does at each call."""

from .by_numba.function import compiled_function
from .callables import numpy_errors
from .callables.diagnostics import Uncompilable
from .callables.parts import parts_of
from .parameters import pack_all
from .traced import known_traces
from .traced.make import made


def rebind(bound, fun, args):
    """Write new arguments, and the current outside values of the function, into a block.

    `bound` is the result of `bind` for `fun`.  Returns False, with the block unchanged, if the new
    values need other code.
    """
    function = bound.function
    if function is None or bound.mode.constant:
        return function is not None
    if numpy_errors.are_heard() or known_traces.left_to_python(fun, args, bound.mode):
        return False
    known = bound.seen.get("known")
    if known is not None and _read(known, bound, fun, args):
        return True
    found = known_traces.known_trace(
        fun, args, bound.mode, bound.n, batches=known_traces.in_batches(function)
    )
    if found is not None and found[0].function is function:
        bound.seen["known"] = found[0]
        return _read(found[0], bound, fun, args)
    if made(function):
        return False
    try:
        found, parameters = compiled_function(parts_of(fun, args), bound.mode)
    except Uncompilable:
        return False
    if found is not function:
        return False
    bound.keepalive[:] = fun, args, function
    if parameters:
        pack_all(parameters, bound.block, bound.keepalive)
    return True


def _read(known, bound, fun, args):
    """Write the values of a trace into a block; False if the trace does not hold."""
    given = known.read(fun, args, bound.block)
    if given is None:
        return False
    bound.keepalive[:] = fun, args, bound.function, given
    return True
