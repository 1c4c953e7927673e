"""The user's functions -> compiled functions of one known form; their arguments -> parameters.

`bind` takes what the user wrote (function, lambda, method, partial, callable object, already
jitted or not) and the current values of everything it uses, and returns a block that kernels can
call.  What Numba cannot compile is called in Python from the same kernels, with one warning.
"""

import functools
import types as python
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.core.compiler import Compiler as NumbaCompiler
from numba.core.dispatcher import Dispatcher
from numba.core.registry import CPUDispatcher

from fastdyn import code_store
from fastdyn.compile.ir.rewrite import Plan, compile_with
from fastdyn.kernels.calls.user_function import FAULT, FIRST, FORM
from fastdyn.kernels.jit_options import BARE, njit

from .captured import (
    LIBRARIES,
    TUPLES,
    calls_itself,
    code_token,
    contains_opaque,
    frozen,
    of_library,
    outside_kind,
    references,
    resolve,
)
from .diagnostics import GaveUp, Uncompilable, explain, warn_once
from .entry_point import arguments, pointer_form, reader
from .parameters import MOMENTS, Constant, is_function, kind, n_words, pack
from .python_callback import Callback
from .unwrap import T, Y, parts_of

INLINED = {"forceinline": True}
CHECKED = {"boundscheck": True, **INLINED}  # indices, where an exception can be reported
NUMPY = ("numpy", "np")  # and a library under its own name: the code itself says what is meant
DERIVATIVE = (("derivative", True), ("derivative", False), ("copy", False))
MODES = {  # how a function may be compiled, best first: (mode, returned lists become tuples)
    "derivative": DERIVATIVE,
    "velocity": DERIVATIVE,
    "force": DERIVATIVE,
    "column": (("column", False),),
    "acceleration": (("acceleration", True), ("acceleration", False)),
    "event": (("event", True),),
    **{mode: ((mode, True), (mode, False)) for mode in MOMENTS},
}


class Function(NamedTuple):
    """A compiled function of the user; `key` is None if only this process can identify it.

    `build` makes the dispatcher of its pointer form, `on_vectors` what `taken_in` does.
    """

    key: str | None
    address: Any
    n_words: int
    build: Any
    alive: Any
    mode: str = ""
    on_vectors: Any = None


class Bound(NamedTuple):
    """A function with the values of one solve, (kind, value) each.

    `python(t, y)` is the function as written; a pair has its two functions in `parts`; `seen` is
    a place for what `rebind` remembers.
    """

    function: Function | None
    block: np.ndarray
    python: Any
    alive: list
    callback: Callback | None
    values: list
    mode: str
    parts: tuple = ()
    seen: Any = None


_functions: dict = {}
_not_lifted: set = set()
_refused: dict = {}
_called: dict = {}


def _outside(function, owner):
    """{path: (kind, value)} of everything the function refers to, but for what libraries hold."""
    lifted = id(function.__code__) not in _not_lifted
    found = {}
    for reference in references(function, owner is not None):
        if reference.root == "global":
            root = function.__globals__.get(reference.name)
            if root.__class__ is python.ModuleType and root.__name__ in LIBRARIES:
                if root.__name__ != reference.name and (root.__name__, reference.name) != NUMPY:
                    found[reference] = (Constant(("module", root.__name__), root), root)
                continue
        elif reference.root == "self" and not reference.attributes:
            continue
        value, depth = resolve(reference, function, owner)
        path = reference._replace(attributes=reference.attributes[:depth])
        if path not in found:
            k = outside_kind(value) if lifted else Constant(frozen(value), value)
            found[path] = (k, value)
    return found


def bind(fun, args, mode, n, look=None, refused=None):
    """A block to call `fun(t, y, *args)` by, with the values that hold now.

    Parameters
    ----------
    fun : callable
    args : tuple
    mode : str
        "derivative", "column" (`vectorized=True`), "acceleration", "event", one of
        MOMENTS, or "velocity" and "force", the two halves of a derivative.
    n : int
        Length of the y that the function gets.
    look : callable, optional
        Called before a function is compiled, to find in Python what is wrong with it.
    refused : str, optional
        Why the function must run in Python.

    Returns
    -------
    Bound
    """

    alive = [fun, args]

    def as_written(t, y):
        return fun(t, y, *alive[1])

    try:
        if refused:
            raise Uncompilable(refused)
        parts = parts_of(fun, args)
        function, kinds = compiled_function(parts, mode, look)
    except Uncompilable as reason:
        callback = Callback(as_written, mode, n, functools.partial(warn_once, fun, str(reason)))
        block = np.zeros(FIRST, np.int64)
        block[0] = callback.address
        return Bound(None, block, as_written, [*alive, callback], callback, [], mode)
    end = FIRST + function.n_words
    block = np.zeros(end + n, np.int64)  # the state is kept behind the parameters on a fault
    block[0], block[FAULT] = function.address, end
    if kinds:
        pack_all(kinds, block, alive)
    alive.append(function)
    return Bound(function, block, as_written, alive, None, kinds, mode, (), {})


def or_in_python(solve):
    """``solve()``, repeated with a function left to Python where it raised only when compiled.

    A whole number grew beyond 64 bits, a matrix has complex eigenvalues: Python goes on.
    """
    while True:
        try:
            return solve()
        except GaveUp as reason:
            leave_to_python(reason)


def leave_to_python(reason):
    """Let the function that gave up run in Python from now on, and say so when it is bound."""
    function = reason.bound.function
    keys = [key for key, (known, _) in _functions.items() if known is function]
    if not keys:
        raise RuntimeError(f"{reason}, and there is no Python form of it.")
    for key in keys:
        _refused[key] = (str(reason), _functions.pop(key)[1])


