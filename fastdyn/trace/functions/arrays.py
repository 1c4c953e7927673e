"""NumPy's functions that make, move, choose and reduce the elements of arrays."""

import functools
import math
from typing import Any

import numpy as np

from ..graph.rows import ID, PAIR
from ..symbols.arithmetic import call, cast, stored, to_decimals
from ..symbols.arithmetic import where as selected
from ..symbols.constants import Constants
from ..symbols.lift import common_kind, joint, number, symbol  # fmt: skip
from ..symbols.masks import Masked
from ..symbols.symbol import NOW, PYTHON, Symbol, graph_of, is_symbolic, kind_of, refuse, wrap
from .ufuncs import as_numpy, reduced

STRUCTURE = {  # functions that only move elements: NumPy's own functions run on ids
    np.roll, np.reshape, np.ravel, np.transpose, np.swapaxes, np.moveaxis, np.take, np.flip,
    np.flipud, np.fliplr, np.repeat, np.tile, np.broadcast_to, np.squeeze, np.expand_dims,
    np.split, np.array_split, np.hsplit, np.vsplit, np.rot90,
    np.diagonal, np.rollaxis, np.copy, np.delete, np.resize, np.dsplit,
    np.broadcast_arrays,
}  # fmt: skip
# sin(u) / u in powers of u²: the next term is below half a rounding for |u| < 1
SINC = [(-1) ** k / math.factorial(2 * k + 1) for k in range(10)][::-1]
MAKERS = {np.zeros, np.ones, np.empty, np.eye, np.identity, np.linspace, np.full, np.arange, np.tri,
          np.logspace, np.geomspace}  # fmt: skip
TYPED = {
    np.array, np.asarray, np.asanyarray, np.ascontiguousarray, np.asfortranarray, np.require,
}  # fmt: skip


def array_of(value) -> Any:
    """An array-like as a symbol with axes."""
    s = symbol(graph_of(value) or NOW.g, value)
    return s if s.many else wrap(s.g, np.array(s.ids, PAIR if s.kind == "c" else ID), s.kind)


def structured(function, args, kwargs):
    """A function of STRUCTURE; the result is a view where NumPy's is a view."""
    if function is np.broadcast_arrays:
        every = [array_of(a) for a in args]
        found = function(*[s.ids for s in every])
        return [s.view_of(ids) for s, ids in zip(every, found, strict=True)]
    name, *others = args or (kwargs.pop("a"),)
    if any(is_symbolic(a) for a in (*others, *kwargs.values())):
        others = [_plain(a) for a in others]
        kwargs = {k: _plain(v) for k, v in kwargs.items()}
    array = array_of(name)
    found = function(array.ids, *others, **kwargs)
    if isinstance(found, list | tuple):
        return type(found)([array.view_of(ids) for ids in found])
    return array if found is array.ids else array.view_of(found)


def _plain(value) -> Any:
    if isinstance(value, list | tuple):
        return type(value)([_plain(v) for v in value])
    return value.plain() if type(value) is Symbol else value


def joined(arrays, axis=0, out=None, *, dtype=None, casting=None):
    """np.concatenate, of numbers or of truth values."""
    g = graph_of(arrays)
    every = [array_of(a) for a in arrays]
    kind = common_kind({s.kind for s in every}) if dtype is None else kind_of(dtype)
    ids = [np.asarray(cast(g, s, kind, "unsafe"), PAIR if kind == "c" else ID) for s in every]
    return stored(wrap(g, np.concatenate(ids, axis), kind), out)


def blocks(arrays):
    """np.block, of numbers or of truth values."""
    g = graph_of(arrays)
    every = []
    todo = [arrays]
    while todo:
        part = todo.pop()
        todo += part if type(part) is list else ()
        every += [array_of(part)] if type(part) is not list else ()
    kind = common_kind({s.kind for s in every})

    def ids(part):
        if type(part) is list:
            return [*map(ids, part)]
        return np.asarray(cast(g, array_of(part), kind, "unsafe"), PAIR if kind == "c" else ID)

    return wrap(g, np.block(ids(arrays)), kind)


