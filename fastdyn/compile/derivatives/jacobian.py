"""Compiles the exact Jacobian of a traced function: the entries that are not zero everywhere.

The Jacobian is called like the function, ``jacobian(t, y, n, block, out)``, with the same block.
Where the function raises, the entries are meaningless.
"""

import functools
import threading
from typing import Any, NamedTuple

import numpy as np

from fastdyn import code_store
from fastdyn.trace.graph.derivatives import jacobian as derivatives
from fastdyn.trace.graph.derivatives import time_derivative
from fastdyn.trace.graph.expressions import is_zero

from ..mode import ENTRIES
from ..traced.code import Traced

GROWING = threading.Lock()  # only one thread may extend a graph


class Jacobian(NamedTuple):
    """A compiled Jacobian: `out` gets its entries by columns, rows ascending, then maybe df/dt.

    `time` tells whether df/dt (n numbers) follows the entries, and `autonomous` whether df/dt is
    zero.  `size` is the length of `out`.  `build` makes the dispatcher of the pointer form,
    `traced` is its trace.
    """

    key: str
    address: Any
    rows: np.ndarray
    columns: np.ndarray
    time: bool
    autonomous: bool
    size: int
    build: Any
    traced: Any
    keepalive: Any


def jacobian(function, time=False):
    """The Jacobian of a compiled Function; None for a function that was not traced.

    Raises
    ------
    trace.refusal.Untraceable
        If an operation has no derivative, or there are too many entries.
    """
    if function is None or function.traced is None:
        return None
    with GROWING:
        found = function.notes.get(("jacobian", time))
        if found is None:
            found = function.notes["jacobian", time] = _compiled(function.traced, time)
        return found


def _compiled(traced, time):
    graph = traced.trace.graph
    rows, columns, nodes = derivatives(graph, traced.stored, traced.n)
    by_time = time_derivative(graph, traced.stored) if time else []
    nodes = nodes + by_time
    trace = traced.trace._replace(outputs=nodes, raising=graph.false, error="")
    found = Traced(trace, ENTRIES, traced.n)
    key = found.key()
    code = code_store.assembled(key, found.text)
    return Jacobian(
        key, code.address, rows, columns, time, all(map(is_zero, by_time)), len(nodes),
        functools.cache(found.dispatcher), found, code,
    )  # fmt: skip
