"""Solves of one kind by runs that are ready, and when runs are made ready."""

from typing import Any

from fastdyn.compile.bind import leave_to_python
from fastdyn.compile.sentences import GaveUp, WritesToState

from .outcome import result_of
from .ready import ReadyRun

# A ReadyRun is made, in 0.3 ms, after so many solves in a row that went the long way.  The number
# doubles with each ReadyRun up to MOST_MISSES, and beyond for functions that get no ReadyRun.
FEWEST_MISSES, MOST_MISSES = 2, 8
# Solves in Python after which compiled code is looked for again, which takes 0.3 to 0.7 ms.
FEWEST_IN_PYTHON, MOST_IN_PYTHON = 8, 256


class Solver:
    """Makes solves of one kind on Runs that are ready.

    Attributes
    ----------
    problem : validate.Problem
        The problem of all solves, whose values solves replace.
    idle : list of ReadyRun
        The runs that no thread uses.
    """

    problem: Any

    def __init__(self):
        self.idle: list[ReadyRun] = []
        self._misses, self._most, self._is_refused = 0, FEWEST_MISSES, True
        self._lasts = FEWEST_IN_PYTHON

    def solve(self, fun, y0, args, others=(), t_span=None, t_eval=None):
        """The result of a solve; None if it needs the long way.

        `others` are the functions that are called between steps.
        """
        idle = self.idle
        try:
            ready = idle.pop()
        except IndexError:  # there is none, or other threads have them
            return None
        result = ready.go(fun, y0, args, others, t_span, t_eval)
        if ready.left > 0:
            idle.append(ready)
        if self._misses and result is not None:
            self._misses = 0
        return result

    def prepare(self, problem):
        """Prepare a run before the first solve."""
        self._most = 1
        self.count(problem)

    def count(self, problem):
        """Count a solve that went the long way; perhaps prepare a run for more solves like it.

        That is after some such solves in a row, as values of other types may have come to stay, and
        if other threads have all runs.
        """
        self._misses += 1
        if self._misses >= self._most:
            self.idle, self._misses = self._for_a_while(self.ready(problem)), 0
            self._is_refused = not self.idle
            self._most *= 2 if self._is_refused or self._most < MOST_MISSES else 1
        elif not (self.idle or self._is_refused):
            self.idle += self._for_a_while(self.ready(problem))

    def _for_a_while(self, made):
        """ReadyRuns; those of functions in Python for twice as many solves as the last ones."""
        for ready in made:
            if ready.in_python:
                ready.left = self._lasts
                self._lasts = min(2 * self._lasts, MOST_IN_PYTHON)
        return made

    def ready(self, problem) -> list[ReadyRun]:
        """A ReadyRun for a problem, or none if no solve of the problem is plain."""
        raise NotImplementedError

    def present(self, ready, fun, args, others):
        """The problem of the solve that a ReadyRun has begun."""
        raise NotImplementedError

    def goes_on(self, problem, run):
        """Called before a solve goes on after its first chunk."""

    def ended(self, problem, run):
        """Called after such a solve."""

    def finish(self, ready, memory, status, fun, args, others):
        """The result of a solve after its first chunk of steps; None if the code gave up."""
        if (run := ready.run).doubts(memory):
            return None
        p = self.present(ready, fun, args, others)
        for bound, function in zip(run.bounds, (fun, *others), strict=True):
            bound.held.take(function, args)
        self.goes_on(p, run)
        try:
            result = result_of(p, ready.go_on(p, memory, status), run)
            self.ended(p, run)
        except WritesToState:  # of a function that has not written before: SciPy solves
            return None
        except GaveUp as reason:
            result = None
            if not p.mode.sensitivities:  # these are not computed in Python
                leave_to_python(reason.bound, reason)
        ready.lay()
        return result
