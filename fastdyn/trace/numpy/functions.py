"""Stand-ins: NumPy's functions rewritten for arrays that hold symbols."""

import functools
import itertools
import operator
from typing import Any

import numpy as np

from ..symbols.arrays import Array, elementwise, reduced, stored
from ..symbols.complex_pair import any_complex, product, total
from ..symbols.conditions import kind_of_number, select
from ..symbols.division import to_decimals
from ..symbols.lazy import complete
from ..symbols.masks import Masked
from ..symbols.real import Symbol
from ..symbols.symbolic import Symbolic, in_batches, is_symbolic, refuse
from .fourier import TRANSFORMS
from .interpolation import binned, interpolated, whereabouts
from .linear_algebra import determinant, inverse, norm, solution
from .plain_arrays import array_of, as_array, lowered, raised
from .products import matmul
from .sequences import blocks, convolved, gradient_of, in_order, median, numpys_own, place_of
from .tables import Table


def where(condition, *choices):
    if len(choices) != 2:
        refuse("np.where with one argument")
    return elementwise(select, condition, *choices)


def clip(a, a_min=None, a_max=None, out=None, min=None, max=None, **_):
    lowest, highest = (a_min if a_min is not None else min), (a_max if a_max is not None else max)
    result = as_array(a)
    if lowest is not None:
        result = np.maximum(result, as_array(lowest))
    if highest is not None:
        result = np.minimum(result, as_array(highest))
    return stored(result, out)


def choose_first(conditions, choices, default=0.0):
    """np.select."""
    result = default
    for condition, choice in reversed(list(zip(conditions, choices, strict=True))):
        result = elementwise(select, condition, choice, result)
    return result


def piecewise(x, conditions, functions, *args, **kwargs):
    if not isinstance(conditions, list | tuple):
        conditions = [conditions]
    if isinstance(x, np.ndarray) and x.ndim:
        return _piecewise(x, conditions, functions, args, kwargs)
    functions = list(functions)
    default = functions.pop() if len(functions) == len(conditions) + 1 else 0.0
    values = [f(x, *args, **kwargs) if callable(f) else f for f in (default, *functions)]
    result = values[0]
    for condition, value in zip(conditions, values[1:], strict=True):
        result = elementwise(select, condition, value, result)
    return result


def _piecewise(x, conditions, functions, args, kwargs):
    """np.piecewise of an array: each function gets the elements that its condition selects."""
    if not isinstance(conditions[0], np.ndarray | list):
        conditions = [conditions]
    masks = [array_of(each) for each in conditions]
    if len(functions) == len(masks) + 1:
        masks.append(np.logical_not(functools.reduce(np.logical_or, masks)))
    result = np.zeros_like(x)
    for mask, value in zip(masks, functions, strict=True):
        if callable(value):
            chosen = x[mask]
            if isinstance(chosen, Masked) or len(chosen):
                result[mask] = value(chosen, *args, **kwargs)
        else:
            result[mask] = value
    return result


def einsum(subscripts, *operands, **_):
    subscripts = subscripts.replace(" ", "")
    if "." in subscripts:
        refuse("einsum with an ellipsis")
    left, arrow, right = subscripts.partition("->")
    groups = left.split(",")
    if not arrow:
        right = "".join(sorted(c for c in set(left) - {","} if left.count(c) == 1))
    arrays = [np.asarray(o, dtype=object).view(np.ndarray) for o in operands]
    pairs = zip(groups, arrays, strict=True)
    size = {c: s for group, a in pairs for c, s in zip(group, a.shape, strict=True)}
    inner = [c for c in size if c not in right]
    if len(groups) == 1 and not inner:
        refuse("a view that np.einsum gives")
    result = np.empty([size[c] for c in right], dtype=object)
    for i in np.ndindex(result.shape):
        at, terms = dict(zip(right, i, strict=True)), []
        for j in itertools.product(*(range(size[c]) for c in inner)):
            at.update(zip(inner, j, strict=True))
            factors = (
                a[tuple(at[c] for c in group)] for group, a in zip(groups, arrays, strict=True)
            )
            terms.append(functools.reduce(product, factors))
        result[i] = total(terms)
    return result.view(Array) if result.ndim else result[()]


