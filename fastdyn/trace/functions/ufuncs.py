"""NumPy's calls of ufuncs on symbols."""

import functools
from typing import Any

import numpy as np

from ..graph.rows import ID
from ..operations import NAMES
from ..symbols import operators  # noqa: F401  # registers the operators
from ..symbols.arithmetic import (
    LOGICAL,
    ON_SYMBOLS,
    SAME,
    as_numbers,
    as_truth,
    call,
    stored,
    truth,
)
from ..symbols.arithmetic import where as selected
from ..symbols.lift import joint, symbol
from ..symbols.masks import Masked
from ..symbols.symbol import HANDLERS, Symbol, constant, graph_of, refuse

DTYPES = {None, float, complex, np.float64, np.complex128, np.dtype(float), np.dtype(complex)}
EXTREMES = {"maximum": "top", "minimum": "low"}
OF_ROWS: dict[str, Any] = {}  # functions of rows of arrays (*arrays, options), by their names
START = {"multiply": 1.0, "logical_and": True, "logical_or": False}


def call_ufunc(ufunc, method, args, kwargs):
    """``ufunc(*args)``, or the method `method` of the ufunc, such as "reduce"."""
    if any(type(a) is Masked for a in args):
        return _of_masked(ufunc, method, args, kwargs)
    if method == "__call__" and ufunc.__name__ in OF_ROWS:
        return OF_ROWS[ufunc.__name__](*args, **kwargs)
    out = kwargs.pop("out", None)
    chosen = kwargs.pop("where", True)
    for option in ("casting", "subok", "order"):
        kwargs.pop(option, None)
    dtype = getattr(kwargs.get("dtype"), "plain", kwargs.get("dtype"))
    if dtype in DTYPES:
        kwargs.pop("dtype", None)
    if method == "__call__":
        _no_options(ufunc.__name__, kwargs)
        if ufunc is np.matmul:
            result = HANDLERS["matmul"](*args)
        else:
            result = elementwise(ufunc, *args)
        if chosen is not True:
            result = selected(chosen, result, 0.0 if out is None else out[0])
    elif method == "reduce":
        result = reduced(ufunc.__name__, args[0], *args[1:], where=chosen, **kwargs)
    elif method == "accumulate":
        result = accumulated(ufunc.__name__, *args, **kwargs)
    elif method == "outer":
        a, b = (x if type(x) is Symbol else np.asarray(x) for x in args)
        result = ufunc(a.reshape(a.shape + (1,) * b.ndim), b)
    elif method == "at":
        result = _at_places(ufunc, *args)
    else:
        refuse(f"{ufunc.__name__}.{method} of what depends on the state")
    return stored(result, out)


def _of_masked(ufunc, method, args, kwargs):
    masked = next(a for a in args if type(a) is Masked)
    return masked.__array_ufunc__(ufunc, method, *args, **kwargs)


def _no_options(name, options):
    for option, value in options.items():
        if value is not None and value is not np._NoValue:
            refuse(f"np.{name} with {option}")


def is_known(ufunc):
    """Whether a ufunc is an operation, or has a formula."""
    name = SAME.get(ufunc.__name__, ufunc.__name__)
    return name == "hypot" or name in ON_SYMBOLS or name in NAMES or name in LOGICAL or name in (
        "invert", "bitwise_and", "bitwise_or", "bitwise_xor")  # fmt: skip


def elementwise(ufunc, *args):
    g = graph_of(*args)
    if not is_known(ufunc):
        refuse(f"it calls {ufunc.__name__}")
    return call(ufunc.__name__, *[as_numpy(symbol(g, a)) for a in args])


def as_numpy(s) -> Any:
    """A number under NumPy's rules, where nothing raises; an array stays."""
    return s if not s.py else Symbol(s.g, s.ids, s.kind)


# -- reductions


def reduced(name: str, array, axis: Any = 0, dtype=None, out=None, keepdims=False, initial=None,
            where: Any = True) -> Any:  # fmt: skip
    """A ufunc's reduction of an array along axes."""
    name = SAME.get(name, name)
    g = graph_of(array, where)
    a = symbol(g, array)
    keepdims = keepdims is not np._NoValue and bool(keepdims)
    initial = None if initial is np._NoValue else initial
    if dtype is not None and getattr(dtype, "plain", dtype) not in DTYPES:
        refuse(f"np.{name}.reduce with dtype")
    if not a.many:
        a = (
            Symbol(g, np.array(a.ids, ID), a.kind)
            if a.kind != "c"
            else refuse("a sum of one number")
        )
    if where is not True and where is not np._NoValue:
        if name not in ("add", "multiply", *LOGICAL):
            refuse(f"np.{name}.reduce of chosen elements")
        a = symbol(g, selected(where, a, START.get(name, 0.0)))
    found = _reduced(g, name, a, axis, keepdims)
    if initial is not None:
        found = call(name, found, initial)
    return stored(found, out)