def typed(function):
    """np.array and its kin: an array of an array-like, itself or a copy."""

    def made(value, dtype=None, *args, copy: Any = True, order: Any = "K", ndmin=0, **kwargs):
        g = graph_of(value)
        if isinstance(value, map | filter | zip) or hasattr(value, "__next__"):
            value = list(value)
            g = graph_of(value)
        if type(value) is Masked:
            return value if function is not np.array else refuse("a copy of a selection by a mask")
        if g is None:
            plain = (
                {} if function is not np.array else {"copy": copy, "ndmin": ndmin, "order": order}
            )
            return fresh(function(value, dtype, *args, **plain, **kwargs))
        s = array_of(value)
        found = s if dtype is None else s.astype(dtype, copy=False)
        if function in (np.ascontiguousarray, np.asfortranarray, np.require):
            ids = (
                function(found.ids, *args, **kwargs)
                if function is np.require
                else function(found.ids)
            )
            found = found if ids is found.ids else found.view_of(ids)
        elif function is np.array and copy and (found is s and s is value):
            found = s.copy(order)
        elif order in ("C", "F"):
            ids = np.asarray(found.ids, order=order)
            found = found if ids is found.ids else found.view_of(ids)
        return found.view_of(np.array(found.ids, ndmin=ndmin, copy=None)) if ndmin else found

    return made


def fresh(array) -> Any:
    """An array that NumPy made of plain numbers, as one that can hold symbols."""
    if NOW.g is None:
        return array
    if isinstance(array, tuple | list) and any(isinstance(a, np.ndarray) for a in array):
        return type(array)([fresh(a) for a in array])
    if type(array) is not np.ndarray:
        return array
    if array.dtype.kind in "ib" and array.ndim:
        return array.view(Constants)
    return symbol(NOW.g, array) if array.dtype in (float, complex) else array


# -- new arrays


def empty_like(a, dtype=None, order: Any = "K", *, shape=None):
    """np.empty_like, of zeros."""
    a = array_of(a)
    kind = a.kind if dtype is None else kind_of(dtype)
    ids = np.empty_like(a.ids, PAIR if kind == "c" else ID, order, shape=shape)
    ids[...] = cast(a.g, 0.0, kind, "unsafe")
    return wrap(a.g, ids, kind)


def spaced(start, stop, num=50, endpoint=True, retstep=False, dtype=None, axis=0):
    """np.linspace between numbers, or arrays, that are symbols."""
    if dtype is not None and kind_of(dtype) != "f":
        refuse("np.linspace with dtype")
    if axis != 0:
        refuse("np.linspace with axis")
    num = int(num)
    step = (stop - start) / max(1, num - 1 if endpoint else num)
    shares = np.arange(float(num)).reshape(-1, *[1] * np.ndim(step))
    found = start + step * symbol(NOW.g, shares)
    if endpoint and num > 1:
        found[-1] = stop
    return (found, step) if retstep else found


def evenly(start, stop=None, step=1, dtype=None):
    """np.arange of numbers that parameters determine."""
    return fresh(np.arange(*[_plain(v) for v in ([start] if stop is None else [start, stop, step])],
                           dtype=dtype))  # fmt: skip


def inserted(a, at, values, axis=None):
    a = array_of(a)
    given = cast(a.g, values, a.kind, "unsafe")
    return a.view_of(np.insert(a.ids, _plain(at), given, axis))


def copied(target, source, casting="same_kind", where: Any = True):
    """np.copyto."""
    if type(target) is not Symbol:
        refuse("a result that depends on the state is stored in an array from outside")
    found = source if where is True else selected(where, source, target.copy())
    target[...] = found


# -- reductions


def reduction(ufunc):
    """np.sum, np.max and the like."""

    def function(a, axis=None, dtype=None, out=None, keepdims=False, initial=None, where=True):
        return reduced(ufunc, array_of(a), axis, dtype, out, keepdims, initial, where)

    return function


