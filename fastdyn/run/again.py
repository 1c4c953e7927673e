"""The same call again: one store of what a call of a known kind finds ready.

A kind is known by its key: the door, ids of the code of functions, lengths, options.  The values of
a call (state, arguments, closures, outside values) are in no key; they are read at each call.
"""

import functools
import types as python
from typing import Any

from fastdyn.compile import memory
from fastdyn.compile.bind import leave_to_python
from fastdyn.compile.callables import is_jitted
from fastdyn.compile.sentences import GaveUp, WritesToState
from fastdyn.problem.events import Event, with_functions

from .ready import ReadyRun
from .stiffness import notice, unexamined, watch

WORDS = 1000  # a state of so many words counts as much as a small run

# A ReadyRun is made, in 0.3 ms, after so many solves in a row that went the long way.  The number
# doubles with each ReadyRun up to MOST_MISSES, and beyond for functions that get no ReadyRun.
FEWEST_MISSES, MOST_MISSES = 2, 8
# Solves in Python after which compiled code is looked for again, which takes 0.3 to 0.7 ms.
FEWEST_IN_PYTHON, MOST_IN_PYTHON = 8, 256

calls = memory.Table()  # of Kinds, by their keys


class Kind:
    """What calls of one kind share.

    Attributes
    ----------
    idle : list
        The runs that no thread has, without objects of the user.  A thread has a run from `pop` on
        until the run is in the list again.
    codes : sequence of code
        These are kept alive, because their ids are in the key.
    """

    def __init__(self, codes=()):
        self.idle: list[Any] = []
        self.codes = codes

    def give_back(self, run):
        """Keep a run for the next call, unless one waits already."""
        if not self.idle:
            self.idle.append(run)


def taken(kind) -> Any:
    """A run of a Kind, or of None, which no other thread has; None if there is none."""
    try:
        return kind.idle.pop()
    except (AttributeError, IndexError):
        return None


def kept(key, make, n) -> Any:
    """The Kind of a key: the known one, or a new one, for runs of n components."""
    found = calls.get(key)
    return calls.put(key, make(), 1 + n // WORDS) if found is None else found


def keyed_code(fun) -> Any:
    """The code of a callable: of a partial that of its function, of an object that of its class.

    Raises
    ------
    AttributeError
        The callable has no code.
    """
    kind = fun.__class__
    if kind is python.FunctionType or kind is python.MethodType or is_jitted(fun):
        return fun.__code__
    if kind is Event:
        return keyed_code(fun.function)
    return keyed_code(fun.func) if kind is functools.partial else kind.__call__.__code__


class Solver(Kind):
    """Makes solves of one kind on Runs that are ready.

    Attributes
    ----------
    problem : validate.Problem
        The problem of all solves, whose values solves replace.
    """

    problem: Any
    idle: list[ReadyRun]

    def __init__(self, codes=()):
        super().__init__(codes)
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
        p = self.problem
        y0 = ready.room[: len(p.y0)].copy()
        if others or p.schedules:  # those of the span of the run
            p = with_functions(p._replace(schedules=ready.problem.schedules), others)
        return p._replace(fun=fun, args=args, y0=y0, **ready.taken())

    def ended(self, problem, run):
        """Called after a solve that went on after its first chunk."""
        notice(problem, run)

    def finish(self, ready, memory, status, fun, args, others):
        """The result of a solve after its first chunk of steps; None if the code gave up."""
        if (run := ready.run).doubts(memory):
            return None
        p = self.present(ready, fun, args, others)
        for bound, function in zip(run.called, (fun, *others), strict=True):
            bound.held.take(function, args)
        watch(p, run)
        try:
            result = ready.finished(p, ready.go_on(p, memory, status))
            self.ended(p, run)
            ready.most = unexamined(p, run)
        except WritesToState:  # of a function that has not written before: SciPy solves
            ready.left = 0  # the exception, which its callback keeps, holds what the user gave
            return None
        except GaveUp as reason:
            result = None
            if not p.mode.sensitivities:  # these are not computed in Python
                leave_to_python(reason.bound, reason)
        ready.lay()
        return result
