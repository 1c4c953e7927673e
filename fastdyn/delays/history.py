"""The state before the start of a delay equation: a constant, a function, or an earlier result."""

import contextlib
from typing import Any

import numpy as np

from fastdyn.compile.bind import bind
from fastdyn.compile.functions import with_callback
from fastdyn.compile.mode import HISTORY
from fastdyn.compile.python_callback import Callback
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.calls.block import FIRST
from fastdyn.kernels.output import arguments as words
from fastdyn.trace.graph.derivatives import time_derivative
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.reads.reads import flat
from fastdyn.words.kinds import shown

from .past import HISTORIES


class History:
    """The history of a solve, and the array of words by which compiled code reads the past.

    Parameters
    ----------
    given : array_like, callable or OdeResult
        The state up to the start: n numbers, ``given(t)``, or a result with `sol`.  A neutral
        equation takes ``given.derivative(t)`` where ``given(t)`` cannot be traced.
    t0, tf : float

    Attributes
    ----------
    y0 : ndarray, shape (n,)
        The state at the start.
    neutral : bool
        Whether Python code has asked for a derivative.
    laid_out : ndarray
        The words, as `fastdyn.kernels.output.dense_output` reads them.
    """

    def __init__(self, given, t0, tf):
        self._function: Any = None
        self._earlier: Any = None
        self.times: Any = None
        self.neutral = False
        if hasattr(given, "sol"):
            if given.sol is None:
                raise ValueError("an earlier result goes on if it has `dense_output=True`.")
            self._earlier = given
        elif callable(given):
            self._function = given
        else:
            self._constant = _numbers(given)
        self.t0 = t0
        self.y0 = self.before(t0)
        if not np.isfinite(self.y0).all():
            raise ValueError(f"`history` is not finite at the start, t = {t0}: {self.y0}.")
        self.laid_out = np.zeros(words.PAST_WORDS)
        self.laid_out[words.PAST_T0] = t0
        self._bound = self._compiled(t0, tf)
        whole = self.laid_out.view(np.int64)
        self._slope = self._compiled_slope(t0, tf)
        whole[words.PAST_HISTORY] = self._bound.block.ctypes.data
        whole[words.PAST_HISTORY + 1] = self._slope.block.ctypes.data

    def __enter__(self):
        HISTORIES[self.laid_out.ctypes.data] = self

    def __exit__(self, *raised):
        HISTORIES.pop(self.laid_out.ctypes.data, None)

    def _compiled(self, t0, tf):
        n = len(self.y0)
        if self._earlier is not None:  # in Python: a sum over its steps, for the first delay only
            return self._called_back(self.before)
        if self._function is None:
            constant = self._constant
            return bind(lambda t, y: constant, (), HISTORY, n, Near(t0, tf, self.y0))
        function = self._function

        def of_time(t, y):
            return np.atleast_1d(function(t))

        return bind(of_time, (), HISTORY, n, Near(t0, t0 - (tf - t0), self.y0))

    def _compiled_slope(self, t0, tf):
        """The derivative of the history by t: in Python, unless the history is constant."""
        n = len(self.y0)
        if self._function is None and self._earlier is None:
            return bind(lambda t, y: np.zeros(n), (), HISTORY, n, Near(t0, tf, self.y0))
        return self._called_back(self.slope)

    def _called_back(self, function):
        n = len(self.y0)
        callback = Callback(lambda t, y: function(t), HISTORY, n)
        return with_callback(callback, function, [self], HISTORY, np.zeros(FIRST, np.int64))

    def reads(self, t, order):
        """Note that Python code asks for the past at time t."""
        self.neutral = self.neutral or order > 0
        if self.times is not None:
            self.times.append(t)

    @contextlib.contextmanager
    def asked(self):
        """A list that collects the times for which `past` is asked in Python."""
        self.times = []
        try:
            yield self.times
        finally:
            self.times = None

    def still(self, on):
        """Let later times than the start have the state at the start, or no longer."""
        self.laid_out.view(np.int64)[words.PAST_STILL] = int(on)

    def before(self, t):
        """The state at a time up to the start, n floats."""
        if self._function is not None:
            return _numbers(self._function(t))
        if self._earlier is None:
            return self._constant.copy()
        begin = self._earlier.sol.t_min
        if t >= begin:
            return np.array(self._earlier.sol(t), float)
        known = getattr(self._earlier, "history", None)
        if known is None:
            raise ValueError(
                f"the past at t = {t:.10g} is before the start of the earlier result, {begin:.10g}."
            )
        return known.before(t)

    def slope(self, t):
        """The derivative of the state at a time up to the start, n floats.

        Raises
        ------
        ValueError
            If the history is a function without a trace and without `derivative`.
        """
        if self._earlier is not None:
            known = getattr(self._earlier, "history", None)
            if known is not None and t < self._earlier.sol.t_min:
                return known.slope(t)
            return np.array(self._earlier.sol.derivative(t), float)
        if self._function is None:
            return np.zeros(len(self.y0))
        given = getattr(self._function, "derivative", None)
        if given is not None:
            return _numbers(given(t))
        function = self._bound.function
        if function is None or function.traced is None:
            raise ValueError(
                "`past.derivative` before the start needs the derivative of `history`, which "
                "cannot be traced: give `history.derivative`, a function of t."
            )
        graph = function.traced.trace.graph
        nodes = function.derived("slope", lambda: time_derivative(graph, function.traced.stored))
        values = flat(self._bound.given)
        found, _ = evaluate(graph, nodes, np.array([t]), self.y0[:, None], values)
        return np.array([row[0] for row in np.broadcast_to(found, (len(nodes), 1))])

    def of_order(self, order, t):
        """The state (order 0) at a time up to the start, or its derivative (order 1)."""
        return self.slope(t) if order else self.before(t)

    def check(self):
        """Raise the exception that the history raised in a solve."""
        for bound in (self._bound, self._slope):
            if bound.callback is not None and bound.callback.exception is not None:
                raise bound.callback.exception


def _numbers(value):
    try:
        array = np.atleast_1d(np.asarray(value, dtype=float))
    except (TypeError, ValueError):
        raise TypeError(
            "`history` must be n numbers, a function of t, or a result with `sol`; got "
            f"{shown(value)}."
        ) from None
    if array.ndim != 1 or not array.size:
        raise ValueError(f"`history` must give n numbers; got an array of shape {array.shape}.")
    return array.copy()
