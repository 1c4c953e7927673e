"""NumPy's calls on symbols: ufuncs element by element, other functions by their stand-ins."""

import functools
import itertools
import types

import numpy as np

from ..islands import or_apart
from ..symbols.arrays import Array, elementwise, reduced, stored
from ..symbols.complex_pair import total
from ..symbols.conditions import select
from ..symbols.layout import as_numpy_does
from ..symbols.lazy import complete
from ..symbols.masks import WHY, Masked
from ..symbols.real import Symbol
from ..symbols.symbolic import (
    BATCHES,
    NOW,
    hand_over,
    in_batches,
    is_symbolic,
    refuse,
)  # fmt: skip
from .functions import STAND_INS
from .of_numbers import is_known, of_numbers
from .plain_arrays import as_array, lowered, raised
from .products import matmul

MAKERS = {np.linspace, np.full}  # functions that make long arrays of a few numbers
WITH_EFFECTS = set(
    "save savez savez_compressed savetxt array2string array_str array_repr copyto put place "
    "putmask fill_diagonal put_along_axis".split()
)
LAID_OUT = {np.where, np.piecewise, np.real, np.imag}  # their stand-ins lay out what they give
OF_TABLES = {
    np.interp, np.searchsorted, np.digitize, np.shape, np.ndim, np.size, np.array, np.asarray,
    np.asanyarray, np.ascontiguousarray,
}  # fmt: skip


def call_ufunc(ufunc, method, args, kwargs):
    """``ufunc(*args)``, or another method of the ufunc, on arrays that can hold symbols."""
    if in_batches(args):
        return BATCHES["ufunc"](ufunc, method, args, kwargs)
    args = complete(tuple(args))
    if any(isinstance(a, Masked) for a in args):
        refuse(WHY)
    out = kwargs.pop("out", None)
    where = complete(kwargs.pop("where", True))
    if kwargs.get("dtype") in (float, object, None, type(np.dtype(float)), type(np.dtype(object))):
        kwargs.pop("dtype", None)
    for option in ("casting", "subok"):
        kwargs.pop(option, None)
    if not is_symbolic(args) and not is_symbolic(where):
        if where is not True:
            kwargs["where"] = np.asarray(lowered(where), bool)
            if out is not None:
                kwargs["out"] = tuple(np.array(lowered(o), float) for o in out)
        result = _written_back(getattr(ufunc, method), args, {}, kwargs)
    elif method == "__call__":
        _refuse_options(ufunc.__name__, kwargs)
        result = _called(ufunc, args)
        if where is not True:
            result = elementwise(select, where, result, 0.0 if out is None else out[0])
    elif method == "reduce":
        result = _reduce(ufunc, args[0], where, **kwargs)
    elif method == "accumulate":
        result = _accumulate(ufunc, *args, **kwargs)
    elif method == "outer":
        a, b = (np.asarray(x, dtype=object) for x in args)
        result = elementwise(of_numbers(ufunc), a.reshape(a.shape + (1,) * b.ndim), b)
    elif method == "at":
        result = _at_places(of_numbers(ufunc), *args)
    else:
        refuse(f"{ufunc.__name__}.{method} of what depends on the state")
    if method in ("reduce", "accumulate"):
        result = as_numpy_does(getattr(ufunc, method), args, kwargs, result)
    return stored(result, out)


def _refuse_options(name, options):
    """Refuse options of a ufunc, such as an integer dtype, which would round."""
    for option, value in options.items():
        if value is not None and value is not np._NoValue:
            refuse(f"np.{name} with {option}")


def _called(ufunc, args):
    if ufunc is np.matmul:
        return matmul(*args)
    name = ufunc.__name__
    if is_known(name):
        return elementwise(of_numbers(ufunc), *args)
    return or_apart(ufunc, functools.partial(elementwise, of_numbers(ufunc)))(*args)


def _written_back(function, args, kwargs, plain):
    """Call a function on plain arrays; copy what the function wrote into the arrays of symbols."""
    lower = list(map(lowered, args))
    result = function(*lower, **plain)
    pairs = list(zip(args, lower, strict=True)) if result is None else []
    if kwargs.get("out") is not None:
        pairs.append((kwargs["out"], plain["out"]))
    for mine, theirs in pairs:
        if isinstance(mine, Array) and theirs is not mine:
            mine[...] = theirs
    return raised(result)


