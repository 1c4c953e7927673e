"""The state before the start of a delay equation: a constant, a function, or an earlier result."""

import contextlib
import copy
import inspect
from typing import Any

import numpy as np

from fastdyn.compile.bind import bind, rebind
from fastdyn.compile.callables import Uncompilable
from fastdyn.compile.compare import machine_value
from fastdyn.compile.derivatives.sensitivities import bind_variational
from fastdyn.compile.functions import with_callback
from fastdyn.compile.mode import HISTORY
from fastdyn.compile.python_callback import Callback
from fastdyn.compile.sentences import GaveUp
from fastdyn.compile.traced.make import Near
from fastdyn.kernels.calls.block import FIRST, RAISED_WORD, TIME
from fastdyn.kernels.output import arguments as words
from fastdyn.problem.sensitivities import Variational
from fastdyn.trace.graph.derivatives import time_derivative
from fastdyn.trace.graph.evaluate import evaluate
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.jumps import decisions
from fastdyn.trace.reads.reads import flat
from fastdyn.words.kinds import shown

from .points import may_jump, traced_base
from .solution import DelaySolution

NEAR = 1e-3  # share of the span
COMPLEX = (
    "`history` must be real; got {}: let the state have real and imaginary parts, 2 numbers each, "
    "and let `fun` join them, E = y[0] + 1j * y[1]."
)


