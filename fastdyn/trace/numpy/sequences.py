"""NumPy's functions on sequences: sorting, argmax, blocks, gradients, convolutions."""

import functools
from typing import Any

import numpy as np

from ..symbols.arrays import Array, reduced
from ..symbols.complex_pair import product, total
from ..symbols.conditions import both, either, negated, select
from ..symbols.real import symbol
from ..symbols.symbolic import Batched, graph_of, is_symbolic, refuse
from .plain_arrays import array_of

MAX_SORTED = 32  # 496 comparisons of neighbours
MAX_PRODUCTS = 4096  # limit of a convolution's products


def numpys_own(function: Any):
    """NumPy's Python implementation of a function, for arrays that hold symbols."""
    return function._implementation


def _symbols(row) -> list[Any]:
    g = graph_of(row)
    return [symbol(g, v) for v in row]


def _sorted(row):
    """Sort by exchanges of neighbours; NaN comes last."""
    row = _symbols(row)
    if len(row) > MAX_SORTED:
        refuse("np.sort of so much that depends on the state")
    for end in range(len(row) - 1, 0, -1):
        for i in range(end):
            a, b = row[i], row[i + 1]
            exchanged = (b < a) | a.nan()
            row[i], row[i + 1] = select(exchanged, b, a), select(exchanged, a, b)
    return row


def in_order(a, axis: Any = -1, **more):
    """np.sort."""
    if any(v is not None for v in more.values()):
        refuse("np.sort with options")
    a = Array.of(a)
    rows = np.moveaxis(a if axis is not None else a.ravel(), -1 if axis is None else axis, -1)
    result = np.empty(rows.shape, dtype=object)
    for i in np.ndindex(rows.shape[:-1]):
        result[i] = _sorted(list(rows[i]))
    return np.moveaxis(result, -1, -1 if axis is None else axis).view(Array)


def median(a, axis=None, out=None, overwrite_input=False, keepdims=False):
    if out is not None:
        refuse("np.median with an array for the result")

    def one(row):
        ordered, half = _sorted(row), len(row) // 2
        middle = ordered[half] if len(row) % 2 else (ordered[half - 1] + ordered[half]) / 2.0
        nan = functools.reduce(either, [v.nan() for v in ordered])
        return select(nan, np.nan, middle.as_numpy())

    return reduced(one, a, axis, keepdims)


def place_of(a, axis, further):
    """np.argmax or np.argmin: the first of equal elements, or the first NaN if there is one."""

    def one(row):
        row = _symbols(row)
        best: Any = row[0]
        place: Any = 0
        for i, v in enumerate(row[1:], 1):
            better = further(v, best) | both(v.nan(), negated(best.nan()))
            best, place = select(better, v, best), select(better, i, place)
        return place

    return reduced(one, a, axis)


def blocks(arrays):
    """np.block: concatenate innermost lists along the last axis, outer lists along earlier axes."""
    depth, inner = 0, arrays
    while isinstance(inner, list) and inner:
        depth, inner = depth + 1, inner[0]
    leaves = list(_leaves(arrays, depth))
    n = max(1, depth, *(leaf.ndim for leaf in leaves))

    def joined(part, level):
        if level == depth:
            leaf = leaves.pop(0)
            return leaf.reshape((1,) * (n - leaf.ndim) + leaf.shape)
        return np.concatenate([joined(each, level + 1) for each in part], axis=level - depth)

    return joined(arrays, 0)


def _leaves(arrays, depth):
    if isinstance(arrays, list) != (depth > 0) or isinstance(arrays, tuple):
        raise ValueError("lists of different depth in np.block")
    if depth:
        for each in arrays:
            yield from _leaves(each, depth - 1)
    else:
        yield arrays if isinstance(arrays, np.ndarray) else Array.scalar(arrays)


def gradient_of(f: Any, *spacing: Any, axis=None, edge_order=1):
    f = array_of(f)
    if any(map(np.ndim, spacing)):
        if isinstance(f, Batched):
            refuse("np.gradient of a long array with uneven spacing")
        if f.ndim != 1 or len(spacing) > 1 or edge_order != 1 or is_symbolic(spacing):
            return numpys_own(np.gradient)(f, *spacing, axis=axis, edge_order=edge_order)
        h = np.diff(next(iter(spacing)))
        refuse("np.gradient on a grid") if not np.allclose(h, h[0], rtol=1e-12) else None
        spacing = (h[0],)
    axes = range(f.ndim) if axis is None else [int(a) % f.ndim for a in np.atleast_1d(axis)]
    if edge_order not in (1, 2) or len(spacing) > len(axes):
        refuse("np.gradient in this way")
    steps = list(spacing or (1.0,))
    if len(steps) == 1:
        steps *= len(axes)
    found = [_slope(f, i, h, edge_order) for i, h in zip(axes, steps, strict=True)]
    return found[0] if len(found) == 1 else tuple(found)


def _slope(f, axis, h, order):
    if f.shape[axis] < order + 1:
        raise ValueError("Shape of array too small to calculate a numerical gradient")
    inner = (slice(None),) * axis

    def at(key):
        return f[(*inner, key)]

    result = np.zeros_like(f)
    result[(*inner, slice(1, -1))] = (at(slice(2, None)) - at(slice(None, -2))) / (2.0 * h)
    if order == 1:
        result[(*inner, 0)] = (at(1) - at(0)) / h
        result[(*inner, -1)] = (at(-1) - at(-2)) / h
    else:
        a, b, c = -1.5 / h, 2.0 / h, -0.5 / h
        result[(*inner, 0)] = a * at(0) + b * at(1) + c * at(2)
        a, b, c = 0.5 / h, -2.0 / h, 1.5 / h
        result[(*inner, -1)] = a * at(-3) + b * at(-2) + c * at(-1)
    return result


def convolved(a, v, mode="full"):
    a, v = Array.of(a), Array.of(v)
    if is_symbolic(v) and not is_symbolic(a):
        a, v = v, a
    n, m = len(a), len(v)
    if n * m > MAX_PRODUCTS:  # NumPy's own function is as fast
        refuse("np.convolve of so much that depends on the state", final=True, said=False)
    whole = [
        total(product(a[i], v[k - i]) for i in range(max(0, k - m + 1), min(n, k + 1)))
        for k in range(n + m - 1)
    ]
    cut = {"full": 0, "same": (min(n, m) - 1) // 2, "valid": min(n, m) - 1}[mode]
    length = {"full": n + m - 1, "same": max(n, m), "valid": max(n, m) - min(n, m) + 1}[mode]
    return Array.of(whole[cut : cut + length])
