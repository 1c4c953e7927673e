"""F and event functions as functions of one vector, [y, y'], which the run loop integrates."""

import functools
import types as python
from typing import Any

import numpy as np

from fastdyn.compile.callables import is_jitted


def of_vector(F, n):
    """``residual(t, [y, y'], *args)``: the n numbers of F, and n zeros."""
    F, first, more = _plain(F)
    zeros = np.zeros(n)

    def residual(t, both, *args):
        found = F(*first, t, both[:n], both[n:], *args, **more)
        return np.concatenate((np.asarray(found), zeros))

    return named(residual, F)


def event_of_vector(event, n):
    """An event function of y as one of [y, y']."""
    event, first, more = _plain(event)

    def watched(t, both, *args):
        return event(*first, t, both[:n], *args, **more)

    return named(watched, event)


def named(wrapper, fun):
    """A wrapper with the name of its function, for warnings."""
    for name in ("__name__", "__qualname__", "__module__"):
        setattr(wrapper, name, getattr(fun, name, getattr(wrapper, name)))
    return wrapper


def _plain(fun):
    """(function, first arguments, named arguments) of a callable.

    Compiled code is found by the code of the functions that a wrapper holds: the wrapper of a
    method, partial or object has to hold a function, too.
    """
    first: tuple[Any, ...] = ()
    more: dict[str, Any] = {}
    while True:
        if isinstance(fun, functools.partial):
            first = fun.args + first
            more = {**fun.keywords, **more}
            fun = fun.func
        elif isinstance(fun, python.MethodType):
            first = (fun.__self__, *first)
            fun = fun.__func__
        elif is_jitted(fun):
            fun = fun.py_func
        elif isinstance(type(fun).__call__, python.FunctionType):
            first = (fun, *first)
            fun = type(fun).__call__
        else:
            return fun, first, more
