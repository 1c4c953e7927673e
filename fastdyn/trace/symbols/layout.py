"""The order in memory of arrays that hold symbols, which is that of NumPy's arrays.

The order decides whether a reshaped array is a view or a copy, and what ``ravel("K")`` gives.
"""

from typing import Any

import numpy as np

from ..graph.kinds import FLOAT, INT, NUMPY
from .complex_pair import any_complex
from .conditions import Condition
from .real import Symbol
from .symbolic import Batched, Lazy, Symbolic, refuse


def laid_out(array, like) -> Any:
    """An array moved in memory such that it lies as a fresh array made like `like`."""
    if like is None or array.ndim < 2:
        return array
    if like.flags.c_contiguous and _in_order(array):
        return array
    if isinstance(array, Batched):
        return array.laid_out(like)
    moved = np.empty_like(like.view(np.ndarray), array.dtype)
    moved[...] = array
    return moved.view(type(array))


def like_a_ufunc(arrays) -> Any:
    """An array that lies in memory as the result of a ufunc of `arrays`; None for C order."""
    if all(a.ndim < 2 or _in_order(a) for a in arrays):
        return None
    dtypes: Any = [None] * len(arrays) + [np.dtype(np.int8)]
    flags: Any = ["refs_ok", "zerosize_ok"]
    return np.nditer([*map(_memory, arrays), None], flags, op_dtypes=dtypes).operands[-1]


def promoted(function, args, result) -> Any:
    """Give the result of an elementwise function the type of numbers that NumPy's result has."""
    if not isinstance(result, Batched) or any(
        isinstance(a, Batched) and a.dtype.kind in "fc" for a in args
    ):
        return result
    with np.errstate(all="ignore"):
        trial = function(*map(_ones, map(_first, args)))
    return result.relabelled(trial.dtype)


def as_numpy_does(function, args, kwargs, result) -> Any:
    """Lay out the matrices of a result as NumPy's `function` does.

    The function is called with arrays of ones, which lie in memory as the arguments do.  Refuses a
    result that is a view of an argument where NumPy's result is none, and the reverse.
    """
    whole = any(a.dtype.kind in "bi" for a in arrays_in([args, kwargs]))
    if not any(whole or array.ndim > 1 for array in arrays_in(result)):
        return result
    ones = _ones(list(args)), {name: _ones(value) for name, value in kwargs.items()}
    try:
        with np.errstate(all="ignore"):
            trial = function(*ones[0], **ones[1])
    except Exception:
        if all(map(_in_order, arrays_in([args, kwargs]))):
            return result
        refuse(f"the order in memory of what {function.__name__} gives")
    given = list(zip(arrays_in([args, kwargs]), arrays_in(ones), strict=True))

    def laid(mine: Any, theirs):
        if isinstance(mine, list | tuple):
            return type(mine)([laid(*pair) for pair in zip(mine, theirs, strict=True)])
        if not isinstance(mine, np.ndarray):
            return mine
        if isinstance(mine, Batched):
            mine.relabelled(theirs.dtype)
        views = [np.may_share_memory(_memory(mine), _memory(arg)) for arg, _ in given]
        if views != [np.may_share_memory(theirs, one) for _, one in given]:
            refuse(f"a view that {function.__name__} gives")
        return mine if any(views) else laid_out(mine, theirs)

    return laid(result, trial)


def _in_order(array):
    return array.in_order() if isinstance(array, Batched) else array.flags.c_contiguous


def _memory(array):
    """An ndarray that lies in memory as `array` does."""
    return array.ids if isinstance(array, Batched) else array.view(np.ndarray)


def _first(value):
    """The first element of an array, in an array of as many axes."""
    return value[(slice(1),) * value.ndim] if isinstance(value, np.ndarray) else value


def arrays_in(value):
    """The arrays in a value."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, list | tuple | dict):
        for each in value.values() if isinstance(value, dict) else value:
            yield from arrays_in(each)


def _ones(value) -> Any:
    """A value with ones in place of numbers that depend on the state."""
    if isinstance(value, Symbol):
        return {INT: 1, FLOAT: 1.0, NUMPY: np.float64(1.0)}[value.kind]
    if isinstance(value, Symbolic):
        return np.True_ if isinstance(value, Condition) else np.complex128(1.0)
    if isinstance(value, Batched):
        return np.ones_like(value.ids, value.dtype)
    if isinstance(value, np.ndarray) and value.dtype == object:
        few = [] if isinstance(value, Lazy) else list(value.flat)
        truth = bool(few) and all(isinstance(v, Condition | bool | np.bool_) for v in few)
        dtype = complex if any_complex(few) else bool if truth else float
        return np.ones_like(value.view(np.ndarray), dtype)
    if isinstance(value, np.ndarray):
        return value.view(np.ndarray)
    return type(value)(map(_ones, value)) if type(value) in (list, tuple) else value
