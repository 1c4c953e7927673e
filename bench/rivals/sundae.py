"""CVODE of SUNDIALS, Adams' methods for problems that are not stiff, by scikit-sundae."""

import functools

import numpy as np
from sksundae.cvode import CVODE

from ..problems import in_place
from . import MAX_STEPS

DENSE = 100  # up to so many components Newton's matrix is a matrix

FIRST_CALL = {
    "CVODE, njit": (
        "import numba, numpy as np; from sksundae.cvode import CVODE",
        """
@numba.njit
def fun(t, y, d):
    d[0] = y[1]
    d[1] = -{k} * y[0] - y[1] ** {power}
def solve():
    return CVODE(fun, method="Adams").solve([0.0, 5.0], np.array([1.0, 0.0]))
""",
    ),
}


def stiff(given):
    """CVODE's BDF; the Jacobian by differences, banded for problems by the method of lines."""
    p, into = given.problem, functools.cache(lambda: in_place(given.problem))
    line = {} if p.into is None else {"linsolver": "band", "lband": 2, "uband": 2}

    def prepare(tol):
        y0 = np.array(p.y0, dtype=float)
        options = {"rtol": tol, "atol": tol * given.floor, "max_num_steps": MAX_STEPS, **line}
        solver = CVODE(into(), method="BDF", **options)

        def run():
            solver.init_step(p.t_span[0], y0)
            return solver.step(p.t_span[1], tstop=p.t_span[1]).y

        return run

    return {"CVODE BDF, njit": prepare}


def solvers(problem):
    """Adams, with the right-hand side compiled; CVODE calls it through Python."""
    into = functools.cache(lambda: in_place(problem))
    return {"CVODE Adams, njit": functools.partial(_prepare, problem, into)}


def _prepare(problem, into, tol, times=None):
    (begin, end), y0 = problem.t_span, np.array(problem.y0, dtype=float)
    solver = CVODE(
        into(), method="Adams", rtol=tol, atol=tol, max_num_steps=MAX_STEPS,
        linsolver="dense" if y0.size <= DENSE else "gmres",
    )  # fmt: skip

    def run():
        if times is not None:
            return solver.solve(times, y0).y[-1]
        solver.init_step(begin, y0)
        return solver.step(end, tstop=end).y

    return run
