"""The hand-written C++ with SciPy's step control, by the first compiler there is."""

import functools

from .. import cpp
from ..problems import BODIES, CHAIN


def solvers(problem):
    """DOPRI5, and DOP853 for a number of components known when compiled."""
    if not problem.code or not cpp.libraries():
        return {}
    orders = {"C++ RK45": 5}
    if problem.code not in (BODIES, CHAIN):
        orders["C++ DOP853"] = 8
    return {name: functools.partial(_prepare, problem, order) for name, order in orders.items()}


def _prepare(problem, order, tol, times=None):
    if times is not None:
        return None
    solve = next(iter(cpp.solvers(problem, order, tol, tol).values()))
    return lambda: solve()[0]
