"""Products and sums of products on symbols."""

import functools
import math
from typing import Any

import numpy as np

from ..graph.rows import ID
from ..symbols.arithmetic import call, stored
from ..symbols.lift import joint, symbol
from ..symbols.symbol import HANDLERS, Symbol, graph_of, refuse, wrap
from .arrays import array_of
from .ufuncs import reduced

MOST = 20_000_000  # elements of a product before the sum
MOST_COMPLEX = 2**14  # the same of complex numbers: 1 to 2 times NumPy's time, 3 at 10^5, 6 at 10^6


def matmul(a, b) -> Any:
    """``a @ b``."""
    if hasattr(type(a), "multiplied"):
        return a.multiplied(b)
    g = graph_of(a, b)
    a = symbol(g, a)
    b = symbol(g, b)
    if not a.many or not b.many:
        raise ValueError("matmul: an operand has no axes")
    if a.kind == b.kind == "b":
        refuse("a product of arrays of truth values")  # such a product is a truth value, not a sum
    n = a.ids.shape[-1]
    if n != b.ids.shape[-2 if b.ids.ndim > 1 else 0]:
        raise ValueError(f"matmul: shapes {a.ids.shape} and {b.ids.shape} do not match")
    if b.ids.ndim == 1:
        return _sums(a, b, n)
    if a.ids.ndim == 1:
        return _sums(np.swapaxes(b, -1, -2), a, n)
    columns = np.swapaxes(b, -1, -2)
    return _sums(np.expand_dims(a, -2), np.expand_dims(columns, -3), n)


def _sums(a, b, n):
    """The sum of products along the last axis; products by constant zeros are left out."""
    g = a.g
    shape = np.broadcast_shapes(a.ids.shape, b.ids.shape)
    if math.prod(shape) > MOST:
        refuse("a product of two large matrices")
    of_complex = "c" in (a.kind, b.kind)
    if of_complex and math.prod(shape) > MOST_COMPLEX:
        refuse("a product of a large complex matrix, which NumPy does faster", final=True)
    g.check(2 * _count_of_terms(g, a, b, shape))
    if of_complex:
        return _complex_sums(a, b, n)
    if a.kind == "b" or b.kind == "b":
        a = a + 0
        b = b + 0
    kind = "i" if a.kind == b.kind == "i" else "f"
    if math.prod(shape) <= max(g.few, 0) or _few_nonzero(g, a, b, shape):
        rows = [np.broadcast_to(x.ids, shape).reshape(-1, n).tolist() for x in (a, b)]
        found = [_sum_of_products(g, *pair) for pair in zip(*rows, strict=True)]
        ids = np.array(found, ID).reshape(shape[:-1])
        return wrap(g, ids[()], kind)
    dense = _dense(g, a, b, shape)
    if dense is not None:
        return dense
    return reduced("add", a * b, axis=-1)


def _count_of_terms(g, a, b, shape):
    """The number of products whose factors are not known to be zero."""
    count = math.prod(shape)
    for s in (a, b):
        if g.few == math.inf and count > g.most and s.ids.size <= 2**20 and s.kind != "c":
            known = g.known(s.ids)
            if known is not None:
                count = min(count, np.count_nonzero(np.broadcast_to(known, shape)))
    return count


def _sum_of_products(g, a, b):
    zero = g.const(0.0)
    terms = []
    node = g.node
    for i, j in zip(a, b, strict=True):
        x = node(i)
        y = node(j)
        if not ((x.op == "const" and x.data == 0) or (y.op == "const" and y.data == 0)):
            terms.append(g.mul(x, y))
    return g.sum(terms).key if terms else zero.key


def _few_nonzero(g, a, b, shape):
    """Whether a product is written out: number by number, or by a matrix of mostly zeros."""
    if g.few == math.inf:
        return True
    count = math.prod(shape)
    known = [g.known(x.ids) for x in (a, b) if x.ids.ndim > 1 and x.ids.size == count]
    some = [np.count_nonzero(v) for v in known if v is not None]
    return bool(some) and min(some) <= min(0.1 * count, 4 * shape[0])


