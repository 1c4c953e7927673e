"""Solves in which Python code of the user runs between evaluations of compiled functions."""

import contextlib
from typing import Any

from fastdyn.compile.bind import leave_to_python
from fastdyn.compile.sentences import GaveUp
from fastdyn.compile.traced.known import Attempt
from fastdyn.specialise.series import NoSeries

from .followed import followed, functions_of, may_take_other_code

FEW = 64  # components, up to which a Jacobian by differences costs little


def of_python_between(problem, bound, others):
    """The problem, adapted to Python code that runs between evaluations of compiled functions.

    Such code may change values so that the equations need other code, with another Jacobian and
    another Taylor series.
    """
    p = problem
    if p.callback is None and all(b.function is not None for b in others):
        return p
    if not may_take_other_code(bound):
        return p
    if p.method.series:
        raise NoSeries(
            "Taylor keeps to the formulas with which a solve begins, and here Python functions run "
            "meanwhile that may change what `fun` uses. Take Vern9 instead."
        )
    if p.method.n_matrices and p.jac is None and len(p.y0) <= FEW:
        return p._replace(differences=True)
    return p


class PythonBetween:
    """The part of a Run that follows compiled functions while Python code runs."""

    problem: Any
    bounds: Any
    _own: Any
    _others: Any
    callbacks: Any
    _followed: Any = None
    _watched: Any = None

    def _follow(self, problem, bound, others):
        """Arrange that compiled functions are followed whenever a function has run in Python."""
        if self.callbacks or problem.callback is not None:
            self._followed = followed(problem, bound, others, self._take_over)
        if self._followed:
            for callback in self.callbacks:
                callback.after = self.follow_again

    def follow_again(self):
        """Let compiled functions read their outside values again, after Python code ran."""
        for function in self._followed or ():
            function()

    def compiled(self):
        """The present Bounds of all compiled functions."""
        if self._followed is not None:
            return [each.bound for each in self._followed if each.bound.function is not None]
        return [b for b in self.bounds if b.function is not None and not b.pair]

    def holds(self):
        """Let compiled functions read their outside values again; True if all keep their code."""
        if self._watched is None:
            self._watched = followed(self.problem, self._own, self._others, self._take_over)
        kept = [function.holds() for function in self._watched]
        return all(kept)

    def _take_over(self, callback):
        """Let a function run in Python from now on."""
        callback.after = self.follow_again
        self.callbacks.append(callback)

    @contextlib.contextmanager
    def not_repeated(self):
        """Raise RuntimeError instead of GaveUp if a solve cannot be repeated in Python."""
        try:
            yield
        except GaveUp as reason:
            p = self.problem
            n = len(self.problem.y0)
            functions = functions_of(p, self._own, self._others)
            in_python = [Attempt(f, p.args, b.mode, n) for b, f in functions if b.function is None]
            if any(attempt.may_act() for attempt in in_python):
                leave_to_python(reason.bound, reason)
                raise RuntimeError(
                    f"{reason}, and the solve is not repeated in Python, because its functions "
                    "have changed what they use; the next solve runs in Python."
                ) from None
            raise
