"""fastdyn itself, through its public call; the methods are those it has."""

import functools

import fastdyn
from fastdyn.kernels import METHODS

from ..problems import compiled
from .scipy import end_of

PAIRS = [name for name, m in METHODS.items() if m.error_order and name not in ("RK23", "ode45")]


def solvers(problem):
    """Each embedded pair; the right-hand side in plain Python, that of many components compiled."""
    if problem.into is not None:
        problem = problem._replace(fun=compiled(problem))
    return {f"fastdyn {name}": functools.partial(_prepare, problem, name) for name in PAIRS}


def _prepare(problem, method, tol, times=None):
    end = problem.t_span[1]
    given = {
        "method": method, "rtol": tol, "atol": tol, "args": problem.args,
        "t_eval": [end] if times is None else times,
    }  # fmt: skip
    fastdyn.solve_ivp(problem.fun, problem.t_span, problem.y0, **given, tier="specialised")

    return lambda: end_of(fastdyn.solve_ivp(problem.fun, problem.t_span, problem.y0, **given))