def mean(a, axis=None, dtype=None, out=None, keepdims=False, *, where: Any = True):
    a = array_of(a)
    total = reduced("add", a, axis=axis, dtype=dtype, keepdims=keepdims, where=where)
    if where is True or where is np._NoValue:
        count: Any = a.ids.size // max(1, np.size(total.ids) if total.many else 1)
    else:
        ones = np.broadcast_to(array_of(where), a.ids.shape)
        count = reduced("add", ones, axis=axis, keepdims=keepdims)
    return stored(call("divide", total, count), out)


def variance(a, axis=None, dtype=None, out=None, ddof=0, keepdims=False, *, where=True,
             mean: Any = np._NoValue, correction=np._NoValue):  # fmt: skip
    for name, value, plain in (
        ("dtype", dtype, None), ("where", where, True), ("mean", mean, np._NoValue),
        ("correction", correction, np._NoValue),
    ):  # fmt: skip
        if value is not plain:
            refuse(f"np.var with {name}")
    a = array_of(a)
    away = a - _mean(a, axis, keepdims=True)
    squares = (
        away * away if a.kind != "c" else call("square", away.real) + call("square", away.imag)
    )
    total = reduced("add", squares, axis=axis, keepdims=keepdims)
    count = a.ids.size // max(1, np.size(total.ids) if total.many else 1)
    return stored(call("divide", total, float(count - ddof)), out)


_mean = mean


def deviation(a, *args, out=None, **kwargs):
    return stored(call("sqrt", variance(a, *args, **kwargs)), out)


def count(a, axis=None, *, keepdims=False):
    return reduced("add", array_of(a) != 0, axis=axis, keepdims=keepdims)


def place_of(name):
    """np.argmax or np.argmin: the first of equal elements, or the first NaN if there is one."""

    def function(a, axis=None, out=None, *, keepdims=False):
        a = array_of(a)
        if a.kind == "c":
            refuse("the largest of complex numbers")
        if axis is None:
            a = a.ravel()
            axis = 0
        if not a.ids.shape[axis]:
            raise ValueError("attempt to get argmax of an empty sequence")
        best = reduced(name, a, axis=axis, keepdims=True)
        here = call("logical_or", call("equal", a, best), call("isnan", a))
        shape = [1] * a.ids.ndim
        shape[axis] = -1
        n = a.ids.shape[axis]
        places = selected(here, np.arange(float(n)).reshape(shape), float(n))
        found = reduced("minimum", places, axis=axis, keepdims=keepdims)
        return stored(wrap(a.g, found.ids, "i"), out)

    return function


def trace(a, offset=0, axis1=0, axis2=1, dtype=None, out=None):
    diagonal = np.diagonal(array_of(a), offset, axis1, axis2)
    return reduced("add", diagonal, axis=-1, dtype=dtype, out=out)


# -- choices


def where_(condition, *choices):
    if len(choices) != 2:
        refuse("np.where with one argument")
    found = selected(condition, *choices)
    if type(found) is Symbol:
        return as_numpy(found)
    return np.asarray(found)[()] if isinstance(found, bool | np.bool_) else found


def clip(a, a_min=None, a_max=None, out=None, *, min=None, max=None):
    lowest = min if a_min is None else a_min
    highest = max if a_max is None else a_max
    found = symbol(graph_of(a, lowest, highest), a)
    if lowest is not None:
        found = np.maximum(found, lowest)
    if highest is not None:
        found = np.minimum(found, highest)
    return stored(found, out)


