"""numbalsoda from 0.3 on: LSODA in C++ and DOP853 in Fortran, the right-hand side a C function."""

import functools

import numpy as np
from numba import carray, cfunc, njit
from numbalsoda import dop853, lsoda, lsoda_sig

from ..problems import in_place
from . import MANY_ATOL, MANY_RTOL, MAX_STEPS
from .parameters import to_tuple_of

FIRST_CALL = {
    "numbalsoda": (
        "import numpy as np; from numba import cfunc; from numbalsoda import lsoda, lsoda_sig",
        """
@cfunc(lsoda_sig)
def fun(t, y, d, p):
    d[0] = y[1]
    d[1] = -{k} * y[0] - y[1] ** {power}
def solve():
    return lsoda(fun.address, np.array([1.0, 0.0]), np.linspace(0.0, 5.0, 2))
""",
    ),
}


def solvers(problem):
    """Both its methods."""
    rates = functools.cache(lambda: _compiled(problem))
    return {
        "numbalsoda LSODA": functools.partial(_prepare, problem, rates, lsoda),
        "numbalsoda DOP853": functools.partial(_prepare, problem, rates, dop853),
    }


def stiff(given):
    """LSODA, whose Jacobian is full and by differences."""
    p, rates = given.problem, functools.cache(lambda: _compiled(given.problem))
    if given.mass is not None or np.iscomplexobj(p.y0):
        return {}
    return {"numbalsoda LSODA": lambda tol: _prepare(p, rates, lsoda, tol, atol=tol * given.floor)}


def _compiled(problem):
    into, n = in_place(problem), len(problem.y0)

    @cfunc(lsoda_sig)
    def fun(t, y, d, p):
        into(t, carray(y, n), carray(d, n))

    return fun


def _prepare(problem, rates, solve, tol, times=None, atol=None):
    fun, none = rates(), np.zeros(1)
    y0 = np.array(problem.y0, dtype=float)
    times = np.array(problem.t_span if times is None else times)
    atol = tol if atol is None else atol

    def run():
        y, good = solve(fun.address, y0, times, none, tol, atol, MAX_STEPS)
        return y[-1] if good else np.nan

    return run


def trajectories(many):
    """DOP853, one after the other inside compiled code."""
    user, n, m = njit(many.fun), many.y0.shape[1], many.parameters.shape[1]
    to_tuple = to_tuple_of(m)

    @cfunc(lsoda_sig)
    def rates(t, y, d, p):
        found = user(t, carray(y, (n,)), *to_tuple(carray(p, (m,))))
        for i in range(n):
            d[i] = found[i]

    address, times = rates.address, np.array([0.0, many.t_end])

    @njit(nogil=True)
    def run(y0, parameters):
        out = np.empty_like(y0)
        for i in range(len(y0)):
            found, _ = dop853(address, y0[i], times, parameters[i], MANY_RTOL, MANY_ATOL)
            out[i] = found[-1]
        return out

    return {"numbalsoda DOP853": lambda: run(many.y0, many.parameters)}
