"""Functions of `on_event`, and breakpoints: the state behind them satisfies the equations."""

import numpy as np

from fastdyn.compile.functions import with_callback
from fastdyn.compile.mode import JUMP
from fastdyn.compile.python_callback import Callback, Held, derivative

from .consistent import consistent_behind


def with_jumps(problem, change):
    """The problem with ``change(jump)`` in the place of each function that acts; None stays."""
    events = problem.events and [event.acting(change) for event in problem.events]
    schedules = [each._replace(jump=each.jump and change(each.jump)) for each in problem.schedules]
    return problem._replace(events=events, schedules=tuple(schedules))


def with_acting(problem, others):
    """The Bounds of all functions between steps, from those of a problem without jumps.

    The jumps of `problem` run in Python.
    """
    n = len(problem.events or ())
    jumps = [jump for jump in problem.jumps if jump is not None]
    if problem.checkpoint is not None and jumps:
        raise ValueError(
            "`checkpoint` of `solve_dae` does not go with `on_event`, schedules that act, nor, at "
            "index 0 and 1, with `breakpoints`: the state behind them is computed in Python, and a "
            "file does not tell one function of Python from another."
        )
    acting = [_in_python(jump, problem.args, len(problem.y0)) for jump in jumps]
    return [*others[:n], *acting, *others[n:]]


def consistent_jump(problem, equations, act):
    """The function of [y, y'] for the user's function of y.

    Components whose derivatives occur in F are held, others and all derivatives are computed.
    """
    n = equations.n

    def jump(t, both, *args):
        y = derivative(act(t, both[:n].copy(), *args), n, JUMP)
        if not np.isfinite(y).all():
            return np.concatenate([y, both[n:]])  # the run ends and says why
        return consistent_behind(equations, problem, t, np.concatenate([y, both[n:]]))

    return jump


def _in_python(jump, args, n):
    """The Bound of a function of n numbers that runs in Python."""
    held = Held(jump, args)

    def as_written(t, both):
        return held.fun(t, both, *held.args)

    callback = Callback(as_written, JUMP, n)
    return with_callback(callback, as_written, held, JUMP)
