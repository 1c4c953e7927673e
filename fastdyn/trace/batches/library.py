"""NumPy's functions on long arrays, made of `formulas`, `reductions`, `products`, `structure`."""

import functools
import operator
from typing import Any

import numpy as np

from ..numpy import functions
from ..symbols.arrays import stored
from ..symbols.layout import laid_out
from ..symbols.symbolic import Batched, refuse
from .columns import Columns
from .filters import convolved
from .formulas import as_columns, elementwise, filled
from .products import einsum, running_sum
from .reductions import reduce
from .structure import joined, padded

EXTREMES = {np.maximum: "top", np.minimum: "low", np.fmax: "", np.fmin: ""}


def reduced(table, ufunc, array, axis: Any = 0, keepdims=False, **more):
    if {k for k, v in more.items() if v is not None and v is not np._NoValue}:
        refuse(f"np.{ufunc.__name__}.reduce with {next(iter(more))}")
    if ufunc is np.add:
        return reduce(table, "sum", array, axis, keepdims)
    if EXTREMES.get(ufunc):
        return reduce(table, EXTREMES[ufunc], array, axis, keepdims)
    if ufunc in (np.logical_or, np.logical_and):
        array = elementwise(table, lambda v: functions.select(v, 1.0, 0.0), (array,))
        op, level = ("top", operator.gt) if ufunc is np.logical_or else ("low", operator.gt)
        return level(reduce(table, op, array, axis, keepdims), 0.5)
    if ufunc is np.multiply and array.ndim == 1 and array.size <= 64:
        return functools.reduce(operator.mul, array)
    return refuse(f"np.{ufunc.__name__}.reduce of a long array")


def _difference(table, a, n=1, axis=-1, prepend=np._NoValue, append=np._NoValue):
    a = as_columns(table, a)
    ends: list[Any] = [v for v in (prepend, a, append) if v is not np._NoValue]
    if len(ends) > 1:
        if a.ndim > 1:
            refuse("np.diff of a matrix with more at its ends")
        a = joined(table, np.hstack, [np.atleast_1d(v) for v in ends])
    for _ in range(n):
        at = [slice(None)] * a.ndim
        later, sooner = list(at), list(at)
        later[axis], sooner[axis] = slice(1, None), slice(None, -1)
        a = a[tuple(later)] - a[tuple(sooner)]
    return a


def _trapezoid(table, y, x=None, dx=1.0, axis=-1):
    y = as_columns(table, y)
    if y.ndim != 1:
        refuse("np.trapezoid of a matrix")
    steps = dx if x is None else np.diff(x)
    return np.sum(steps * (y[1:] + y[:-1]) / 2.0)


def _like(value):
    def function(table, a, dtype=None, order: Any = "K", subok=True, shape: Any = None):
        a = as_columns(table, a)
        like = np.empty_like(a.ids, np.int8, order, subok, shape)
        found = filled(table, like.shape, value).astype(a.dtype if dtype is None else dtype)
        return laid_out(found, like)

    return function


def _only(name, **more):
    """Refuse an option whose value would change the result: the functions here ignore options."""
    for option, value in more.items():
        if not any(value is each for each in (None, True, np._NoValue, float, np.float64)):
            refuse(f"np.{name} with {option}")


