"""The entry of `solve_ivp`, for calls with the function, method and tolerances of earlier calls.

State, span, times of output, arguments and closure may change from call to call.
"""

import types as python
from typing import Any

import numpy as np

from fastdyn.compile import memory
from fastdyn.compile.bind import leave_to_python
from fastdyn.compile.callables.diagnostics import GaveUp
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.compile.taylor.steps.accuracy import order_for
from fastdyn.compile.traced import met
from fastdyn.kernels.state.record import BAD_STATE
from fastdyn.problem.lsoda import NO_BAND
from fastdyn.run.solve_problem import WORDS, idle_run
from fastdyn.run.stiffness import notice, watch

from . import load
from .kept import LEFT_THEN, is_plain, kept_of
from .solver import entry_of, finished

TOLERANCES = {"rtol": 1e-3, "atol": 1e-6}  # the only options, and their defaults
LARGEST, SMALLEST = 2.0**60, 2.0**-60  # sizes of a state
_recent = memory.Table()  # by the code, the method, the options, and whether times are given


def solved(fun, t_span, y0, method, t_eval, args, options):
    """The result of a call of `solve_ivp` by its entry; None if no entry serves the call."""
    try:
        key = id(fun.__code__), method, t_eval is None, *options.items()
        found = _recent.get(key)
    except (AttributeError, TypeError):  # no function of Python's, or options without a hash
        return None
    if found is None or found.entry is None:
        return None
    return found.entry(y0, () if args is None else args, fun, t_span, t_eval)


def note(problem, method, options, result):
    """After the solve of a problem, prepare an entry for more calls of this kind."""
    if not (load.ON and _may_come_again(problem, options)):
        return
    key = id(problem.fun.__code__), method, problem.t_eval is None, *options.items()
    known = _recent.get(key)
    if known is None:
        _recent.put(key, Known(problem.fun.__code__), 1 + len(problem.y0) // WORDS)
    else:
        known.turn(problem, result)


def _may_come_again(problem, options):
    p = problem
    return (
        p.mode is DERIVATIVE and p.fun.__class__ is python.FunctionType
        and p.method.error_order and TOLERANCES.keys() >= options.keys()
        and p.rtol.__class__ is float and p.rtol == options.get("rtol", TOLERANCES["rtol"])
        and p.atol.__class__ is float and p.atol == options.get("atol", TOLERANCES["atol"])
        and p.atol > 0 and p.compile == "auto" and p.band == NO_BAND and is_plain(p)
    )  # fmt: skip


class Known:
    """Calls of one function with one method and options; `code` is kept alive: its id is a key."""

    entry: Any = None
    solver: Any = None

    def __init__(self, code):
        self.code, self.turns = code, 1

    def turn(self, problem, result):
        """Count a solve by Python; after some of the solves, try to make an entry."""
        self.turns += 1
        before = idle_run(problem)
        if before is None:  # a function runs in Python
            return
        for kept in self.solver.idle if self.solver else ():
            kept.words[LEFT_THEN] = met.N_LEFT[0]
        if self.turns & (self.turns - 1) == 0 and load.is_here():
            n_steps = min(result.n_accepted + result.n_rejected, before.n_first(problem))
            self.entry, self.solver = _entry(problem, before, before.spent / max(1, n_steps))


def _entry(problem, before, step):
    """The entry for calls like the call of a problem, and its Repeated; None if C cannot solve."""
    p = problem
    kept = kept_of(p)._replace(pairs=[])
    kept = kept.for_c(p.fun, p.args, step)
    if not kept.words.any():
        return None, None
    kept.take_spans(_sizes(p))
    stripped = kept.run.problem = p._replace(fun=None, args=(), y0=np.zeros(len(p.y0)), t_eval=None)
    kept.let_go()
    solver = Repeated(stripped, kept)
    return entry_of(solver, len(p.args)), solver


class Repeated:
    """The solver behind an entry: its run, and `finish`."""

    def __init__(self, problem, kept):
        self.problem, self.idle = problem, [kept]

    def finish(self, kept, status, fun, args):
        """The result of a solve whose first chunk C has taken; None if Python must solve again."""
        if status == BAD_STATE:
            self.idle.append(kept)
            return None
        run, y0 = kept.run, kept.own["room"].copy()
        p = kept.problem_of(self.problem)._replace(fun=fun, args=args, y0=y0)
        watch(p, run)
        try:
            result = finished(p, kept, status)
            notice(p, run)
        except GaveUp as reason:
            leave_to_python(reason.bound, reason)
            return None
        run.problem = self.problem
        kept.let_go()
        self.idle.append(kept)
        return result


def _sizes(problem):
    """The least and the largest size of a state for which the order of the series is unchanged."""
    p, (least, most) = problem, (SMALLEST, LARGEST)
    if not p.method.series:
        return None

    def order(size):
        return order_for(p.rtol, p.atol, np.array([size]))

    size = np.abs(p.y0).max() or 1.0
    least = most = size
    while least > SMALLEST and order(least / 2) == order(size):
        least /= 2
    while most < LARGEST and order(2 * most) == order(size):
        most *= 2
    return least, most
