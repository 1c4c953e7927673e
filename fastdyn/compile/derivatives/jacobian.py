"""Compiles the exact Jacobian of a traced function: the entries that are not always zero.

The Jacobian is called like the function, ``jacobian(t, y, n, block, out)``, with the function's
block.  Where the function raises, the entries are meaningless.
"""

from typing import NamedTuple

import numpy as np

from fastdyn.trace.graph.derivatives import jacobian as derivatives
from fastdyn.trace.graph.derivatives import time_derivative
from fastdyn.trace.graph.expressions import is_zero
from fastdyn.trace.graph.signs import signed

from ..functions import Function
from ..mode import ENTRIES


class Jacobian(NamedTuple):
    """A compiled Jacobian, which writes its entries to `out`: by columns, rows ascending.

    `time` tells whether df/dt (n numbers) follows the entries; `autonomous` tells whether df/dt is
    zero.  `size` is the length of `out`; `depends` tells whether any entry is not always zero.
    """

    function: Function
    rows: np.ndarray
    columns: np.ndarray
    time: bool
    autonomous: bool
    size: int
    depends: bool


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
    outputs = signed(graph, traced.stored)  # the slope of x / |x| is 0 at 0, too, not NaN
    rows, columns, nodes = derivatives(graph, outputs, traced.n)
    by_time = time_derivative(graph, outputs) if time else []
    depends = bool(nodes)
    if not depends:  # differences would take a jump of the function, as at a relay, for a slope
        rows = columns = np.zeros(min(1, traced.n), np.int64)
        nodes = [graph.const(0.0)] * len(rows)
    function = traced.with_outputs(nodes + by_time, ENTRIES, traced.n, graph.false).compiled()
    autonomous = all(map(is_zero, by_time))
    size = len(nodes) + len(by_time)
    return Jacobian(function, rows, columns, time, autonomous, size, depends)
