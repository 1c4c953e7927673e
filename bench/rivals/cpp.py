"""The hand-written C++ with SciPy's step control, by the first compiler there is."""

import functools

from ..cpp import build, calls
from ..problems import BODIES, CHAIN
from . import MANY_ATOL, MANY_RTOL


def solvers(problem):
    """DOPRI5, and DOP853 for a number of components known when compiled."""
    if not problem.code or not build.libraries():
        return {}
    orders = {"C++ RK45": 5}
    if problem.code not in (BODIES, CHAIN):
        orders["C++ DOP853"] = 8
    return {name: functools.partial(_prepare, problem, order) for name, order in orders.items()}


def _prepare(problem, order, tol, times=None):
    if times is not None:
        return None
    solve = next(iter(calls.solvers(problem, order, tol, tol).values()))
    return lambda: solve()[0]


def trajectories(many):
    """One trajectory after the other, and eight at once by hand, by every compiler."""
    runs = {}
    for name, (each, lanes) in calls.batches().items():
        runs[f"C++ {name}"] = calls.together(each, many, MANY_RTOL, MANY_ATOL)
        runs[f"C++ {name}, 8 lanes by hand"] = calls.together(lanes, many, MANY_RTOL, MANY_ATOL)
    return runs


def delays(given):
    """DOPRI5 and its interpolant, steps no longer than the least delay."""
    if not build.libraries():
        return {}
    return {"C++ RK45": functools.partial(calls.delayed, given)}