def _reduced(g, name, a, axis, keepdims):
    if name == "add":
        kind = "i" if a.kind in "bi" else a.kind
        if a.kind == "c":
            return joint(*[_reduced(g, name, a.part(i), axis, keepdims) for i in (0, 1)])
        return Symbol(g, g.reduce("sum", as_numbers(g, a), axis, keepdims), kind)
    if name in EXTREMES and a.kind in "if":
        return Symbol(g, g.reduce(EXTREMES[name], a.ids, axis, keepdims), a.kind)
    if name in ("logical_and", "logical_or") or (name in EXTREMES and a.kind == "b"):
        every = name in ("logical_and", "minimum")
        return _of_truths(g, as_truth(g, a), every, axis, keepdims)
    if name in ("multiply", "fmax", "fmin", "hypot", "logical_xor", "logaddexp") or a.kind != "b":
        return _halved(name, a, axis, keepdims)
    return refuse(f"np.{name}.reduce of truth values")


def _of_truths(g, ids, every, axis, keepdims):
    """Whether all, or any, of the truth values along axes are true."""
    one = g.const(1.0).key
    none = g.const(0.0).key
    if axis is None and not keepdims:
        node = g.negation(g.anywhere(g.map("not", ids))) if every else g.anywhere(ids)
        return truth(g, node.key)
    numbers = g.map("select", ids, one, none)
    if not numbers.size:
        return Symbol(g, np.full(np.all(np.zeros(ids.shape, bool), axis, keepdims=keepdims).shape,
                                 (g.true if every else g.false).key, ID), "b")  # fmt: skip
    found = g.reduce("low" if every else "top", numbers, axis, keepdims)
    return truth(g, g.map("lt", g.const(0.5).key, found))


def _halved(name, a, axis, keepdims):
    """Combine the two halves of the elements along axes, until one is left."""
    ndim = a.ids.ndim
    axes = sorted(range(ndim) if axis is None else {int(i) % ndim for i in np.atleast_1d(axis)})
    kept = [i for i in range(ndim) if i not in axes]
    shape = tuple(a.ids.shape[i] for i in kept)
    rows = a.view_of(a.ids.transpose([*axes, *kept]).reshape(-1, *shape))
    if not len(rows):
        return constant(a.g, START[name], np.empty(shape, ID)) if name in START else _nothing()
    if len(rows) * max(1, int(np.prod(shape))) <= a.g.few:
        rows = functools.reduce(lambda x, y: call(name, x, y), list(rows))
    else:
        while len(rows) > 1:
            half = len(rows) // 2
            both = call(name, rows[:half], rows[half : 2 * half])
            odd = rows[2 * half :]
            rows = both if not len(odd) else both.view_of(np.concatenate([both.ids, odd.ids]))
        rows = rows[0]
    if keepdims:
        whole = tuple(1 if i in axes else n for i, n in enumerate(a.ids.shape))
        return rows.view_of(np.asarray(rows.ids, a.ids.dtype).reshape(whole))
    return rows


def _nothing():
    raise ValueError("zero-size array to reduction operation which has no identity")


def accumulated(name: str, array, axis=0, dtype=None, out=None):
    """Running sums, products or extremes along an axis."""
    name = SAME.get(name, name)
    a = symbol(graph_of(array), array)
    if getattr(dtype, "plain", dtype) not in DTYPES:
        refuse(f"np.{name}.accumulate with dtype")
    if a.kind == "b":
        a = a + 0
    rows = a.view_of(np.moveaxis(a.ids, axis, 0))
    n = len(rows)
    if rows.ids.size <= a.g.few or n <= 8:
        found = [rows[0]] if n else []
        for i in range(1, n):
            found.append(call(name, found[-1], rows[i]))
        ids = np.array([s.ids for s in found], a.ids.dtype).reshape(rows.ids.shape)
    elif name == "add" and rows.ids.ndim == 1:
        ids = _running(a.g, a, rows)
    else:
        ids = _doubled(name, rows)
    return stored(a.view_of(np.moveaxis(ids, 0, axis)), out)


def _running(g, a, rows):
    if a.kind == "c":
        return joint(*[Symbol(g, _running(g, a.part(i), rows.part(i))) for i in (0, 1)]).ids
    ids = np.ascontiguousarray(rows.ids)
    return g.ids(g.row("running", ids.shape, (ids.copy(),), None, False, rows.varies))


def _doubled(name, rows):
    step = 1
    while step < len(rows):
        later = call(name, rows[step:], rows[:-step])
        rows = rows.view_of(np.concatenate([rows.ids[:step], later.ids]))
        step *= 2
    return rows.ids


def _at_places(ufunc, array, key, *others):
    """``ufunc.at``: apply the function at each place in turn; places may repeat."""
    if type(array) is not Symbol:
        refuse("a store in an array from outside")
    if type(key) is Symbol:
        key = key.plain()
    places = np.arange(array.ids.size).reshape(array.ids.shape)[key]
    g = array.g
    others = [np.broadcast_to(symbol(g, v).ids, np.shape(places)) for v in others]
    for i in np.ndindex(np.shape(places)):
        at = np.unravel_index(places[i], array.ids.shape)
        array[at] = ufunc(array[at], *[Symbol(g, int(v[i])) for v in others])


HANDLERS["ufunc"] = call_ufunc
