"""Takes a callable apart: the Python function in it, its `self`, its positional arguments."""

import functools
import inspect
import sys
import types as python
from typing import Any, NamedTuple, TypeGuard

import numpy as np

from fastdyn.code_store.numba_settings import DISABLED

SWITCHED_OFF = "NUMBA_DISABLE_JIT is set"
T, Y = object(), object()  # stand for t and y among the arguments
KEYWORDS = inspect.CO_VARKEYWORDS
EMPTY = python.CellType()


class Uncompilable(Exception):
    """The reason why a function cannot be compiled."""


class Parts(NamedTuple):
    """The Python function of a callable, its `self`, its arguments, its options of `@njit`.

    In `positional`, T and Y stand for t and y; with an `owner`, a first None stands for `self`.
    """

    function: Any
    owner: Any
    positional: tuple
    jitted: bool
    options: dict


def is_jitted(value) -> TypeGuard[Any]:
    """Whether `value` is a Numba dispatcher; without Numba in the process, no value is."""
    module = sys.modules.get("numba.core.dispatcher")
    kind = getattr(module, "Dispatcher", None)
    return kind is not None and isinstance(value, kind)


def parts_of(fun, args):
    """Take a callable apart; raise Uncompilable if it has no Python code."""
    if DISABLED:
        raise Uncompilable(SWITCHED_OFF)
    leading = ()
    keywords = {}
    options = {}
    owner = None
    jitted = False
    if fun.__class__ is not python.FunctionType:
        while isinstance(fun, functools.partial):
            leading = fun.args + leading
            keywords = {**fun.keywords, **keywords}
            fun = fun.func
        if isinstance(fun, python.MethodType):
            fun, owner = fun.__func__, fun.__self__
        if is_jitted(fun):
            jitted = True
            options = {k: v for k, v in fun.targetoptions.items() if k == "fastmath" and v}
            fun = fun.py_func
        if not isinstance(fun, python.FunctionType):
            method = inspect.getattr_static(type(fun), "__call__", None)
            if not isinstance(method, python.FunctionType):
                raise Uncompilable(f"{type(fun).__name__} objects have no Python code to compile")
            fun, owner = method, fun
    code = fun.__code__
    given = (() if owner is None else (None,)) + leading + (T, Y) + args
    if keywords or code.co_kwonlyargcount or code.co_flags & KEYWORDS:
        bound = inspect.signature(fun).bind(*given, **keywords)
        bound.apply_defaults()
        named = code.co_varnames[code.co_argcount : code.co_argcount + code.co_kwonlyargcount]
        if bound.kwargs.keys() - set(named):
            raise Uncompilable("it takes arbitrary keyword arguments (**)")
        given = (*bound.args, *[bound.kwargs[k] for k in named])
    missing = code.co_argcount + code.co_kwonlyargcount - len(given)
    if missing > 0 and fun.__defaults__:
        given += fun.__defaults__[-missing:] if missing <= len(fun.__defaults__) else ()
    return Parts(fun, owner, given, jitted, options)


def plain_function(fun):
    """The innermost Python function of a callable; the innermost object if there is none."""
    while not isinstance(fun, python.FunctionType):
        if isinstance(fun, functools.partial):
            fun = fun.func
        elif isinstance(fun, python.MethodType):
            fun = fun.__func__
        elif isinstance(fun, np.vectorize):
            fun = fun.pyfunc
        elif is_jitted(fun):
            fun = fun.py_func
        else:
            called = inspect.getattr_static(type(fun), "__call__", None)
            if not isinstance(called, python.FunctionType):
                break
            fun = called
    return fun


def codes_of(function):
    """The code of a Python function, and of the functions in its closure."""
    held = [cell.cell_contents for cell in function.__closure__ or () if cell != EMPTY]
    inner = [v.__code__ for v in held if isinstance(v, python.FunctionType)]
    return (function.__code__, *inner)


def code_of(fun):
    """The identity of a callable's code."""
    while isinstance(fun, functools.partial):
        fun = fun.func
    if isinstance(fun, python.MethodType):
        fun = fun.__func__
    fun = fun.py_func if is_jitted(fun) else fun
    return codes_of(fun) if isinstance(fun, python.FunctionType) else (type(fun),)


def codes(fun, args):
    """The identities of the code of a callable and of the callables among its arguments."""
    return (code_of(fun), *[code_of(a) for a in args if callable(a)])
