"""NumPy's functions that make new arrays of symbols."""

from typing import Any

import numpy as np

from ..graph.rows import ID, PAIR
from ..symbols.arithmetic import cast
from ..symbols.arithmetic import where as selected
from ..symbols.lift import symbol
from ..symbols.symbol import NOW, Symbol, kind_of, refuse, wrap
from .arrays import _plain, array_of, fresh


def empty_like(a, dtype=None, order: Any = "K", subok=True, shape=None, **_):
    """np.empty_like, of zeros."""
    a = array_of(a)
    kind = a.kind if dtype is None else kind_of(dtype)
    ids = np.empty_like(a.ids, PAIR if kind == "c" else ID, order, shape=shape)
    ids[...] = cast(a.g, 0.0, kind, "unsafe")
    return wrap(a.g, ids, kind)


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


MAKERS = {np.zeros, np.ones, np.empty, np.eye, np.identity, np.linspace, np.full, np.arange, np.tri,
          np.logspace, np.geomspace}  # fmt: skip
FUNCTIONS: dict[Any, Any] = {
    np.empty_like: empty_like, np.linspace: spaced, np.arange: evenly,
    np.insert: inserted, np.copyto: copied,
}  # fmt: skip
