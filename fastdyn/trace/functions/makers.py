"""NumPy's functions that make new arrays of symbols."""

from typing import Any

import numpy as np

from ..graph.rows import ID, PAIR
from ..symbols.arithmetic import call, cast
from ..symbols.arithmetic import where as selected
from ..symbols.lift import joint, symbol
from ..symbols.symbol import DTYPES, NOW, Symbol, graph_of, is_symbolic, kind_of, refuse, wrap
from .arrays import _plain, array_of, fresh, joined


def like(value):
    """np.zeros_like and the like."""

    def function(a, dtype=None, order: Any = "K", subok=True, shape=None, **_):
        s = symbol(graph_of(a) or NOW.g, a)
        kind = s.kind if dtype is None else kind_of(dtype)
        ids = np.array(s.ids) if not s.many else s.ids
        plan = np.empty_like(ids, np.int8, order, shape=shape)
        return filled(plan, DTYPES[kind].type(value), kind)

    return function


def filled(plan, value, kind):
    """An array of one number that lies in memory as `plan`."""
    g = NOW.g
    ids = np.empty_like(plan, PAIR if kind == "c" else ID)
    ids[...] = cast(g, value, kind, "unsafe")
    return wrap(g, ids, kind)


def full_like(a, value, dtype=None, order: Any = "K", subok=True, shape=None, **_):
    s = symbol(graph_of(a, value) or NOW.g, a)
    kind = s.kind if dtype is None else kind_of(dtype)
    plan = np.empty_like(s.ids if s.many else np.array(s.ids), np.int8, order, shape=shape)
    if kind in "bi" and not is_symbolic(value):
        return np.full_like(plan, value, DTYPES[kind])
    return filled(plan, value, kind)


def full(shape, value, dtype=None, order: Any = "C", **_):
    given = symbol(NOW.g, value)
    kind = given.kind if dtype is None else kind_of(dtype)
    return filled(np.empty(_plain(shape), np.int8, order), given, kind)


def spaced(start, stop, num=50, endpoint=True, retstep=False, dtype=None, axis=0):
    """np.linspace between numbers that are symbols."""
    num = int(num)
    step = (stop - start) / max(1, num - 1 if endpoint else num)
    found = start + step * symbol(NOW.g, np.arange(float(num)))
    if endpoint and num > 1:
        found[-1] = stop
    return (found, step) if retstep else found


def evenly(start, stop=None, step=1, dtype=None, **_):
    """np.arange of numbers that parameters determine."""
    return fresh(np.arange(*[_plain(v) for v in ([start] if stop is None else [start, stop, step])],
                           dtype=dtype))  # fmt: skip


def meshed(*axes, indexing: Any = "xy", sparse=False, copy=True):
    arrays = [array_of(x) for x in axes]
    found = np.meshgrid(*[a.ids for a in arrays], indexing=indexing, sparse=sparse, copy=copy)
    return type(found)([a.view_of(ids) for a, ids in zip(arrays, found, strict=True)])


def padded(array, pad_width, mode="constant", constant_values: Any = 0, **more):
    a = array_of(array)
    if mode == "constant":
        ids = cast(a.g, constant_values, a.kind, "unsafe")
        if np.ndim(constant_values):
            refuse("np.pad with several constants")
        if a.kind == "c":
            return joint(*[padded(a.part(i), pad_width, mode, symbol(a.g, constant_values).part(i))
                           for i in (0, 1)])  # fmt: skip
        more["constant_values"] = int(ids)
    elif mode not in ("edge", "wrap", "reflect", "symmetric") or more:
        refuse(f"np.pad with mode {mode}")
    return a.view_of(np.pad(a.ids, pad_width, mode, **more))


def appended(a, values, axis=None):
    if axis is None:
        a, values, axis = np.ravel(array_of(a)), np.ravel(array_of(values)), 0
    return joined(np.concatenate, [a, values], axis)


def inserted(a, at, values, axis=None):
    a = array_of(a)
    given = cast(a.g, values, a.kind, "unsafe")
    return a.view_of(np.insert(a.ids, _plain(at), given, axis))


def differences(a, n=1, axis=-1, prepend: Any = np._NoValue, append: Any = np._NoValue):
    a = array_of(a)
    ends: list[Any] = [array_of(v) for v in (prepend, a, append) if v is not np._NoValue]
    if len(ends) > 1:
        one = [1 if i == axis % a.ids.ndim else m for i, m in enumerate(a.ids.shape)]
        ends = [e if e.ids.ndim else np.broadcast_to(e, one) for e in ends]
        a = joined(np.concatenate, ends, axis)
    for _ in range(n):
        at = [slice(None)] * a.ids.ndim
        later, sooner = list(at), list(at)
        later[axis], sooner[axis] = slice(1, None), slice(None, -1)
        a = call("not_equal" if a.kind == "b" else "subtract", a[tuple(later)], a[tuple(sooner)])
    return a


def flattened_diag(v, k=0):
    """np.diag."""
    a = array_of(v)
    if a.ids.ndim != 1:
        return a.view_of(np.diagonal(a.ids, k).copy())
    n = len(a) + abs(k)
    zero = cast(a.g, 0.0, a.kind, "unsafe")
    ids = np.full((n, n), zero, a.ids.dtype)
    at = np.arange(len(a))
    ids[at + max(0, -k), at + max(0, k)] = a.ids
    return a.view_of(ids)


def triangle(function):
    def part(m, k=0):
        a = array_of(m)
        kept = function(np.ones(a.ids.shape[-2:], bool), k)
        return a.view_of(np.where(kept, a.ids, cast(a.g, 0.0, a.kind, "unsafe")))

    return part


def copied(target, source, casting="same_kind", where: Any = True):
    """np.copyto."""
    if type(target) is not Symbol:
        refuse("a result that depends on the state is stored in an array from outside")
    found = source if where is True else selected(where, source, target.copy())
    target[...] = found


MAKERS = {np.zeros, np.ones, np.empty, np.eye, np.identity, np.linspace, np.full, np.arange, np.tri,
          np.logspace, np.geomspace}  # fmt: skip
FUNCTIONS: dict[Any, Any] = {
    np.zeros_like: like(0), np.empty_like: like(0), np.ones_like: like(1), np.full_like: full_like,
    np.full: full, np.linspace: spaced, np.arange: evenly, np.meshgrid: meshed, np.pad: padded,
    np.append: appended, np.insert: inserted, np.diff: differences, np.diag: flattened_diag,
    np.tril: triangle(np.tril), np.triu: triangle(np.triu), np.copyto: copied,
    np.ediff1d: lambda a, **_: differences(np.ravel(array_of(a))),
}  # fmt: skip
