"""The objects that replace library functions during a trace, and objects that a trace refuses."""

import builtins
import cmath
import functools
import inspect
import logging
import math
import sys
import types
from collections.abc import Iterator, ValuesView
from typing import Any

import numpy as np
from numpy._core import multiarray

from ..graph.refusal import LATEST, OutOfTime, Refusal
from ..symbols.lift import symbol
from ..symbols.masks import WHY, Masked
from ..symbols.symbol import HANDLERS, NOW, Symbol, graph_of, is_symbolic, of_numpy, refuse
from . import algebra, arrays, linear_systems, scipy, sequences
from .arrays import INDEXED, MAKERS, STRUCTURE, structured
from .objects import plain_of, wrapped
from .python import BISECT, BUILTINS, CMATH, MATH, impure, vectorized
from .source import Sources

PURE = set(
    "numpy scipy builtins math cmath numba operator _operator functools _functools itertools "
    "collections numbers abc types typing copy enum dataclasses fractions statistics string re "
    "bisect".split()
)
IMPURE = (set(sys.stdlib_module_names) - PURE) | {"matplotlib", "pandas", "tqdm", "IPython"}
FUNCTIONS: dict[Any, Any] = {
    **arrays.FUNCTIONS, **algebra.FUNCTIONS,
    **linear_systems.FUNCTIONS, **sequences.FUNCTIONS,
}  # fmt: skip
WITHOUT_EFFECT = {"device", "like", "optimize", "subok"}  # on the numbers
OF_MASKED = {np.piecewise, np.copyto, np.asarray, np.asanyarray}
OF_FILES = set("save savez savez_compressed savetxt load loadtxt genfromtxt fromfile".split())
REFUSED = set(
    "array2string array_str array_repr may_share_memory shares_memory put place putmask "
    "put_along_axis asarray_chkfinite extract".split()
)


def call_function(function, args, kwargs):
    """Call a function of NumPy or SciPy whose arguments may hold symbols."""
    if "dtype" in kwargs:
        kwargs["dtype"] = _plain_type(kwargs["dtype"])
    if kwargs.get("copy") is np._CopyMode.IF_NEEDED:  # of SciPy's forms of NumPy's functions
        kwargs["copy"] = None
    args = tuple([list(a) if isinstance(a, Iterator | ValuesView) else a for a in args])
    args = tuple(map(_plain_type, args))
    values = [*args, *kwargs.values()]
    if any(type(a) is Masked for a in values) and function not in OF_MASKED:
        if not isinstance(function, np.ufunc):
            refuse(WHY)
    if isinstance(function, np.ufunc):
        lists = [isinstance(a, list | tuple) and is_symbolic(a) for a in args]
        g = graph_of(*args)
        args = [symbol(g, a) if is_list else a for a, is_list in zip(args, lists, strict=True)]
        return function(*args, **kwargs)
    if not is_symbolic(values):
        return wrapped(function(*plain_of(args), **plain_of(kwargs)))
    if function.__name__ in REFUSED:
        refuse(f"np.{function.__name__} of what depends on the state")
    if function in STRUCTURE:
        return structured(function, args, kwargs)
    own = FUNCTIONS.get(function) or scipy.written_out(function)
    if function in FUNCTIONS and (taken := _options(own)):
        strange = [name for name in kwargs if name not in taken | WITHOUT_EFFECT]
        if strange and _vary(args, kwargs):
            refuse(f"np.{function.__name__} with {strange[0]}")
        if strange:
            return _other(function, args, kwargs)
        kwargs = {name: value for name, value in kwargs.items() if name in taken}
    source: Any = None if own else SOURCES.of(function)
    if source is function:
        return _other(function, args, kwargs)
    before = LATEST.refusal
    raising = NOW.g.raising
    try:
        found = (own or source)(*args, **kwargs)
    except OutOfTime:
        raise
    except (Refusal, TypeError, AttributeError) as error:  # C code raises TypeError on symbols
        if isinstance(error, Refusal) and _vary(args, kwargs):
            raise
        LATEST.refusal = before
        NOW.g.raising = raising
        return _other(function, args, kwargs)
    if source or function in MAKERS or function in arrays.TYPED:
        return found
    return laid_out(function, args, kwargs, found)


@functools.cache
def _options(stand_in):
    """The names of the arguments that a stand-in takes; empty if the stand-in passes all on."""
    parameters = inspect.signature(stand_in).parameters.values()
    if any(parameter.kind is parameter.VAR_KEYWORD for parameter in parameters):
        return frozenset()
    return frozenset(parameter.name for parameter in parameters)


def _other(function, args, kwargs):
    """A function without a form, on constants."""
    if _vary(args, kwargs):
        refuse(f"it calls {function.__name__}")
    return wrapped(function(*plain_of(args), **plain_of(kwargs)))


def _vary(*values):
    return any(s.varies for s in symbols_in(values))


def symbols_in(value):
    """The symbols in a value."""
    if type(value) is Symbol:
        yield value
    elif isinstance(value, list | tuple | dict):
        for each in value.values() if isinstance(value, dict) else value:
            yield from symbols_in(each)


# -- the order in memory