def pack_all(kinds, block, alive):
    """Write all parameters, (kind, value) each, into a block."""
    at, floats = FIRST, block.view(np.float64)
    for k, value in kinds:
        at = pack(k, value, block, floats, at, alive)


def compiled_function(parts, mode, look):
    """The compiled function, and (kind, value) of each of its parameters in order."""
    code = parts.function.__code__
    layout, outside = described(parts)
    kinds = tuple([(path, k) for path, (k, _) in outside.items()])
    key = (id(code), mode, layout, kinds, tuple(parts.options.items()))
    entry = _functions.get(key)
    if entry is None:
        if key in _refused:
            raise Uncompilable(_refused[key][0])
        if look is not None:
            look()
        try:
            function = _compile(parts, mode, layout, outside)
        except Uncompilable as reason:
            if id(code) not in _not_lifted and any(n_words(k) for _, k in kinds):
                _not_lifted.add(id(code))
                try:
                    return compiled_function(parts, mode, None)
                except Uncompilable:
                    pass
            _refused[key] = (str(reason), code)  # the code, to keep its id taken
            raise
        entry = _functions[key] = (function, code)
    given = zip(layout, parts.positional, strict=True)
    values = [pair for pair in given if pair[0].__class__ is not str]  # neither t nor y
    return entry[0], [*values, *outside.values()] if outside else values


def described(parts):
    """Kinds of the positional arguments ("t" and "y" among them), and {path: (kind, value)}."""
    layout = tuple(
        ["t" if v is T else "y" if v is Y else kind(v, frozen) for v in parts.positional]
    )
    try:
        return layout, _outside(parts.function, parts.owner)
    except Exception as error:
        raise Uncompilable(explain(error)) from error


def identity(parts, mode, layout, outside):
    """What tells a compiled function from every other one; None if only this process can."""
    token = (mode, layout, tuple((p, k) for p, (k, _) in outside.items()), parts.options)
    if calls_itself(token):
        raise Uncompilable("it calls itself, and compiled code would not stop at any depth")
    if contains_opaque((layout, tuple(k for k, _ in outside.values()))):
        return None
    code = parts.function.__code__
    return repr((frozen(code.co_name), code_token(code), token))


def _compile(parts, mode, layout, outside):
    name = identity(parts, mode, layout, outside)
    reasons = []
    dialects = MODES[mode]
    for fresh in (False, True):  # first what is on disk, in any dialect
        for dialect in dialects:
            key = name and repr((name, dialect))
            build = functools.partial(_build, parts, dialect, layout, outside)
            try:
                compiled = (
                    code_store.compiled(key, lambda b=build: (b(), types.none(*FORM)), kernel=False)
                    if fresh
                    else (key and code_store.stored(key))
                )
            except Exception as error:
                reasons.append(explain(error))
                continue
            if compiled:
                size = words_of(layout) + words_of([k for k, _ in outside.values()])
                vectors = functools.partial(taken_in, parts, layout, outside, True, INLINED)
                return Function(
                    key, compiled.address, size, functools.cache(build), compiled, mode, vectors
                )
    raise Uncompilable(reasons[0])


def _build(parts, dialect, layout, outside):
    """The dispatcher of the pointer form."""
    mode, tuples = dialect
    return pointer_form(*taken_in(parts, layout, outside, tuples, CHECKED), mode)


def words_of(kinds):
    """Words of a block that parameters of these kinds take; "t" and "y" take none."""
    return sum([n_words(k) for k in kinds if k.__class__ is not str])


def taken_in(parts, layout, outside, tuples, options):
    """The user's function as a dispatcher, and what makes its arguments; see `pointer_form`."""
    at = FIRST + words_of(layout)
    loads = {}
    for path, (k, _) in outside.items():
        if not isinstance(k, Constant):
            loads[path] = reader(k, at)
            at += n_words(k)
    plan = Plan(parts.function, parts.owner, loads, True, tuples)
    ready = [
        Constant(k.token, called_function(k.value))
        if isinstance(k, Constant) and is_function(k.value)
        else k
        for k in layout
    ]
    return compile_with(plan, {**parts.options, **options}), arguments(ready, FIRST)


def called_function(value: Any):
    """The compiled form of a function that a user's function calls; None if it is not one.

    A jitted function is compiled anew: its own machine code may be of other values of its globals,
    or from Numba's cache, where the names of helpers are not unique.
    """
    owner, options, signatures = None, {"boundscheck": True}, ()
    if type(value) is CPUDispatcher and value._compiler.pipeline_class is NumbaCompiler:  # pyright: ignore
        options = {"error_model": "python", **value.targetoptions}
        options = {k: v for k, v in options.items() if k != "nopython"}
        if not value._can_compile:  # pyright: ignore
            signatures = value.nopython_signatures
        dispatcher, value = value, value.py_func
        if of_library(value):
            return dispatcher
    elif isinstance(value, Dispatcher):
        return value
    if isinstance(value, python.MethodType) and not isinstance(value.__self__, type):
        value, owner = value.__func__, value.__self__
    if not isinstance(value, python.FunctionType):
        return None
    if of_library(value):
        return None
    tuples = hasattr(value, TUPLES)
    token = frozen(value if owner is None else python.MethodType(value, owner))
    token = (token, tuples, repr(sorted(options.items())), signatures)
    if token in _called:
        return _called[token]
    compiled = compile_with(Plan(value, owner, {}, False, tuples), options)
    for signature in signatures:
        compiled.compile(signature)
        compiled.disable_compile()
    if owner is not None:
        inner = compiled
        compiled = njit(**BARE)(lambda *given: inner(None, *given))
    if not contains_opaque(token):
        _called[token] = compiled
    return compiled
