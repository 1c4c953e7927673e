"""Breakpoints of equations whose index is reduced: algebraic components that are states jump there.

A component that a nonlinear equation determines is a state of the reduced equations, with the
derivative of the equation.  Behind a breakpoint the component is computed anew, as for BDF, with
the components held whose derivatives occur in F.  Constraints that hold no such state stay as they
are: if these jump, the run ends, see `history.along`.
"""

import numpy as np

from ..breakpoints import Breakpoints
from ..structure.start import Unsolved, consistent
from .trajectory import orders, places


class Borders:
    """The breakpoints of a reduced problem, and at which of them the state was computed anew."""

    def __init__(self, reduction):
        self._reduction = reduction
        self._breakpoints: Breakpoints | None = None
        self._starts: list = []

    def solved_behind(self, problem):
        """The Problem whose state is made consistent behind each breakpoint."""
        if len(problem.segments) < 2:
            return problem
        self._breakpoints = Breakpoints(problem)
        return self._breakpoints.scheduled(problem, self._again, behind=True)

    def of_result(self, found):
        """The result without the events of the breakpoints."""
        if self._breakpoints is not None and found.t_events is not None:
            found.t_events = found.t_events[:-1]
            found.y_events = found.y_events[:-1]
        return found

    def _again(self, t, x):
        system = self._reduction.system
        try:
            z = consistent(system, t, orders(system, x), self._reduction.differential)
        except Unsolved:
            return x
        self._starts.append(t)
        return z[places(system)]

    def before(self, t):
        """Times at which the equations hold; a breakpoint is the end of the step before."""
        return t if self._breakpoints is None else self._breakpoints.before(t)

    def beside(self, t):
        """The same for the times of a result, which may have a breakpoint twice."""
        return t if self._breakpoints is None else self._breakpoints.beside(t)

    def cuts(self, t):
        """The places in a result behind breakpoints at which the state was computed anew."""
        return np.flatnonzero(np.isin(self.beside(t), self._starts))
