"""What a delay equation gets as `past`: the state at earlier times, in Python and in a trace."""

import ctypes
from typing import Any

import numpy as np

from fastdyn.code_store import Call
from fastdyn.kernels.output import arguments as words
from fastdyn.specialise.scalar import past_kernel
from fastdyn.trace.functions.stand_ins import STAND_INS
from fastdyn.trace.symbols.lift import symbol
from fastdyn.trace.symbols.symbol import Symbol, graph_of, refuse

MOST_NODES = 32  # components of a past state that are made as nodes before they are read


def history_of(laid_out) -> Any:
    """The History that an array of words names while its solve runs."""
    address = int(laid_out.view(np.int64)[words.PAST_OBJECT])
    if not address:
        raise ValueError("`past` is for calls within its solve: afterwards, take `sol`.")
    return ctypes.cast(address, ctypes.py_object).value


def state_before(laid_out, t, now, y, order=0):
    """The n components at time t, or their derivatives, by the array of words of a solve.

    NaN later than `now`, the time of the equations, at which the state is y; `order` is 0, or 1 for
    the derivatives.
    """
    history = history_of(laid_out)
    n = len(y)
    t = float(t)
    history.reads(t, order)
    if t == now and not order:
        return np.array(y, float)
    steps = None if order else history.varied
    found = np.empty(n if steps is None else history.n)
    Call(past_kernel(), laid_out, 0, t, float(now), order, 0, found)()
    history.check()
    if steps is not None:
        found = found[:n] + found[n:].reshape(n, -1) @ steps
    return found


def _on_symbols(laid_out, t, now, y, order=0):
    g = graph_of(laid_out, t)
    if g is None:
        return state_before(laid_out, t, now, y, order)
    if type(laid_out) is not Symbol:
        refuse("a past beside an array that is no argument")
    n = len(y)
    first = g.node(int(laid_out.ids.reshape(-1)[0]))
    if first.op != "par":  # the second trial of a trace, whose numbers are constants
        refuse("a past in code whose arguments are constants")
    times = symbol(g, t).node, first, symbol(g, now).node
    node = g.make("past", times, (n, laid_out.ids.size, order))
    component = "of_slope" if order else "of_past"
    if n > MOST_NODES:
        return Symbol(g, g.ids(g.row(component, (n,), (), node.key)))
    return symbol(g, [Symbol(g, g.make(component, (node,), i).key) for i in range(n)])


STAND_INS[id(state_before)] = _on_symbols


class Past:
    """``past(t - tau)`` is the state at an earlier time, an array of n components.

    ``past.derivative(t - tau)`` is the derivative of the solution there.  At an array of times,
    both have the shape of the times behind the components, as `sol` of a result.
    """

    def __init__(self, laid_out, now, y):
        self._laid_out = laid_out
        self._now = now
        self._y = y

    def __call__(self, t):
        return at_each(lambda t: state_before(self._laid_out, t, self._now, self._y), t)

    def derivative(self, t):
        """The derivative of the solution at an earlier time, an array of n components."""
        return at_each(lambda t: state_before(self._laid_out, t, self._now, self._y, 1), t)


def at_each(past, t):
    """The components at a time; at an array of times, with the shape of the times behind."""
    if np.ndim(t) == 0:
        return past(t)
    times = t if isinstance(t, Symbol) else np.asarray(t)
    return np.stack([at_each(past, each) for each in times], axis=1)
