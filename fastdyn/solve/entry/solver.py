"""A solver of one problem for any state and arguments; C makes plain solves, Python the others."""

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.compile.bind import leave_to_python
from fastdyn.compile.callables.diagnostics import GaveUp
from fastdyn.kernels.state.record import BAD_STATE, FINISHED
from fastdyn.problem import validate
from fastdyn.run.loop import counters
from fastdyn.run.outcome import result_of

from . import load, objects
from .kept import LOOK, LOOK_EVERY, REST, SHORT, Kept, kept_of

FLOAT = np.dtype(float)
MOST_GIVEN = 5  # most arguments of an entry


class Solver:
    """``solve(y0, args)`` in Python, and `finish`, with which Python continues a solve of C.

    Attributes
    ----------
    idle : list of Kept
        The runs that no thread uses.
    """

    def __init__(self, problem):
        self.problem, self.shape = problem, problem.y0.shape
        self.idle = [kept_of(problem)]

    def entry(self):
        """``entry(y0, args)`` in C, which leaves other calls to `solve`; None without the code."""
        if not load.is_here():
            return None
        p, y0 = self.problem, np.empty(self.shape)
        y0[:] = p.y0  # keeps NumPy's own type object, which a copy may not
        return entry_of(self, len(p.args), (self.solve, p.fun, p.args, y0))

    def solve(self, y0=None, args=None):
        """Solve in Python."""
        p = self.problem
        if y0 is None:
            y0 = p.y0
        elif (
            y0.__class__ is not np.ndarray
            or y0.dtype is not FLOAT
            or y0.shape != self.shape
            or not y0.flags.c_contiguous
        ):
            y0 = self.state(y0)
        if args is None:
            args = p.args
        elif args.__class__ is not tuple:
            args = validate.extra_arguments(args)
        while True:
            try:
                return self._solved(y0, args)
            except GaveUp as reason:
                self._give_up(reason)

    def state(self, y0):
        """A state in the form that the kernel takes."""
        y0 = validate.initial_state(y0)
        if y0.shape != self.shape or y0.dtype.kind == "c":
            raise ValueError(f"`y0` must be {self.shape[0]} real numbers, as when it was prepared.")
        return y0

    def _give_up(self, reason):
        self.idle.clear()  # the idle runs call the compiled function
        leave_to_python(reason.bound, reason)

    def _solved(self, y0, args):
        try:
            kept = self.idle.pop()  # another thread may have taken the run
        except IndexError:
            kept = None
        if kept is None or not kept.take(args):
            kept = kept_of(self.problem._replace(y0=y0, args=args))
        run, p = kept.run, self.problem
        status = run.solve(y0)
        if status == BAD_STATE:
            self.idle.append(kept)
            self.state(y0)  # which raises
        if status != FINISHED:
            p = p._replace(y0=y0)
        result = result_of(p, status, run)
        self.idle.append(kept.given_back(p.fun, args))
        return result

    def finish(self, kept: Kept, status, fun, args):
        """The result of a solve whose first chunk C has taken, with this status."""
        if status == BAD_STATE:
            self.idle.append(kept)
            validate.initial_state(kept.own["room"].copy())  # which raises
        y0 = kept.own["room"].copy()
        try:
            result = finished(self.problem._replace(y0=y0, args=args), kept, status)
        except GaveUp as reason:
            self._give_up(reason)
            return self.solve(y0, args)
        kept.run.problem = self.problem
        self.idle.append(kept)
        return result


def finished(problem, kept, status):
    """Continue in Python a solve that C has begun; return the result."""
    run, p = kept.run, problem
    run.memory, run.problem = kept.own["memory"], p
    for bound in run.bounds:
        bound.keepalive[:] = p.fun, p.args, bound.function
    n_steps = int(kept.words[SHORT] + kept.words[REST])
    spent = kept.own["step"] * sum(counters(run.memory)[:2])
    if kept.words[LOOK] == 1:  # for all solves since the last look
        spent *= LOOK_EVERY
    status = run.solve(p.y0, (status, n_steps, spent))
    result = result_of(p, status, run)
    kept.renew()
    return result


def entry_of(solver, n_args, prepared=None):
    """The entry in C for a solver with `idle` and `finish`, for a function of `n_args` arguments.

    `prepared` has the function for slow calls, and the defaults of the user's function, its
    arguments and the state.  Without `prepared`, a call must give all of these, a span and times,
    and a call that is not plain returns None.
    """
    table, finish = objects.table(), solver.finish
    slow, *rest = prepared or (None,) * 4
    things = solver.idle, slow, finish, *rest
    addresses = [0 if thing is None else id(thing) for thing in things]
    words = address_of(table), *addresses, n_args, 2 if prepared else MOST_GIVEN
    return load.callable_of(np.array(words, np.int64), table, *things)
