"""The arguments of a call from another library: what varies, and what is fixed.

What varies are the arrays of the library among y0 and args.  Numbers of Python and arrays of NumPy
are fixed, and all the rest: a derivative through anything else would be lost without a word.
"""

import dis
import functools
import math
import types
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from fastdyn.problem import schedules, validate
from fastdyn.problem.options.table import check_kinds

from .call import Call, Fixed
from .outputs import Shapes
from .trees import apart

OWN = (  # options without a meaning here
    "dense_output", "vectorized", "sensitivity", "adjoint", "error_estimate", "checkpoint",
    "callback", "on_interrupt",
)  # fmt: skip
HIDDEN = (
    "{} is {}: derivatives by it would be lost.  Only y0 and args may vary: give it as an argument "
    "of `fun` in `args`."
)

GLOBAL = {"LOAD_GLOBAL", "LOAD_NAME"}


class Library(NamedTuple):
    """The arrays of another library: how they are told, and made.

    Attributes
    ----------
    name : str
    holds : callable
        Whether a value is an array of the library.
    varies : callable
        Whether derivatives by an array may be asked for, or its value is not known yet.
    dtype : callable
        The name of the type of the numbers of an array.
    joined : callable
        One array of a sequence of numbers and arrays.
    shape : callable
        The shape of an array; None for an unknown length.
    float64, shaped : str
        How one makes an array of float64, and one of known shape.
    """

    name: str
    holds: Callable
    varies: Callable
    dtype: Callable
    joined: Callable
    shape: Callable
    float64: str
    shaped: str = ""


def call_of(
    library, fun, t_span, y0, method, t_eval, events, args, occurrences, options
) -> tuple[Call, list]:
    """The Call of checked arguments, and the arrays of the library that it is called with."""
    validate.function(fun)
    for name in OWN:
        if name in options:
            raise TypeError(f"`{name}` is no option of fastdyn.{library.name.lower()}.solve_ivp.")
    for name, value in {"t_span": t_span, "t_eval": t_eval, **options}.items():
        _refuse_hidden(library, f"`{name}`", value)
    check_kinds(options)
    if not (isinstance(method, str) and method == "auto"):
        validate.method_named(method, automatic=True)
    t0, tf = validate.time_span(t_span)
    if not math.isfinite(tf):
        raise ValueError(f"`t_span` ends at {tf}: derivatives need a finite span.")
    times: Any = validate.output_times([tf] if t_eval is None else t_eval, t0, tf)
    if not len(times):
        raise ValueError("`t_eval` is empty: there is nothing to return.")
    schedules.checked(events, options, t0, tf)
    watched = schedules.listed(events, options) or []
    for each in (fun, *watched, *[o for option in options.values() for o in _items(option)]):
        if callable(each):
            _refuse_outside(library, each)
    if occurrences.__class__ is not int or occurrences < 1:
        raise ValueError(f"`occurrences` must be a whole number above 0; got {occurrences!r}.")
    held = apart(_arguments(library, args), library.holds, rows=True)
    if any(held.trees):
        fun = held.function(fun)
        events = [held.event(each) for each in schedules.listed(events, {}) or ()]
        _refuse_functions(options)
    given = (_state(library, y0), *held.leaves)
    places = tuple([i for i, value in enumerate(given) if library.holds(value)])
    varying = [given[i] for i in places]
    for i, value in zip(places, varying, strict=True):
        _refuse_type(library, _name(i), value)
    constants = []
    for i, value in enumerate(given):
        own = None if i in places else value
        _refuse_hidden(library, _name(i), own)
        constants.append(own.copy() if isinstance(own, np.ndarray) else own)
    (n,) = _shape(library, "`y0`", given[0])
    shapes = Shapes(n, len(times), len(watched), occurrences)
    inputs = tuple([_shape(library, _name(i), v) for i, v in zip(places, varying, strict=True)])
    fixed = Fixed(fun, (t0, tf), method, times, events, options)
    return Call(fixed, shapes, tuple(constants), places, inputs), varying


def _refuse_functions(options):
    """Refuse functions among options, which would get the numbers of a container side by side."""
    for name, value in options.items():
        if any(callable(each) for each in _items(value)):
            raise TypeError(
                f"`{name}` is a function, and `args` holds arrays in a dict, a list, a NamedTuple "
                "or a dataclass: give them as arguments of their own."
            )


def _arguments(library, args):
    if library.holds(args):
        raise TypeError("`args` must be a tuple, args=(k,); got an array.")
    return validate.extra_arguments(args)


def _name(i):
    return "`y0`" if i == 0 else f"`args[{i - 1}]`"