def _mean(table, a, axis=None, keepdims=False, **more):
    _only("mean", **more)
    total = reduce(table, "sum", a, axis, keepdims)
    return total / float(np.size(a) // max(1, np.size(total)))


def _variance(table, a, axis=None, ddof=0, keepdims=False, **more):
    _only("var", **more)
    a = as_columns(table, a)
    away = a - _mean(table, a, axis, True)
    total = reduce(table, "sum", away * away, axis, keepdims)
    return total / float(a.size // max(1, np.size(total)) - ddof)


def _by(op):
    def function(table, a, axis=None, dtype=None, out=None, keepdims=False, **more):
        _only(op, dtype=dtype, **more)
        return stored(
            reduce(table, op, a, axis, bool(keepdims) and keepdims is not np._NoValue), out
        )

    return function


def _share_memory(table, a, b, **_):
    if isinstance(a, Batched) or isinstance(b, Batched):
        refuse("whether long arrays share memory")
    return np.may_share_memory(a.view(np.ndarray), b.view(np.ndarray))


def _mesh(table, *axes, indexing="xy", **more):
    if any(value != (option == "copy") for option, value in more.items()):
        refuse("np.meshgrid of views, or with sparse axes")
    arrays = [as_columns(table, x) for x in axes]
    mesh: Any = np.meshgrid
    found = mesh(*[a.ids for a in arrays], indexing=indexing)
    return [Columns(table, ids) for ids in found]


def _spaced(table, start, stop, num=50, endpoint=True, retstep=False, dtype=None, axis=0):
    _only("linspace", dtype=dtype)
    step = (stop - start) / max(1, num - 1 if endpoint else num)
    found: Any = start + step * Columns(table, table.constants(np.arange(float(num))))
    if endpoint and num > 1:
        found[-1] = stop
    return (found, step) if retstep else found


def _full(table, shape, value, dtype=None, **more):
    _only("full", dtype=dtype, **more)
    return filled(table, shape, value)


def _running(table, a, axis=None, dtype=None, out=None):
    _only("cumsum", dtype=dtype)
    a = as_columns(table, a)
    if a.ndim != 1 and axis is not None:
        refuse("np.cumsum of a matrix")
    return stored(running_sum(table, a.reshape(-1)), out)


TRAPEZOID: Any = getattr(np, "trapezoid", None) or vars(np)["trapz"]  # "trapz" before NumPy 2
OWN: dict[Any, Any] = {
    np.linspace: _spaced, np.full: _full, np.meshgrid: _mesh,
    np.einsum: einsum, np.cumsum: _running, np.pad: padded, np.diff: _difference,
    TRAPEZOID: _trapezoid,
    np.zeros_like: _like(0), np.empty_like: _like(0), np.ones_like: _like(1),
    np.full_like: lambda table, a, value, *args, **kw: _like(value)(table, a, *args, **kw),
    np.sum: _by("sum"), np.max: _by("top"), np.min: _by("low"), np.amax: _by("top"),
    np.amin: _by("low"), np.mean: _mean, np.var: _variance,
    np.std: lambda table, *args, **kw: np.sqrt(_variance(table, *args, **kw)),
    np.any: lambda table, a, axis=None, **kw: reduced(table, np.logical_or, a, axis, **kw),
    np.all: lambda table, a, axis=None, **kw: reduced(table, np.logical_and, a, axis, **kw),
    np.ptp: lambda table, a, axis=None: np.max(a, axis) - np.min(a, axis),
    np.convolve: convolved, np.may_share_memory: _share_memory,
    np.trace: lambda table, a, *args: np.sum(np.diagonal(a, *args)),
    np.append: lambda table, a, b: joined(table, np.concatenate, [np.ravel(a), np.ravel(b)]),
    np.count_nonzero: lambda table, a, axis=None: np.sum(np.where(a, 1.0, 0.0), axis),
}  # fmt: skip
OF_COMPLEXES = {  # functions whose stand-ins also handle complex numbers
    np.sum, np.mean, np.cumsum, np.diff, np.gradient, TRAPEZOID, np.dot, np.inner,
    np.outer, np.vdot, np.convolve, np.einsum, np.linalg.norm, np.trace, np.pad, np.append,
    np.full, np.full_like,
    np.zeros_like, np.empty_like, np.ones_like, np.square, np.real, np.imag, np.angle,
    np.iscomplexobj, np.isrealobj, np.isscalar, np.shape, np.ndim, np.size, np.may_share_memory,
}  # fmt: skip
