"""Repeated calls of `odeint`: the same function, lengths and options, other values."""

from typing import Any

import numpy as np

from fastdyn.run import again
from fastdyn.run.again import keyed_code
from fastdyn.solve.repeated import Repeated

from .order import time_first

FLOAT = np.dtype(float)
ARRAY = np.ndarray


def key_of(func, y0, t, args, limits):
    """The key of a call; None for what has no length, or no code."""
    try:
        n = -1 if y0.__class__ in (float, int) else len(y0)
        return "odeint", func.__class__, id(keyed_code(func)), n, len(t), len(args), limits
    except (AttributeError, TypeError):
        return None


def solved(key, func, y0, t, args, tfirst):
    """What `Again.rows` returns, of a call like an earlier one; None for the long way."""
    try:
        found = again.calls.get(key)
    except TypeError:  # tolerances without a hash
        return None
    if found is None:
        return None
    if y0.__class__ in (float, int):
        y0 = [y0]
    if t.__class__ is not ARRAY or t.dtype != FLOAT:
        try:
            t = np.array(t, dtype=float)
        except (TypeError, ValueError):
            return None
    if t.ndim != 1 or t[1] == t[0]:
        return None
    return found.rows(time_first(func, tfirst), y0, args, t)


def note(key, func, problem):
    """After a solve the long way, prepare for more calls of the kind."""
    p = problem
    if not (p.rtol.__class__ is float is p.atol.__class__ and p.atol > 0.0):
        return
    if p.callback is not None or p.t_eval[0] == p.t0:
        return
    try:
        found = again.kept(key, lambda: Again(problem, keyed_code(func)), len(p.y0))
    except TypeError:  # tolerances without a hash
        return
    found.count(problem)


class Again(Repeated):
    """Calls of one kind; the code of the user's function is kept alive, as its id is in the key."""

    def __init__(self, problem, code):
        super().__init__(problem, {"max_step": problem.h_max})
        self.codes = [keyed_code(problem.fun), code]

    def rows(self, fun, y0, args, t):
        """The rows of a solve, and the states of the solver if they are asked for; or None."""
        found: Any = self.solve(fun, y0, args, (), (float(t[0]), float(t[-1])), t[1:])
        told = None
        if found.__class__ is tuple:
            rows, told = found
        elif found is None or found.status != 0 or self.problem.told is not None:
            return None
        else:
            rows = np.empty((len(t), len(found.y)))
            rows[1:] = found.y.T
        rows[0] = y0
        return rows, told

    @staticmethod
    def make(problem, plan, own=None):
        """``rows(memory, ...)``: an array whose first row is left free, and the states of the
        solver if they are asked for."""
        shape = (len(problem.t_eval) + 1, plan.n)
        view = plan.view
        told = problem.told

        def rows(memory, *_):
            found = np.empty(shape)
            found[1:] = view(memory, "output.y")
            return found, None if told is None else told.copy()

        return rows