def _state(library, y0) -> Any:
    """y0 as an array of the library if a part of it is one, else of NumPy."""
    if isinstance(y0, list | tuple) and any(library.holds(each) for each in y0):
        for i, each in enumerate(y0):
            if library.holds(each):
                _refuse_type(library, f"`y0[{i}]`", each)
        y0 = library.joined(y0)
    if not library.holds(y0):
        found = validate.initial_state(y0)
        if found.dtype.kind == "c":
            raise TypeError("`y0` is complex: there are derivatives of real states only.")
        shape = found.shape
    else:
        found = y0
        shape = library.shape(y0)
    if len(shape) != 1 or shape[0] == 0:
        raise ValueError(f"`y0` must have one dimension, and components; got shape {shape}.")
    return found


def _shape(library, name, value):
    """The shape of an array, which must be known."""
    shape = library.shape(value) if library.holds(value) else value.shape
    if None in shape:
        raise ValueError(f"The shape of {name} must be known, and is {shape}: {library.shaped}")
    return tuple(map(int, shape))


def _refuse_type(library, name, value):
    found = library.dtype(value)
    if found == "float64":
        return
    if found.startswith("float") or found.startswith("bfloat"):
        raise TypeError(f"{name} is of {found}; fastdyn computes in float64: {library.float64}")
    if found.startswith("complex"):
        raise TypeError(
            f"{name} is of {found}: there are derivatives by real numbers only. Give real and "
            "imaginary parts as numbers of their own."
        )
    raise TypeError(
        f"{name} is of {found}, and has no derivatives: {library.float64}  What is to stay a whole "
        "number is given as a number of Python or an array of NumPy."
    )


def _refuse_hidden(library, name, value, depth=2):
    """Refuse an array whose derivatives would be lost, also inside of a container."""
    if library.holds(value):
        if library.varies(value):
            raise TypeError(HIDDEN.format(name, f"an array of {library.name} that varies"))
    elif depth and isinstance(value, dict):
        for each in value.values():
            _refuse_hidden(library, name, each, depth - 1)
    elif depth and isinstance(value, list | tuple | set):
        for each in value:
            _refuse_hidden(library, name, each, depth - 1)


def _refuse_outside(library, function):
    """Refuse a function that uses an array of the library from outside of its arguments."""
    called = getattr(function, "__name__", "fun")
    for name, value in _outside(function, set()):
        if _is_of(library, value):
            raise TypeError(
                f"`{called}` uses `{name}`, the module {value.__name__}: fastdyn compiles "
                "functions that are written with NumPy and Python's own operations, np.sin for "
                f"{name}.sin."
            )
        said = f"`{name}`, which `{called}` takes from outside,"
        if library.holds(value):
            raise TypeError(HIDDEN.format(said, f"an array of {library.name}"))
        _refuse_hidden(library, said, value)


def _is_of(library, value):
    """Whether a value is a module of the library."""
    root = getattr(value, "__name__", "").partition(".")[0]
    return isinstance(value, types.ModuleType) and root == library.name.lower()


def _outside(function, seen):
    """Pairs (name, value) of what a function takes from outside of its arguments."""
    if isinstance(function, functools.partial):
        yield from [(f"argument {i}", value) for i, value in enumerate(function.args)]
        yield from function.keywords.items()
        yield from _outside(function.func, seen)
        return
    owner = getattr(function, "__self__", None)
    if owner is None and not hasattr(function, "__code__"):  # an object that can be called
        owner = function
        function = vars(type(function)).get("__call__")
    function = getattr(function, "__func__", function)
    if not isinstance(function, types.FunctionType) or function in seen:
        return
    seen.add(function)
    values = [*getattr(owner, "__dict__", {}).items(), *_names(function)]
    yield from values
    for _, value in values:
        of_user = getattr(value, "__globals__", None) is function.__globals__
        if of_user or getattr(value, "__closure__", None) or isinstance(value, functools.partial):
            yield from _outside(value, seen)


def _names(function):
    """Pairs (name, value) of closure variables, defaults and globals of a function."""
    code = function.__code__
    found = []
    for name, cell in zip(code.co_freevars, function.__closure__ or (), strict=True):
        try:
            found.append((name, cell.cell_contents))
        except ValueError:  # not yet defined
            continue
    defaults = function.__defaults__ or ()
    positional = code.co_varnames[: code.co_argcount]
    found += zip(positional[len(positional) - len(defaults) :], defaults, strict=True)
    found += (function.__kwdefaults__ or {}).items()
    known = function.__globals__
    return found + [(name, known[name]) for name in _globals_of(code) if name in known]


@functools.lru_cache(1024)
def _globals_of(code):
    """The names of the globals that a code and the codes within it read."""
    found = {each.argval for each in dis.get_instructions(code) if each.opname in GLOBAL}
    for each in code.co_consts:
        if isinstance(each, types.CodeType):
            found |= _globals_of(each)
    return frozenset(found)


def _items(value) -> Any:
    return value if isinstance(value, list | tuple) else [value]