def array(a, dtype=None, *, copy: Any = True, ndmin=0, order: Any = "K", **_):
    if isinstance(a, Table):
        if not ndmin and dtype is None:
            return a.copy() if copy else a
        a = complete(a)
    if isinstance(a, Symbol) and not ndmin:
        return Array.scalar(a)
    result = Array.of(np.array(a, object, ndmin=ndmin, copy=bool(copy) or None, order=order))
    if any(isinstance(v, np.ndarray) and v.ndim == 0 for v in result.flat):
        result = elementwise(lambda v: v.item() if isinstance(v, np.ndarray) else v, result)
    if any(v is None or isinstance(v, str | dict) for v in result.flat):
        refuse("an array of other things than numbers")
    return result if dtype is None else result.astype(dtype)


def as_it_is(a, dtype=None, **_):
    """np.asarray."""
    if isinstance(a, Array):
        return a if dtype is None else a.astype(dtype, copy=False)
    return array(a, dtype, copy=False)


def close(a, b, rtol=1e-5, atol=1e-8, **_):
    return elementwise(lambda x, y: abs(x - y) <= atol + rtol * abs(y), a, b)


def all_close(a, b, **kwargs):
    return np.all(close(a, b, **kwargs))


def cross(a, b, **kwargs):
    a, b = Array.of(a), Array.of(b)
    if a.shape != (3,) or b.shape != (3,) or kwargs:
        return numpys_own(np.cross)(a, b, **kwargs)
    (u, v, w), (x, y, z) = a, b
    return Array.of([v * z - w * y, w * x - u * z, u * y - v * x])


def _listed(value):
    return array_of(value) if isinstance(value, list | tuple) else value


def angle(z, deg=False):
    z = _listed(z)
    found = np.arctan2(getattr(z, "imag", 0.0), getattr(z, "real", z))
    return found * (180.0 / np.pi) if deg else found


def summed(a, axis=None, dtype=None, out=None, keepdims=False, **more):
    more |= {"axis": axis, "dtype": dtype, "keepdims": keepdims}
    return stored(np.add.reduce(Array.of(a), **more), out)


def without_nan(x, copy=True, nan=0.0, posinf=None, neginf=None):
    largest = np.finfo(float).max
    up, down = largest if posinf is None else posinf, -largest if neginf is None else neginf

    def one(v):
        if not is_symbolic(v):
            return np.nan_to_num(v, nan=nan, posinf=posinf, neginf=neginf)
        return select(v.nan(), nan, select(v == np.inf, up, select(v == -np.inf, down, v)))

    return stored(elementwise(one, x), None if copy or not isinstance(x, np.ndarray) else x)


def rounded(a, decimals=0, out=None):
    return stored(elementwise(lambda v: np_rounded(v, decimals), a), out)


def np_rounded(v, decimals):
    return to_decimals(v.as_numpy(), decimals) if isinstance(v, Symbol) else np.round(v, decimals)


def filled(value):
    """A function such as np.zeros_like, which fills the shape of an array with a value."""

    def function(a, dtype=None, *_, shape=None, **__):
        kinds = set(map(kind_of_number, Array.of(a).flat)) if dtype is None else ()
        dtype = bool if kinds == {"b"} else dtype
        result = Array.of(np.full(np.shape(a) if shape is None else shape, value))
        return result if dtype is None else result.astype(dtype)

    return function


class Joined:
    """np.r_ and np.c_."""

    def __init__(self, plain, join):
        self._plain, self._join = plain, join

    def __getitem__(self, key):
        if not is_symbolic(key):
            return raised(self._plain[lowered(key)])
        parts = key if isinstance(key, tuple) else (key,)
        if any(isinstance(part, str) for part in parts):
            refuse("np.r_ with an axis")
        if in_batches(parts):
            row = [np.r_[p] if isinstance(p, slice) else p for p in parts]
            return np.column_stack(row) if self._plain is np.c_ else np.hstack(row)
        return self._join([np.r_[p] if isinstance(p, slice) else as_array(p) for p in parts])


