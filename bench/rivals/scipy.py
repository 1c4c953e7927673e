"""SciPy: solve_ivp with plain and with compiled right-hand sides; its compiled loops of old."""

import functools

import numpy as np
import scipy
import scipy.sparse
from numba import njit
from scipy.integrate import ode, odeint, solve_ivp

from ..problems import compiled
from ..problems.hybrids import in_place_with_discrete
from . import MANY_ATOL, MANY_RTOL, MAX_STEPS

SCIPY = tuple(map(int, scipy.__version__.split(".")[:2]))
FIRST_CALL = {
    "SciPy": (
        "import scipy.integrate",
        """
def fun(t, y):
    return [y[1], -{k} * y[0] - y[1] ** {power}]
def solve():
    return scipy.integrate.solve_ivp(fun, (0.0, 5.0), [1.0, 0.0])
""",
    ),
    "SciPy, njit": (
        "import numba, numpy as np, scipy.integrate",
        """
@numba.njit
def fun(t, y):
    return np.array([y[1], -{k} * y[0] - y[1] ** {power}])
def solve():
    return scipy.integrate.solve_ivp(fun, (0.0, 5.0), [1.0, 0.0])
""",
    ),
}


def end_of(result):
    """The last state of a result of solve_ivp, NaN if it failed."""
    return result.y[:, -1] if result.success else np.nan


def stiff(given):
    """Radau, BDF and LSODA on a compiled right-hand side, told of the band; BDF if complex."""
    p, jitted = given.problem, functools.cache(lambda: compiled(given.problem))
    if given.mass is not None or given.long:
        return {}
    n, (lower, upper) = len(p.y0), given.band or (0, 0)

    def prepare(method, tol):
        fun, options = jitted(), {"rtol": tol, "atol": tol * given.floor}
        if given.band and method == "LSODA":
            options |= {"lband": lower, "uband": upper}
        elif given.band:
            shape = {"shape": (n, n), "format": "csc"}
            bands = np.ones((lower + upper + 1, n))
            options["jac_sparsity"] = scipy.sparse.diags(bands, range(-lower, upper + 1), **shape)
        return lambda: end_of(
            solve_ivp(fun, p.t_span, p.y0, method, t_eval=p.t_span[1:], **options)
        )

    names = ("BDF",) if np.iscomplexobj(p.y0) else ("Radau", "BDF", "LSODA")
    return {f"SciPy {name}, njit": functools.partial(prepare, name) for name in names}


def solvers(problem):
    """RK45, DOP853 and LSODA by solve_ivp; LSODA by odeint; Hairer's DOP853 by ode."""
    jitted = functools.cache(lambda: compiled(problem))
    made = {}
    for method in ("RK45", "DOP853", "LSODA"):
        made[f"SciPy {method}"] = functools.partial(_ivp, problem, method, None)
        made[f"SciPy {method}, njit"] = functools.partial(_ivp, problem, method, jitted)
    made["SciPy odeint, njit"] = functools.partial(_odeint, problem, jitted)
    if SCIPY >= (
        1,
        17,
    ):  # the Fortran code of earlier SciPy miscounts the arguments
        made["Hairer's DOP853, njit"] = functools.partial(_hairer, problem, jitted)
    return made


def _ivp(problem, method, jitted, tol, times=None):
    end = problem.t_span[1]
    given = {
        "method": method,
        "rtol": tol,
        "atol": tol,
        "t_eval": [end] if times is None else times,
    }
    fun = problem.fun
    if jitted is not None:
        fun = jitted()
    else:
        given["args"] = problem.args
    return lambda: end_of(solve_ivp(fun, problem.t_span, problem.y0, **given))


def _odeint(problem, jitted, tol, times=None):
    fun, times = jitted(), problem.t_span if times is None else times
    given = {"tfirst": True, "rtol": tol, "atol": tol, "mxstep": MAX_STEPS, "full_output": True}

    def run():
        y, told = odeint(fun, problem.y0, times, **given)
        return (
            y[-1] if told["message"] == "Integration successful." else np.full(y[-1].shape, np.nan)
        )

    return run


def _hairer(problem, jitted, tol, times=None):
    if times is not None:
        return None
    fun, (begin, end), y0 = jitted(), problem.t_span, np.array(problem.y0)

    def run():
        solver = ode(fun).set_integrator("dop853", rtol=tol, atol=tol, nsteps=MAX_STEPS)
        return solver.set_initial_value(y0, begin).integrate(end)

    return run


def one_by_one(many):
    """A function of nothing that solves all, one after the other."""
    fun, span = many.fun, (0.0, many.t_end)
    given = {"rtol": MANY_RTOL, "atol": MANY_ATOL}

    def run():
        return np.array([
            solve_ivp(fun, span, y, args=tuple(p), **given).y[:, -1]
            for y, p in zip(many.y0, many.parameters, strict=True)
        ])  # fmt: skip

    return run


def hybrid(given):
    """A loop in Python over the samples, or the impacts: a solve for each, compiled equations."""
    h, act = given, given.act(np)

    @functools.cache
    def jitted():
        into, n = in_place_with_discrete(h.fun, len(h.y0)), len(h.y0)

        @njit
        def fun(t, y, d):
            out = np.empty(n)
            into(t, y, d, out)
            return out

        return fun

    def to(method, fun, t, end, y, d, tol):
        if method == "odeint":
            found = odeint(fun, y, (t, end), (d,), tfirst=True, rtol=tol, atol=tol)
            return end, found[-1]
        events = None if h.period else _on_the_ground
        run = solve_ivp(
            fun, (t, end), y, method, args=(d,), events=events, rtol=tol, atol=tol,
        )  # fmt: skip
        return run.t[-1], run.y[:, -1]

    def prepare(method, tol):
        fun = jitted()

        def run():
            t, y, d, k = 0.0, np.array(h.y0), np.array(h.d0), 0
            while t < h.end:
                if h.period is not None or k:
                    y, d = map(np.array, act(t, y, d))
                k += 1
                end = h.end if h.period is None else min(k * h.period, h.end)
                t, y = to(method, fun, t, end, y, d, tol)
            return y

        return run

    names = ("RK45", "DOP853", *(["odeint"] if h.period else []))
    return {f"SciPy {name} in a loop, njit": functools.partial(prepare, name) for name in names}


def _on_the_ground(t, y, d):
    return y[0]


vars(_on_the_ground).update(direction=-1, terminal=True)
