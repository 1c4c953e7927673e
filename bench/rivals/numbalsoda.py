"""numbalsoda from 0.3 on: LSODA in C++ and DOP853 in Fortran, the right-hand side a C function."""

import functools

import numpy as np
from numba import carray, cfunc
from numbalsoda import dop853, lsoda, lsoda_sig

from ..problems import in_place
from . import MAX_STEPS


def solvers(problem):
    """Both its methods."""

    @functools.cache
    def rates():
        into, n = in_place(problem), len(problem.y0)

        @cfunc(lsoda_sig)
        def fun(t, y, d, p):
            into(t, carray(y, n), carray(d, n))

        return fun

    return {
        "numbalsoda LSODA": functools.partial(_prepare, problem, rates, lsoda),
        "numbalsoda DOP853": functools.partial(_prepare, problem, rates, dop853),
    }


def _prepare(problem, rates, solve, tol, times=None):
    fun, none = rates(), np.zeros(1)
    y0 = np.array(problem.y0, dtype=float)
    times = np.array(problem.t_span if times is None else times)

    def run():
        y, good = solve(fun.address, y0, times, none, tol, tol, MAX_STEPS)
        return y[-1] if good else np.nan

    return run