def laid_out(function, args, kwargs, result):
    """Lay out the matrices of a result as NumPy's `function` does.

    The function is called with arrays of ones, which lie in memory as the arguments do.  Refuses a
    result that is a view of an argument where NumPy's result is none, and the reverse.
    """
    given = [s for s in symbols_in([args, kwargs]) if s.many and s.ids.ndim > 1]
    if function is not np.einsum and all(s.ids.flags.c_contiguous for s in given):
        return result
    try:
        with np.errstate(all="ignore"):
            trial = function(*map(_ones, args), **{k: _ones(v) for k, v in kwargs.items()})
    except Exception:
        refuse(f"the order in memory of what {function.__name__} gives")
    mine, theirs = ([v] if not isinstance(v, list | tuple) else list(v) for v in (result, trial))
    found = [_moved(a, b) for a, b in zip(mine, theirs, strict=True)]
    return found[0] if not isinstance(result, list | tuple) else type(result)(found)


def _moved(mine, theirs):
    if type(mine) is not Symbol or not mine.many or mine.ids.ndim < 2:
        return mine
    moved = np.empty_like(theirs, mine.ids.dtype)
    moved[...] = mine.ids
    return mine.view_of(moved)


def _ones(value):
    if type(value) is Symbol:
        return np.ones_like(value.ids, value.dtype) if value.many else 1.0
    return type(value)([_ones(v) for v in value]) if isinstance(value, list | tuple) else value


# -- stand-ins


class LibraryFunction:
    """A library function that accepts lists of symbols and returns arrays that can hold symbols."""

    def __init__(self, function):
        self._function = function

    def __call__(self, *args, **kwargs):
        return call_function(self._function, args, kwargs)

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._function, name)


def _plain_type(value) -> Any:
    """The original of a type that has a stand-in; any other value unchanged."""
    return getattr(value, "plain", value) if isinstance(value, type) else value


class Forbidden:
    """An object that refuses every use, because a use has side effects or gives other results."""

    def __init__(self, name):
        object.__setattr__(self, "_why", f"it uses {name}")

    def _refused(self, *_, **__) -> Any:
        refuse(self._why, final=True, effect=True, alive="weakref" in self._why)

    __getattr__ = __iter__ = __next__ = __call__ = __getitem__ = __enter__ = _refused
    __setattr__ = __setitem__ = __bool__ = __len__ = __eq__ = __contains__ = __iter__
    __hash__ = object.__hash__


class Quiet:
    """A user's logger; it refuses a call that writes to the log."""

    def __init__(self, logger):
        self._logger = logger

    def __getattr__(self, name):
        level = logging.getLevelNamesMapping().get(name.upper())
        if level is None or self._logger.isEnabledFor(level):
            refuse("it writes to a log", effect=True)
        return lambda *_, **__: None


def _broadcast(*values):
    return np.broadcast(*[arrays.array_of(v).ids for v in values])


def _error_state(**how):
    """np.errstate."""
    if not {"ignore", "warn", None}.issuperset(how.values()):
        refuse("NumPy's errors as exceptions", final=True)
    return np.errstate(**how)


def _seterr(*_, **__):
    refuse("it changes how NumPy treats errors", effect=True)


def _geterr(*_, **__):
    refuse("it asks how NumPy treats errors", final=True)


STAND_INS: dict[int, Any] = {
    id(getattr(module, name)): LibraryFunction(function)
    for module in (np, np.linalg, np.fft)
    for name, function in vars(module).items()
    if callable(function) and not isinstance(function, type) and name[0] != "_"
}
STAND_INS |= INDEXED
STAND_INS[id(np.broadcast)] = _broadcast
STAND_INS |= dict.fromkeys(
    (id(multiarray.interp), id(multiarray.interp_complex)), sequences.interpolated
)
STAND_INS |= {id(np.errstate): _error_state, id(np.seterr): _seterr, id(np.geterr): _geterr}
STAND_INS[id(np.vectorize)] = vectorized
STAND_INS |= {id(getattr(np, name)): impure(f"numpy.{name}") for name in OF_FILES}
STAND_INS |= {id(getattr(math, name)): function for name, function in MATH.items()}
STAND_INS |= {id(getattr(cmath, name)): function for name, function in CMATH.items()}
STAND_INS |= {id(plain): function for plain, function in BISECT.items()}
STAND_INS |= {id(getattr(builtins, name)): function for name, function in BUILTINS.items()}


def stand_in_of(value):
    """The stand-in of a function or class of a library; None for any other value."""
    found = STAND_INS.get(id(value))
    return scipy.stand_in_of(value, LibraryFunction) if found is None else found


def _in_source(value):
    """The stand-in that NumPy's rebuilt source gets for a value; None if there is none."""
    if isinstance(value, types.ModuleType):
        name = getattr(value.__spec__, "name", value.__name__)  # NumPy 2.2 calls one by another's
        if name.partition(".")[0] not in PURE:
            return Forbidden(name)
    return stand_in_of(value)


SOURCES = Sources(_in_source)


def root_of(thing):
    """The top-level package named by ``__module__``."""
    return (getattr(thing, "__module__", None) or "").partition(".")[0]


def _by_function(name):
    """The method of an array that calls the function of NumPy with this name."""

    def method(self):
        return lambda *args, **kwargs: call_function(getattr(np, name), (self, *args), kwargs)

    return of_numpy(method)


def _sort(self, axis=-1, **more):
    self[...] = call_function(np.sort, (self, axis), more)


for _name in (
    "sum mean max min std var prod any all dot clip round ptp cumsum cumprod trace argmax argmin "
    "searchsorted"
).split():
    setattr(Symbol, _name, _by_function(_name))
setattr(Symbol, "sort", _sort)  # noqa: B010
HANDLERS["function"] = call_function