def piecewise(x, conditions, functions, *args, **kwargs):
    """np.piecewise: each function gets the elements that its condition selects."""
    g = graph_of(x, conditions)
    s = symbol(g, x)
    if not isinstance(conditions, list | tuple) or not _are_many(conditions, s):
        conditions = [conditions]
    masks = [symbol(g, c) for c in conditions]
    if len(functions) == len(masks) + 1:
        masks.append(symbol(g, call("logical_not", functools.reduce(
            lambda a, b: call("logical_or", a, b), masks))))  # fmt: skip
    if len(functions) != len(masks):
        raise ValueError("with conditions, there must be as many functions, or one more")
    if not s.many:
        values = [f(x, *args, **kwargs) if callable(f) else f for f in functions]
        result: Any = 0.0
        for mask, value in zip(masks, values, strict=True):
            result = selected(mask, value, result)
        return result
    result = np.zeros_like(s)
    for mask, value in zip(masks, functions, strict=True):
        mask = mask if mask.many else wrap(g, np.full(s.ids.shape, mask.ids, ID), "b")
        mask = mask if mask.kind == "b" else mask != 0
        if not callable(value):
            result[mask] = value
            continue
        chosen = s[mask]
        if type(chosen) is Masked or len(chosen):
            result[mask] = value(chosen, *args, **kwargs)
    return result


def _are_many(conditions, s):
    first: Any = conditions[0] if len(conditions) else 0
    many = first.many if type(first) is Symbol else np.ndim(first) > 0
    return many or not s.many


def rounded(a, decimals=0, out=None):
    s = as_numpy(symbol(graph_of(a), a))
    if s.kind == "c":
        return stored(joint(rounded(s.real, decimals), rounded(s.imag, decimals)), out)
    return stored(s if s.kind == "i" and decimals >= 0 else to_decimals(s, decimals), out)


def sinc(x):
    """np.sinc; near zero by its series: from the quotient 0 / 0 no Taylor series follows."""
    s = symbol(graph_of(x), x)
    if s.kind == "c":
        refuse("np.sinc of a complex number")
    u = math.pi * s
    near = abs(u) < 1.0
    square, away = u * u, selected(near, 1.0, u)
    series = functools.reduce(lambda found, c: found * square + c, SINC)
    return selected(near, series, np.sin(away) / away)


class Joined:
    """np.r_ and np.c_."""

    def __init__(self, plain, join):
        self._plain = plain
        self._join = join

    def __getitem__(self, key):
        parts = key if isinstance(key, tuple) else (key,)
        if any(isinstance(part, str) for part in parts):
            refuse("np.r_ with an axis") if is_symbolic(list(parts)) else None
            return fresh(self._plain[key])
        parts = [self._plain[_bounds(p)] if isinstance(p, slice) else p for p in parts]
        if not is_symbolic(parts):
            return fresh(self._plain[tuple(parts)])
        return self._join([p if np.ndim(getattr(p, "ids", p)) else [number(p)] for p in parts])


def _bounds(part):
    return slice(*[_plain(v) for v in (part.start, part.stop, part.step)])


def _type_of(value):
    if type(value) is Symbol:
        return PYTHON[value.kind]() if value.py else value.dtype
    return value


FUNCTIONS: dict[Any, Any] = {
    **{f: typed(f) for f in TYPED},
    np.concatenate: joined, np.block: blocks,
    np.sum: reduction("add"), np.max: reduction("maximum"),
    np.min: reduction("minimum"),
    np.prod: reduction("multiply"),
    np.any: reduction("logical_or"), np.all: reduction("logical_and"),
    np.mean: mean, np.var: variance, np.std: deviation,
    np.count_nonzero: count, np.trace: trace,
    np.argmax: place_of("maximum"), np.argmin: place_of("minimum"),
    np.where: where_, np.clip: clip, np.piecewise: piecewise,
    np.round: rounded, np.around: rounded,
    np.result_type: lambda *values: np.result_type(*map(_type_of, values)),
    np.isscalar: lambda a: type(a) is Symbol and not a.many,
    np.empty_like: empty_like, np.linspace: spaced, np.arange: evenly,
    np.insert: inserted, np.copyto: copied,
    np.sinc: sinc,
    np.fromiter: lambda values, dtype=None, count=-1: typed(np.array)(list(values), dtype),
}  # fmt: skip


INDEXED = {
    id(np.r_): Joined(np.r_, joined),
    id(np.c_): Joined(np.c_, lambda parts: np.column_stack([array_of(p) for p in parts])),
}