def _dense(g, a, b, shape):
    """A matrix of constants or parameters times a vector, as one row; None for other products."""
    if len(shape) != 2 or a.ids.shape != shape or b.ids.ndim != 1 or a.varies:
        return None
    row = g._row_with(a.ids)
    if row is None or row.op not in ("par", "const"):
        return None
    steps = [int(np.diff(np.take(a.ids, 0, 1 - k)[:2])[0]) if shape[k] > 1 else 0 for k in (0, 1)]
    grid = int(a.ids[0, 0]) + np.add.outer(
        np.arange(shape[0]) * steps[0], np.arange(shape[1]) * steps[1]
    )
    if not np.array_equal(grid, a.ids):
        return None
    data = "dense", *shape, row.first, int(a.ids[0, 0]) - row.first, *steps
    ids = np.ascontiguousarray(b.ids).copy()
    return Symbol(g, g.ids(g.row("dense", (shape[0],), (ids,), data)))


def _complex_sums(a, b, n):
    p, q = (a.part(0), a.part(1))
    r, s = (b.part(0), b.part(1))
    if a.kind != "c":
        return joint(_sums(a, r, n), _sums(a, s, n))
    if b.kind != "c":
        return joint(_sums(p, b, n), _sums(q, b, n))
    return joint(_sums(p, r, n) - _sums(q, s, n), _sums(p, s, n) + _sums(q, r, n))


def dot(a, b, out=None):
    if hasattr(type(a), "multiplied"):
        return a.multiplied(b)
    g = graph_of(a, b)
    a = symbol(g, a)
    b = symbol(g, b)
    if not a.many or not b.many or not a.ids.ndim or not b.ids.ndim:
        return stored(call("multiply", a, b), out)
    if a.ids.ndim > 1 and b.ids.ndim > 2:
        refuse("np.dot in more than two dimensions")
    return stored(matmul(a, b), out)


def einsum(subscripts, *operands, out=None):
    """One product over all indices, summed over the indices that the result lacks."""
    if not isinstance(subscripts, str) or "." in subscripts:
        refuse("einsum in this way")
    left, arrow, right = subscripts.replace(" ", "").partition("->")
    groups = left.split(",")
    if not arrow:
        right = "".join(sorted(c for c in set(left) - {","} if left.count(c) == 1))
    if len(groups) == 1 and set(groups[0]) == set(right):
        refuse("a view that np.einsum gives")
    rest = [c for c in dict.fromkeys(left) if c not in right and c != ","]
    order: Any = [*right, *rest]
    arrays: Any = []
    for group, operand in zip(groups, operands, strict=True):
        a: Any = array_of(operand)
        while len(set(group)) < len(group):
            c = next(c for c in group if group.count(c) > 1)
            i = group.index(c)
            j = group.rindex(c)
            a = np.diagonal(a, 0, i, j)
            group = group[:i] + group[i + 1 : j] + group[j + 1 :] + c
        a = a.transpose([group.index(c) for c in order if c in group])
        lengths = iter(a.ids.shape)
        arrays.append(a.reshape([next(lengths) if c in group else 1 for c in order]))
    if len(arrays) == 2 and len(rest) == 1:
        shape = np.broadcast_shapes(*[a.ids.shape for a in arrays])
        a, b = map(_squeezed, arrays)
        return stored(_sums(a, b, shape[-1]), out)
    term = functools.reduce(lambda x, y: call("multiply", x, y), arrays)
    if rest:
        term = reduced("add", term, axis=tuple(range(len(right), len(order))))
    return stored(term, out)


def _squeezed(a):
    """An array without leading axes of length 1."""
    while a.ids.ndim > 1 and a.ids.shape[0] == 1:
        a = a[0]
    return a


FUNCTIONS: dict[Any, Any] = {
    np.dot: dot, np.einsum: einsum,
    np.vdot: lambda a, b: matmul(np.conj(np.ravel(array_of(a))), np.ravel(array_of(b))),
    np.inner: lambda a, b: matmul(array_of(a), np.transpose(array_of(b))),
}  # fmt: skip
HANDLERS["matmul"] = matmul