def _in_a_row(parts):
    return np.concatenate([Array.of([p]) if np.ndim(p) == 0 else Array.of(p) for p in parts])


INDEXED = {id(np.r_): Joined(np.r_, _in_a_row), id(np.c_): Joined(np.c_, np.column_stack)}


def _refused(name):
    return lambda *_, **__: refuse(f"np.{name} of what depends on the state")


def _extreme(ufunc):
    return lambda a, axis=None, out=None, **more: stored(
        ufunc.reduce(Array.of(a), axis=axis, **more), out
    )


STAND_INS = {
    np.where: where, np.clip: clip, np.select: choose_first, np.piecewise: piecewise,
    np.interp: interpolated, np.searchsorted: whereabouts,
    np.digitize: binned,
    np.dot: lambda a, b, out=None: stored(matmul(a, b, dot=True), out), np.einsum: einsum,
    np.linalg.solve: solution, np.linalg.inv: inverse, np.linalg.det: determinant,
    np.linalg.norm: norm, np.array: array, np.asarray: as_it_is, np.asanyarray: as_it_is,
    np.ascontiguousarray: as_it_is, np.isclose: close, np.allclose: all_close, np.cross: cross,
    np.sum: summed, np.max: _extreme(np.maximum), np.min: _extreme(np.minimum),
    np.amax: _extreme(np.maximum), np.amin: _extreme(np.minimum),
    np.any: lambda a, axis=None, out=None, **more: stored(Array.of(a).any(axis, **more), out),
    np.all: lambda a, axis=None, out=None, **more: stored(Array.of(a).all(axis, **more), out),
    np.nan_to_num: without_nan, np.gradient: gradient_of, np.convolve: convolved,
    np.fromiter: lambda values, dtype=None, count=-1: array(values, dtype),
    np.sort: in_order, np.median: median, np.block: blocks,
    np.argmax: lambda a, axis=None: place_of(a, axis, operator.gt),
    np.argmin: lambda a, axis=None: place_of(a, axis, operator.lt),
    np.vdot: lambda a, b: matmul(np.conj(np.ravel(a)), np.ravel(b)),
    np.inner: lambda a, b: matmul(a, np.transpose(b)),
    np.outer: lambda a, b, out=None: stored(np.multiply.outer(np.ravel(a), np.ravel(b)), out),
    np.zeros_like: filled(0.0), np.empty_like: filled(0.0), np.ones_like: filled(1.0),
    np.full_like: lambda a, value, *more, **kw: filled(value)(a, *more, **kw),
    np.sinc: lambda x: elementwise(_sinc, x),
    np.real: lambda a: getattr(_listed(a), "real", a),
    np.imag: lambda a: getattr(_listed(a), "imag", 0.0), np.angle: angle,
    np.round: rounded, np.around: rounded,
    np.count_nonzero: lambda a, axis=None: reduced(lambda r: total(v != 0 for v in r), a, axis),
    np.iscomplexobj: any_complex, np.isrealobj: lambda a: not any_complex(a),
    np.isscalar: lambda a: isinstance(a, Symbolic),
    np.shape: lambda a: _listed(a).shape, np.ndim: lambda a: _listed(a).ndim,
    np.size: lambda a, axis=None: array_of(a).size if axis is None else array_of(a).shape[axis],
}  # fmt: skip
for _name in ("argsort", "unique", "nonzero", "flatnonzero"):
    STAND_INS[getattr(np, _name)] = _refused(_name)
STAND_INS |= TRANSFORMS


def _sinc(v):
    if not isinstance(v, Symbol):
        return np.sinc(v)
    x = v * np.pi
    return select(v == 0, 1.0, x.call("sin") / x)
