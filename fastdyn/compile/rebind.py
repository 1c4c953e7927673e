"""Gives new arguments to a bound function, as a prepared solver does at each call."""

import types as python

import numpy as np

from .callables import numpy_errors
from .callables.captured import references, resolve
from .callables.diagnostics import Uncompilable
from .callables.parts import parts_of
from .parameters import pack_all, parameter_type
from .traced import known_traces
from .traced.make import made

UNCHANGING = (  # immutable: the same object has the same value
    float, int, complex, str, bytes, type(None), np.generic, np.ufunc, python.BuiltinFunctionType
)  # fmt: skip


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
    parameters = _same_parameters(bound.seen, fun, args)
    if parameters is None:
        try:
            parts = parts_of(fun, args)
            from .by_numba.make import compiled_function

            found, parameters = compiled_function(parts, bound.mode, None)
        except Uncompilable:
            return False
        if found is not function:
            return False
        _remember(bound.seen, fun, parameters, len(args))
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


def _remember(seen, fun, parameters, n_args):
    """Store the outside values of a plain function, if only assignment can change them."""
    seen.clear()
    if fun.__class__ is not python.FunctionType or fun.__kwdefaults__:
        return
    found = [(r, resolve(r, fun, None)[0]) for r in references(fun, False)]
    values = [*(value for _, value in found), *(fun.__defaults__ or ())]
    if all(isinstance(value, UNCHANGING) for value in values):
        seen["code"], seen["defaults"], seen["outside"] = fun.__code__, fun.__defaults__, found
        seen["types"], seen["rest"] = [k for k, _ in parameters[:n_args]], parameters[n_args:]


def _same_parameters(seen, fun, args):
    """The (type, value) of all parameters, if the stored facts still hold; else None."""
    if fun.__class__ is not python.FunctionType or seen.get("code") is not fun.__code__:
        return None
    if fun.__defaults__ is not seen["defaults"]:
        return None
    for reference, value in seen["outside"]:
        if resolve(reference, fun, None)[0] is not value:
            return None
    parameters = [(parameter_type(value), value) for value in args]
    if [k for k, _ in parameters] != seen["types"]:
        return None
    return parameters + seen["rest"]
