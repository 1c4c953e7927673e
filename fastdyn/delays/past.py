"""What a delay equation gets as `past`: the state at earlier times, in Python and in a trace."""

import ctypes

import numpy as np

from fastdyn.kernels.output import arguments as words
from fastdyn.trace.functions.stand_ins import STAND_INS
from fastdyn.trace.symbols.lift import symbol
from fastdyn.trace.symbols.symbol import Symbol, graph_of, refuse

HISTORIES: dict = {}  # the History of each array of words, by the address of the array
BEYOND = 4.0 * np.finfo(float).eps


def state_before(laid_out, t, n, order=0):
    """The n components at time t, or their derivatives, by the array of words of a solve.

    NaN beyond the last step; `order` is 0, or 1 for the derivatives.
    """
    whole = laid_out.view(np.int64)
    t = float(t)
    t0 = laid_out[words.PAST_T0]
    history = HISTORIES[laid_out.ctypes.data]
    history.reads(t, order)
    at_count = int(whole[words.PAST_COUNT])
    count = ctypes.c_int64.from_address(at_count).value if at_count else 0
    if not t > t0 or whole[words.PAST_STILL]:
        return history.of_order(order, min(t, t0))
    if count == 0:
        return history.of_order(order, t0) if t <= t0 + BEYOND * abs(t0) else np.full(n, np.nan)
    spans = _array(whole[words.PAST_SPANS], (count, 2))
    end = spans[-1].sum()
    if t > end + BEYOND * max(abs(t), abs(end)):
        return np.full(n, np.nan)
    at = max(int(np.searchsorted(spans[:, 0], t, side="right")) - 1, 0)
    rows = int(whole[words.PAST_ROWS])
    d = _array(whole[words.PAST_D] + 8 * at * rows * n, (rows, n))
    x = (t - spans[at, 0]) / spans[at, 1]
    total = d[-1].copy()
    slope = np.zeros(n)
    for j in range(rows - 1, 0, -1):
        factor = x if j % 2 else 1.0 - x
        slope = slope * factor + (total if j % 2 else -total)
        total = d[j - 1] + total * factor
    return slope / spans[at, 1] if order else total


def _array(address, shape):
    size = int(np.prod(shape))
    return np.ctypeslib.as_array((ctypes.c_double * size).from_address(int(address))).reshape(shape)


def _on_symbols(laid_out, t, n, order=0):
    g = graph_of(laid_out, t)
    if g is None:
        return state_before(laid_out, t, n, order)
    if type(laid_out) is not Symbol:
        refuse("a past beside an array that is no argument")
    time = symbol(g, t)
    if time.kind == "c" or time.many:
        refuse("a past at several times at once: ask for one time after the other")
    first = g.node(int(laid_out.ids.reshape(-1)[0]))
    node = g.make("past", (time.node, first), (n, laid_out.ids.size, order))
    component = "of_slope" if order else "of_past"
    return symbol(g, [Symbol(g, g.make(component, (node,), i).key) for i in range(n)])


STAND_INS[id(state_before)] = _on_symbols


class Past:
    """``past(t - tau)`` is the state at an earlier time, an array of n components.

    ``past.derivative(t - tau)`` is the derivative of the solution there.
    """

    def __init__(self, laid_out, n):
        self._laid_out = laid_out
        self._n = n

    def __call__(self, t):
        return state_before(self._laid_out, t, self._n)

    def derivative(self, t):
        """The derivative of the solution at an earlier time, an array of n components."""
        return state_before(self._laid_out, t, self._n, 1)
