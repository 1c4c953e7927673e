"""Compiles the exact Jacobian of a traced function: the entries that are not zero everywhere.

The Jacobian is called like the function, ``jacobian(t, y, n, block, out)``, with the function's
block.  Where the function raises, the entries are meaningless.
"""

from typing import NamedTuple

import numpy as np

from fastdyn.trace.graph.derivatives import jacobian as derivatives
from fastdyn.trace.graph.derivatives import time_derivative
from fastdyn.trace.graph.expressions import is_zero

from ..functions import Function
from ..mode import ENTRIES


class Jacobian(NamedTuple):
    """A compiled Jacobian, which writes its entries to `out`: by columns, rows ascending.

    `time` tells whether df/dt (n numbers) follows the entries; `autonomous` tells whether df/dt is
    zero.  `size` is the length of `out`.
    """

    function: Function
    rows: np.ndarray
    columns: np.ndarray
    time: bool
    autonomous: bool
    size: int


def jacobian(function, time=False):
    """The Jacobian of a compiled Function; None for a function that was not traced.

    Raises
    ------
    trace.refusal.Untraceable
        If an operation has no derivative, or there are too many entries.
    """
    if function is None or function.traced is None:
        return None
    return function.derived(("jacobian", time), lambda: _compiled(function.traced, time))


def _compiled(traced, time):
    graph = traced.trace.graph
    rows, columns, nodes = derivatives(graph, traced.stored, traced.n)
    by_time = time_derivative(graph, traced.stored) if time else []
    function = traced.with_outputs(nodes + by_time, ENTRIES, traced.n, graph.false).compiled()
    autonomous = all(map(is_zero, by_time))
    return Jacobian(function, rows, columns, time, autonomous, len(nodes) + len(by_time))
