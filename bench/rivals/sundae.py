"""CVODE and IDA of SUNDIALS, Adams' methods for problems that are not stiff, by scikit-sundae."""

import functools

import numpy as np
from numba import njit
from sksundae.cvode import CVODE
from sksundae.ida import IDA

from ..problems import in_place
from . import MAX_STEPS

DENSE_JACOBIAN = 200  # an exact one is handed over as n by n numbers, banded or not
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
    """CVODE's BDF, the Jacobian by differences or exact, banded where it is; IDA for DAEs."""
    p, into = given.problem, functools.cache(lambda: in_place(given.problem))
    if np.iscomplexobj(p.y0):
        return {}
    if given.mass is not None:
        return {"IDA, njit": functools.partial(_ida, given, into)}
    band = {}
    if given.band:
        band = {"linsolver": "band", "lband": given.band[0], "uband": given.band[1]}
    made = {"CVODE BDF, njit": functools.partial(_bdf, given, into, band)}
    if given.jacobian is not None and len(p.y0) <= DENSE_JACOBIAN:
        jacobian = functools.cache(lambda: _with_ignored_slope(given.jacobian))
        name = "CVODE BDF, njit, exact Jacobian"
        made[name] = lambda tol: _bdf(given, into, band | {"jacfn": jacobian()}, tol)
    return made


def _with_ignored_slope(jacobian):
    """As CVODE calls it."""
    inner = njit(jacobian)

    @njit
    def jacfn(t, y, d, j):
        inner(t, y, j)

    return jacfn


def _bdf(given, into, more, tol):
    p, y0 = given.problem, np.array(given.problem.y0, dtype=float)
    options = {"rtol": tol, "atol": tol * given.floor, "max_num_steps": MAX_STEPS, **more}
    solver = CVODE(into(), method="BDF", **options)

    def run():
        solver.init_step(p.t_span[0], y0)
        return _end_of(solver.step(p.t_span[1], tstop=p.t_span[1]))

    return run


def _end_of(result):
    return result.y if result.success else np.nan


def _ida(given, into, tol):
    """M y' - f = 0; the algebraic variables are those whose column of M is zero."""
    p, y0, mass, rates = given.problem, np.array(given.problem.y0), given.mass, into()
    start = np.empty_like(y0)
    rates(p.t_span[0], y0, start)
    slopes = np.linalg.lstsq(mass, start, rcond=None)[0]

    @njit
    def residual(t, y, slope, out):
        rates(t, y, out)
        for i in range(len(y)):
            out[i] = -out[i]
            for j in range(len(y)):
                out[i] += mass[i, j] * slope[j]

    solver = IDA(
        residual, rtol=tol, atol=tol * given.floor, max_num_steps=MAX_STEPS,
        algebraic_idx=np.flatnonzero(~mass.any(axis=0)).tolist(),
    )  # fmt: skip

    def run():
        solver.init_step(p.t_span[0], y0, slopes)
        return _end_of(solver.step(p.t_span[1], tstop=p.t_span[1]))

    return run


def dae(given):
    """IDA, with the residual compiled, and its Jacobian by differences."""

    @functools.cache
    def residual():
        inner = njit(given.F)

        @njit
        def into(t, y, slope, out):
            found = inner(t, y, slope)
            for i in range(len(y)):
                out[i] = found[i]

        return into

    def prepare(tol):
        solver = IDA(
            residual(), rtol=tol, atol=tol * np.asarray(given.floor), max_num_steps=MAX_STEPS
        )
        y0, slopes = np.array(given.y0, float), np.array(given.yp0, float)

        def run():
            solver.init_step(0.0, y0, slopes)
            return _end_of(solver.step(given.end, tstop=given.end))

        return run

    return {"IDA, njit": prepare}


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