def _reduce(ufunc, array, where, axis=0, keepdims=False, initial=None, **more):
    _refuse_options(f"{ufunc.__name__}.reduce", more)
    array = Array.of(array)
    if where is not True and ufunc not in (np.add, np.multiply):
        refuse(f"{ufunc.__name__}.reduce of chosen elements")
    if where is not True:
        array = elementwise(select, where, array, 1.0 if ufunc is np.multiply else 0.0)
    function = of_numbers(ufunc)
    fold = total if ufunc is np.add else lambda row: functools.reduce(function, row)
    result = reduced(fold, array, axis, keepdims)
    if initial is not None and initial is not np._NoValue:
        result = elementwise(lambda v: function(v, initial), result)
    return result


def _accumulate(ufunc, array, axis=0, **more):
    _refuse_options(f"{ufunc.__name__}.accumulate", more)
    function = of_numbers(ufunc)
    rows = np.moveaxis(Array.of(array).view(np.ndarray), axis, -1)
    result = np.empty(rows.shape, dtype=object)
    for i in np.ndindex(rows.shape[:-1]):
        result[i] = list(itertools.accumulate(rows[i], function))
    return np.moveaxis(result, -1, axis).view(Array)


def _at_places(function, array, key, *others):
    """``ufunc.at``: apply the function at each place in turn; places may repeat."""
    if not isinstance(array, Array) or is_symbolic(key):
        refuse("a store at an index that depends on the state, or in an array from outside")
    places = np.arange(array.size).reshape(array.shape)[key]
    others = [np.broadcast_to(Array.of(v) if np.ndim(v) else v, places.shape) for v in others]
    for i in np.ndindex(places.shape):
        at = np.unravel_index(places[i], array.shape)
        array[at] = function(array[at], *(v[i] for v in others))


def call_function(function, args, kwargs):
    """Call a NumPy function whose arguments may hold symbols."""
    if function is np.fromiter:
        args = list(args[0]), *args[1:]
    args = tuple(list(a) if isinstance(a, types.GeneratorType) else a for a in args)
    if any(isinstance(a, Masked) for a in args):
        return function(*args, **kwargs) if isinstance(function, np.ufunc) else refuse(WHY)
    if in_batches((*args, *kwargs.values())) or (
        NOW.table is not None and function in MAKERS and is_symbolic([*args, *kwargs.values()])
    ):
        return BATCHES["function"](function, args, kwargs)
    if function not in OF_TABLES:
        args, kwargs = complete(args), {k: complete(v) for k, v in kwargs.items()}
    if not is_symbolic(args) and not any(map(is_symbolic, kwargs.values())):
        plain = {name: lowered(value) for name, value in kwargs.items()}
        return _written_back(function, args, kwargs, plain)
    if kwargs.get("dtype") in (float, np.float64, object):
        kwargs = {k: v for k, v in kwargs.items() if k != "dtype"}
    return _possibly_apart(function)(*args, **kwargs)


def _possibly_apart(function):
    """The stand-in of a NumPy function; if the stand-in refuses, the function becomes an island."""
    stand_in = STAND_INS.get(function)
    if stand_in is None or function in LAID_OUT:
        written_out = stand_in or functools.partial(_as_numpy_does, function)
    else:

        def written_out(*args, **kwargs):
            return as_numpy_does(function, args, kwargs, stand_in(*args, **kwargs))

    if function.__name__ in WITH_EFFECTS:
        return functools.partial(_or_refused, function, written_out)
    if isinstance(function, np.ufunc) or function is np.piecewise:
        return written_out
    return or_apart(function, written_out)


def _or_refused(function, written_out, *args, **kwargs):
    try:
        return written_out(*args, **kwargs)
    except TypeError:  # C code raises TypeError on symbols
        refuse(f"np.{function.__name__} of what depends on the state")


def _as_numpy_does(function, *args, **kwargs):
    if isinstance(function, np.ufunc):
        return function(*map(as_array, args), **kwargs)
    # NumPy's own Python code, which does not call `__array_function__`
    implementation = getattr(function, "_implementation", None)
    if implementation is None:
        return raised(function(*[_bare(as_array(a)) for a in args], **kwargs))
    if function not in (np.concatenate, np.stack, np.hstack, np.vstack):
        args = [Array.scalar(a) if isinstance(a, Symbol) else as_array(a) for a in args]
    return raised(implementation(*args, **kwargs))


def _bare(value):
    if isinstance(value, Array):
        return value.view(np.ndarray)
    return type(value)(map(_bare, value)) if type(value) in (list, tuple) else value


hand_over(call_ufunc, call_function)
