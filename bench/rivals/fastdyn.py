"""fastdyn itself, through its public calls; the methods are those it has."""

import functools

import fastdyn
from fastdyn.kernels.methods import METHODS

from ..problems import compiled
from .scipy import end_of

PAIRS = [name for name, m in METHODS.items() if m.error_order and name not in ("RK23", "ode45")]


def solvers(problem):
    """Each embedded pair, prepared as the rivals are, and RK45 through the plain call.

    The right-hand side is in plain Python, that of many components compiled.
    """
    if problem.into is not None:
        problem = problem._replace(fun=compiled(problem))
    made = {f"fastdyn {name}": functools.partial(_prepared, problem, name) for name in PAIRS}
    return made | {"fastdyn RK45 by solve_ivp": functools.partial(_plain, problem, "RK45")}


def _given(problem, method, tol, times):
    """What both calls are given."""
    return {
        "fun": problem.fun, "t_span": problem.t_span, "y0": problem.y0, "method": method,
        "t_eval": problem.t_span[1:] if times is None else times, "args": problem.args,
        "rtol": tol, "atol": tol,
    }  # fmt: skip


def _prepared(problem, method, tol, times=None):
    solve = fastdyn.prepare(**_given(problem, method, tol, times))
    return lambda: end_of(solve())


def _plain(problem, method, tol, times=None):
    given = _given(problem, method, tol, times)
    fastdyn.solve_ivp(**given, tier="specialised")
    return lambda: end_of(fastdyn.solve_ivp(**given))
