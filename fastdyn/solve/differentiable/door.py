"""The `solve_ivp` of another library: its arguments and its documentation, for all libraries."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any

from .given import call_of
from .outputs import Solution

if TYPE_CHECKING:
    from fastdyn.problem.argument_types import Function, Functions, Method, Times, TimeSpan


def door(module, library, solve, ready=lambda: None, **words):
    """The public function of a module.

    Parameters
    ----------
    module : str
    library : given.Library
    solve : callable
        ``solve(call, arrays)`` is the Solution of a Call and the arrays that it is called with.
    ready : callable
        Raises where the library is set to other numbers.
    words : str
        The words in braces in the documentation.
    """

    def solve_ivp(
        fun: Function,
        t_span: TimeSpan,
        y0: Any,
        method: Method = "RK45",
        t_eval: Times | None = None,
        events: Functions | None = None,
        args: tuple = (),
        *,
        occurrences: int = 1,
        **options: Any,
    ) -> Solution:
        """Solve ``y' = fun(t, y, *args)`` as a function of {arrays}.

        Parameters
        ----------
        fun, t_span, method, events
            As in `fastdyn.solve_ivp`: `fun` is written with NumPy, and compiled by fastdyn.
        y0 : array_like, shape (n,)
            Initial state; {array} of float64, or a sequence with such numbers, may vary.
        t_eval : array_like, optional
            Times of output; by default the end of the span alone.
        args : tuple
            Arguments of `fun` and of the events; {arrays} of float64 may vary, also within dicts,
            lists, NamedTuples and dataclasses; all else is fixed.{shapes}
        occurrences : int
            The number of occurrences of each event that are returned.
        **options
            Tolerances and other options of `fastdyn.solve_ivp`, fixed.

        Returns
        -------
        Solution
            A NamedTuple of {arrays}{place}: `t`, `y` of shape (n, n_points), `t_events`,
            `y_events`, `status`.  Times of events are differentiated, too, and the states there as
            they move.  What a run does not reach is nan, as is all of a run that fails{use}.

        Raises
        ------
        TypeError, ValueError
            For float32 and integers that should vary, for {arrays} that `fun` takes from
            outside of `args`, and as `fastdyn.solve_ivp`.

        Notes
        -----
        Derivatives are those of `sensitivity`; those by more than eight numbers in reverse are
        those of `adjoint`, where it covers the problem.  They are of first order.{more}
        """
        ready()
        call, arrays = call_of(
            library, fun, t_span, y0, method, t_eval, events, args, occurrences, options
        )
        return solve(call, arrays)

    solve_ivp.__module__ = module
    solve_ivp.__qualname__ = "solve_ivp"
    if solve_ivp.__doc__:
        words = {"shapes": "", "place": "", "use": "", "more": "", **words}
        solve_ivp.__doc__ = inspect.cleandoc(solve_ivp.__doc__).format(**words)
    return solve_ivp