class History:
    """The history of a solve, and the array of words by which compiled code reads the past.

    Parameters
    ----------
    given : array_like, callable or OdeResult
        The state up to the start: n numbers, ``given(t)`` or ``given(t, *args)``, or a result with
        `sol`.  A neutral equation takes ``given.derivative(t)`` where ``given(t)`` cannot be
        traced.
    t0, tf : float
    args : tuple
        The arguments of the equations.

    Attributes
    ----------
    y0 : ndarray, shape (n,)
        The state at the start.
    n : int
        The length of the state, with sensitivities behind it.
    jumps : sequence of float
        The times at which an earlier result of a delay equation jumps.
    neutral : bool
        Whether Python code has asked for a derivative.
    varied : ndarray or None
        Steps along the directions of sensitivities, by which the past moves in Python.
    laid_out, words : ndarray
        The words, as `fastdyn.kernels.output.dense_output` reads them, as floats and whole numbers.
    """

    def __init__(self, given, t0, tf, args=()):
        self._function: Any = None
        self._earlier: Any = None
        self._args = ()
        self._values: Any = None  # of the parameters, if a later solve may change them
        self.times: Any = None
        self.varied: Any = None
        self.jumps: Any = ()
        self.neutral = False
        if hasattr(given, "sol"):
            if given.sol is None:
                raise ValueError("an earlier result goes on if it has `dense_output=True`.")
            self._earlier = given
            self.jumps = getattr(given, "jumps", ())
        elif callable(given):
            self._function = given
            if args and _takes(given, 1 + len(args)):
                self._args = args
        else:
            self.y0 = _numbers(given)
        self.t0 = t0
        self._tf = tf
        self.y0 = self.before(t0)
        self.n = len(self.y0)
        if not np.isfinite(self.y0).all():
            raise ValueError(f"`history` is not finite at the start, t = {t0}: {self.y0}.")
        # Not zeros: a trace is valid for other values than those compared, but not for zeros.
        self.laid_out = np.ones(words.PAST_WORDS)
        self.words = self.laid_out.view(np.int64)
        self.laid_out[words.PAST_T0] = t0
        self._given = self.laid_out, *args  # those of the equations
        self._start = self.y0
        self._bound = self._compiled()
        self._slope = self._compiled_slope()
        self._lay()

    def __enter__(self):
        self.words[words.PAST_OBJECT] = id(self)
        self.still(True)  # there is no memory of a solve yet

    def __exit__(self, *raised):
        self.words[words.PAST_OBJECT] = 0
        self.still(True)

    @property
    def bounds(self):
        """The functions of the history, and of its derivative where that was asked for."""
        return [self._bound] if self._slope.callback is not None else [self._bound, self._slope]

    @property
    def is_constant(self):
        """Whether the history is n numbers."""
        return self._function is None and self._earlier is None

    @property
    def decides(self):
        """Whether the history may jump or have a kink at times that are not known."""
        if self._function is None:
            return False
        function = traced_base(self._bound)
        if function is None:
            return True
        outputs = [*function.traced.stored, function.traced.trace.raising]
        return function.derived("decides", lambda: may_jump({node.op for node in live(outputs)}))

    def _lay(self):
        self._room = np.empty(self.n)
        whole = self.words
        whole[words.PAST_N] = self.n
        whole[words.PAST_Y0] = self._start.ctypes.data
        whole[words.PAST_ROOM] = self._room.ctypes.data
        whole[words.PAST_HISTORY] = self._bound.block.ctypes.data
        whole[words.PAST_HISTORY + 1] = self._slope.block.ctypes.data

    def begin_at(self, room):
        """Let the state at the start lie in `room`, which has its numbers."""
        self.y0 = self._start = room
        self.words[words.PAST_Y0] = room.ctypes.data

    def _in_time(self):
        """The history as a function of (t, state at the start, words, *args), and its region."""
        function = self._function
        if function is None:
            return (lambda t, y, *given: y), Near(self.t0, self._tf, self.y0)
        # Compared close to the start, because a history may not be defined far before.
        before = Near(self.t0, self.t0 - NEAR * (self._tf - self.t0), self.y0)
        if self._args:
            return (lambda t, y, laid_out, *args: np.atleast_1d(function(t, *args))), before
        return (lambda t, y, *given: np.atleast_1d(function(t))), before

    def _compiled(self):
        if self._earlier is not None:  # in Python: a sum over its steps, for the first delay only
            return self._called_back(self.before)
        fun, near = self._in_time()
        return bind(fun, self._given, HISTORY, len(self.y0), near)

    def _compiled_slope(self):
        """The derivative of the history by t: in Python, unless the history is constant."""
        n = len(self.y0)
        if self.is_constant:
            near = Near(self.t0, self._tf, self.y0)
            return bind(lambda t, y: np.zeros(n), (), HISTORY, n, near)
        return self._called_back(self.slope)

    def _called_back(self, function):
        def longer(t, y):  # zeros where sensitivities follow, whose past slopes nobody reads
            found = function(t)
            return np.concatenate([found, np.zeros(len(y) - len(found))])

        callback = Callback(longer, HISTORY, self.n)
        return with_callback(callback, function, [self], HISTORY, np.zeros(FIRST, np.int64))

    def take(self, given, args):
        """Take another history of the same kind, and other arguments; False for the long way."""
        if self.n != len(self.y0) or self._earlier is not None or hasattr(given, "sol"):
            return False
        if self._function is None:
            try:
                constant = _numbers(given)
            except TypeError:
                return False
            if constant.shape != self.y0.shape or not np.isfinite(constant).all():
                return False
            self.y0[:] = constant
            return True
        if not callable(given) or bool(self._args) != bool(args and _takes(given, 1 + len(args))):
            return False
        self._function = given
        self._args = args if self._args else ()
        self._given = self.laid_out, *args
        if self._bound.function is None:
            return False
        fun, _ = self._in_time()
        if not rebind(self._bound, fun, self._given):
            return False
        self.y0[:] = self.before(self.t0)
        return bool(np.isfinite(self.y0).all())

    def let_go(self):
        """Hold nothing of the user's; `take` comes next."""
        self._given = ()
        if self._function is not None:
            self._function = _nothing
            self._args = self._args and (None,)
        self._bound.held.take(None, ())

    def completed(self, result):
        """A result with `dense_output`, whose continuous solution has its history."""
        result["history"] = given = self._alone()
        if result["sol"] is not None:
            result["sol"] = DelaySolution(result["sol"], given)

    def _alone(self):
        """The history alone, of which no later `take` changes anything."""
        found = copy.copy(self)
        found.y0 = self.y0.copy()
        if self._bound.function is not None:
            found._values = flat(self._bound.given)
        return found

    def __reduce__(self):
        given = self.y0 if self.is_constant else self._function or self._earlier
        return History, (given, self.t0, self._tf, self._args)

    def lengthen(self, equations, y0):
        """Let the history have sensitivities, too; the state and the sensitivities at the start.

        Parameters
        ----------
        equations : problem.sensitivities.Variational
            Of the directions.
        y0 : ndarray
            The state at the start, and the derivatives of a constant history.

        Raises
        ------
        Uncompilable
            If the history has no derivatives.
        ValueError
            If it jumps.
        """
        if self._earlier is not None:
            raise Uncompilable("an earlier result does not know its derivatives as a history")
        function = self._bound.function
        if function is None or function.traced is None:
            raise Uncompilable("`history` cannot be traced")
        trace = function.traced.trace
        if decisions(trace.graph, trace.outputs, (), in_time=True):
            raise ValueError(
                "`sensitivity` needs a smooth history: where `history` decides by the time, its "
                "past may jump, and the derivatives of the solution with it."
            )
        fun, near = self._in_time()
        longer = Variational(fun, HISTORY, *equations[2:])
        self._bound = bind_variational(longer, self._given, near)
        self.n = len(y0)
        self._slope = self._compiled_slope()
        start: Any = machine_value(self._bound, self.t0, y0)
        self._start = start
        self._lay()
        return self._start

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
        self.words[words.PAST_BEGINS] = int(on)

    def before(self, t):
        """The state at a time up to the start, n floats."""
        if self._function is not None:
            return _numbers(self._function(t, *self._args))
        if self._earlier is None:
            return self.y0.copy()
        sol = self._earlier.sol
        if t < sol.t_min and not isinstance(sol, DelaySolution):
            raise ValueError(
                f"the past at t = {t:.10g} is before the start of the earlier result, "
                f"{sol.t_min:.10g}."
            )
        return np.array(sol(t), float)

    def slope(self, t):
        """The derivative of the state at a time up to the start, n floats.

        Raises
        ------
        ValueError
            If the history is a function without a trace and without `derivative`.
        """
        if self._earlier is not None:
            return np.array(self._earlier.sol.derivative(t), float)
        if self._function is None:
            return np.zeros(len(self.y0))
        given = getattr(self._function, "derivative", None)
        if given is not None:
            return _numbers(given(t))
        function = traced_base(self._bound)
        if function is None:
            raise ValueError(
                "`past.derivative` before the start needs the derivative of `history`, which "
                "cannot be traced: give `history.derivative`, a function of t."
            )
        graph = function.traced.trace.graph
        nodes = function.derived("slope", lambda: time_derivative(graph, function.traced.stored))
        values = flat(self._bound.given) if self._values is None else self._values
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
            if bound.block[RAISED_WORD]:
                t = float(bound.block[TIME : TIME + 1].view(float)[0])
                self.before(t)
                raise GaveUp(bound, t)


def _nothing(t, *args):
    """The function of a history that waits for the next solve."""


def _takes(function, count):
    """Whether a function must get `count` numbers, or gets any number of them."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return False
    if any(each.kind is each.VAR_POSITIONAL for each in parameters):
        return True
    positional = [
        each for each in parameters
        if each.kind in (each.POSITIONAL_ONLY, each.POSITIONAL_OR_KEYWORD)
    ]  # fmt: skip
    needed = sum(each.default is each.empty for each in positional)
    return needed == count


def _numbers(value):
    try:
        array = np.atleast_1d(np.asarray(value))
        array = array if array.dtype.kind == "c" else array.astype(float)
    except (TypeError, ValueError):
        raise TypeError(
            "`history` must be n numbers, a function of t, or a result with `sol`; got "
            f"{shown(value)}."
        ) from None
    if array.dtype.kind == "c":
        raise TypeError(COMPLEX.format(shown(value)))
    if array.ndim != 1 or not array.size:
        raise ValueError(f"`history` must give n numbers; got an array of shape {array.shape}.")
    return array
