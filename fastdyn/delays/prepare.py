"""prepare_dde: a solver of one delay equation for many histories and arguments."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from fastdyn.problem import validate
from fastdyn.problem.arguments import own
from fastdyn.problem.members import Members
from fastdyn.problem.options.docstrings import filled
from fastdyn.words.calls import shown_when_wrong

from .again import RepeatedEquation
from .equation import KINDS, Given

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Args, Function, Functions, Times, TimeSpan
    from fastdyn.run.result import OdeResult

PREPARING = threading.RLock()  # one thread at a time prepares


@shown_when_wrong(**KINDS)
def prepare_dde(
    fun: Function,
    t_span: TimeSpan,
    history: Any,
    method: str = "auto",
    t_eval: Times | None = None,
    dense_output: bool = False,
    events: Functions | None = None,
    args: Args = (),
    delays: Times | None = None,
    jumps: Times | None = None,
    **options: Any,
) -> PreparedDelays:
    """Make a solver of a delay equation, to be called with other histories and arguments.

    The work of `solve_dde` before and after the steps is done once; for the same delays, the times
    at which jumps come back, too.

    Parameters
    ----------
    fun, t_span, method, t_eval, dense_output, events, delays, jumps
        As in `solve_dde`.
    history, args
        As in `solve_dde`; the defaults of the solves.
    **options
        As in `solve_dde`, except that `compile` is "inlined" by default.

    Returns
    -------
    PreparedDelays

    Raises
    ------
    ValueError, TypeError
        As `solve_dde`.

    Examples
    --------
    >>> late = prepare_dde(
    ...     lambda t, y, past, tau: -past(t - tau), (0, 9), [1.0], args=(0.5,)
    ... )
    >>> late(args=(0.9,)).y[0, -1], late([2.0]).y[0, -1]
    """
    options = own({"compile": "inlined", **options})
    asked = {
        "fun": fun, "t_span": t_span, "history": history, "method": method, "t_eval": t_eval,
        "dense_output": dense_output, "events": events, "args": args, "delays": delays,
        "jumps": jumps,
    }  # fmt: skip
    return PreparedDelays(Given(**own(asked), options=options))


class PreparedDelays:
    """A solver of one delay equation: ``solver(history, args)`` returns an OdeResult.

    Both are optional.  Results do not share memory.  Several threads may call at once.
    """

    def __init__(self, given):
        self._given = given
        self._equation = RepeatedEquation(given)  # of the last solve
        self._free = [self._equation]  # in no solve
        self._args = self._equation.args
        self._equation.solve()

    def __reduce__(self):
        """Pickle the arguments of `prepare_dde`: a copy is prepared anew."""
        return PreparedDelays, (self._given,)

    def __repr__(self):
        p = self._equation.problem
        size = f"{len(p.y0)} component{'s' * (len(p.y0) != 1)}"
        return f"<PreparedDelays: {p.method.name}, t = {p.t0:g} to {p.tf:g}, {size}>"

    def __call__(self, history=None, args=None) -> OdeResult:
        """Solve with a history and arguments; the defaults are those of `prepare_dde`.

        Parameters
        ----------
        history : array_like, callable or OdeResult, optional
        args : tuple, optional
        """
        if history is None:
            history = self._given.history
        if args is None:
            args = self._args
        elif args.__class__ is not tuple:
            args = validate.extra_arguments(args)
        try:
            equation = self._free.pop()
        except IndexError:  # another thread has it, or a function calls within its own solve
            equation = None
        try:
            result = equation and equation.again(self._given.fun, history, args)
            if result is None:
                with PREPARING:
                    other = RepeatedEquation(self._given._replace(history=history, args=args))
                    result = other.solve()
                equation = other
        finally:
            if equation is not None:
                self._equation = equation
                self._free.append(equation)
        return result

    @property
    def problem(self):
        """The Problem of the last solve."""
        last = self._equation
        args = last.history.laid_out, *last.args
        return last.problem._replace(y0=last.history.y0.copy(), args=args)

    @property
    def y0(self):
        """The state at the start of the last solve."""
        return self._equation.history.y0

    @property
    def in_python(self):
        """Whether a function runs in Python."""
        return any(bound.callback is not None for bound in self._equation.run.bounds)

    def end(self, found):
        """The Ended of the last solve, whose result is `found`, and the time and state there."""
        ended, t, y = self._equation.end()
        if found.status == 1:  # at the last event
            ends = [(t[-1], y[-1]) for t, y in zip(found.t_events, found.y_events, strict=True)
                    if len(t)]  # fmt: skip
            t, y = max(ends, key=lambda each: each[0])
        return ended, t, y

    @filled()
    def many(self, histories=None, args=None) -> OdeResult:
        """Solve with many histories and many arguments, delays among them, one after the other.

        Parameters
        ----------
        histories : array_like, shape (m, n) or (n,), or callable, optional
            Constant histories, or one history for all solves; by default that of `prepare_dde`.
        {many}

        Raises
        ------
        ValueError
            If lengths do not agree.
        """
        from fastdyn.solve.many import one_by_one  # imports Numba

        given = self._given.history if histories is None else histories
        common = callable(given) or hasattr(given, "sol")
        states = self._equation.history.y0 if common else given
        members = Members(states, self._args if args is None else tuple(args))

        def solver(state, values):
            return self(given if common else state, values)

        return one_by_one(solver, self._equation.problem, members)
