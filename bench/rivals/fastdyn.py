"""fastdyn itself, through its public calls; the methods are those it has."""

import functools
import time

import numpy as np

import fastdyn
from fastdyn.delays import prepare_dde
from fastdyn.kernels.methods import COMPLEX, METHODS
from fastdyn.planets import Planets

from ..problems import compiled, outer_planets
from . import MANY_ATOL, MANY_RTOL
from .scipy import end_of

STIFF = ("Radau", "BDF", "Rodas5P", "LSODA")
PAIRS = [
    name for name, m in METHODS.items() if m.error_order and name not in ("RK23", "ode45", *STIFF)
]

SOLVE = """
options = {{}} if fastdyn.METHODS["{method}"].error_order else {{"step": 0.01}}
def solve():
    return fastdyn.solve_ivp(fun, (0.0, 5.0), [1.0, 0.0], "{method}", **options)
"""
FIRST_CALL = {
    "fastdyn": (
        "import fastdyn",
        """
def fun(t, y):
    return [y[1], -{k} * y[0] - y[0] ** {power}]
"""
        + SOLVE,
    ),
    "fastdyn, a function for Numba": (
        "import math, fastdyn",
        """
def fun(t, y):
    x, change = t, 1.0
    while abs(change) > 1e-12:
        change = (x - 0.5 * math.sin(x) - t) / (1.0 - 0.5 * math.cos(x))
        x -= change
    return [y[1], -{k} * y[0] - y[1] ** {power} + x]
"""
        + SOLVE,
    ),
}


def solvers(problem):
    """Each embedded pair, prepared as the rivals are, and RK45 through the plain call.

    The right-hand side is in plain Python, that of many components compiled, but for Taylor.
    """
    fast = problem if problem.into is None else problem._replace(fun=compiled(problem))
    made = {f"fastdyn {name}": functools.partial(_prepared, fast, name) for name in PAIRS}
    made["fastdyn Taylor"] = functools.partial(_prepared, problem, "Taylor")
    return made | {"fastdyn RK45 by solve_ivp": functools.partial(_plain, fast, "RK45")}


def stiff(given, names=STIFF):
    """Those of STIFF, unless others are named; where the state is complex, those for it."""
    p = given.problem
    fun = p.fun if p.into is None else compiled(p)
    by_solve_ivp = ["Rodas5P"] if given.mass is not None else []
    if np.iscomplexobj(p.y0):
        by_solve_ivp = [name for name in ("DOP853", *names) if name in COMPLEX]
    if by_solve_ivp:  # `prepare` takes neither
        made = functools.partial(_plain_stiff, fun, given)
        return {f"fastdyn {n} by solve_ivp": functools.partial(made, n) for n in by_solve_ivp}
    return {f"fastdyn {name}": functools.partial(_stiff, fun, given, name) for name in names}


def _stiff(fun, given, method, tol):
    p = given.problem
    solve = fastdyn.prepare(
        fun, p.t_span, p.y0, method, t_eval=p.t_span[1:], rtol=tol, atol=tol * given.floor
    )
    return lambda: end_of(solve())


def _plain_stiff(fun, given, method, tol):
    p, options = given.problem, {"rtol": tol, "atol": tol * given.floor}
    if given.mass is not None:
        options["mass"] = given.mass
    return lambda: end_of(
        fastdyn.solve_ivp(fun, p.t_span, p.y0, method, t_eval=p.t_span[1:], **options)
    )


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
    fastdyn.solve_ivp(**given, compile="inlined")
    return lambda: end_of(fastdyn.solve_ivp(**given))


def trajectories(many):
    """In vectors, by one thread and by two."""
    return {
        "fastdyn, 1 core": ensemble(many, "auto", 1),
        "fastdyn, 2 cores": ensemble(many, "auto", 2),
    }


def ensemble(many, simd, threads, method="RK45", rtol=MANY_RTOL, atol=MANY_ATOL):
    """A function of nothing that solves all; parameters that are the same for all are numbers."""
    fun, columns = many.fun, many.parameters.T
    args = tuple(float(p[0]) if (p == p[0]).all() else np.ascontiguousarray(p) for p in columns)
    options = {"rtol": rtol, "atol": atol, "simd": simd, "threads": threads}
    span = 0.0, many.t_end
    return lambda: fastdyn.solve_ensemble(fun, span, many.y0, args, method, **options).y_end


def dae(given):
    """`solve_dae`, as called plainly: it has no `prepare`."""

    def prepare(tol):
        def run():
            result = fastdyn.solve_dae(
                given.F, (0, given.end), given.y0, given.yp0, t_eval=[given.end], rtol=tol,
                atol=tol * np.asarray(given.floor),
            )  # fmt: skip
            return result.y[:, -1] if result.success else np.nan

        return run

    return {"fastdyn solve_dae": prepare}


def delays(given, names=("Tsit5", "Vern7", "Vern9", "DOP853")):
    """Prepared solvers, and the plain call with the method that "auto" takes."""
    made = {f"fastdyn {name}": functools.partial(_delayed, given, name) for name in names}
    return made | {"fastdyn by solve_dde": functools.partial(_plain_delayed, given)}


def _delayed(given, method, tol):
    solve = prepare_dde(
        given.fun, (0.0, given.end), given.history, method, t_eval=[given.end], rtol=tol, atol=tol
    )
    return lambda: end_of(solve())


def _plain_delayed(given, tol):
    return lambda: end_of(
        fastdyn.solve_dde(
            given.fun, (0.0, given.end), given.history, t_eval=[given.end], rtol=tol, atol=tol
        )
    )


def hybrid(given):
    """Prepared, with schedules or an event, and discrete states; RK45 through the plain call."""
    h = given
    acts: dict = {"on_event": h.act(np), "discrete": h.d0, "t_eval": [h.end]}
    if h.period is None:
        acts["events"] = _on_the_ground
    else:
        acts["every"] = h.period

    def prepare(method, tol):
        options = {"rtol": tol, "atol": tol, **acts}
        solve = fastdyn.prepare(h.fun, (0.0, h.end), h.y0, method, **options)
        return lambda: end_of(solve())

    def plain(tol):
        options = {"rtol": tol, "atol": tol, **acts}
        return lambda: end_of(fastdyn.solve_ivp(h.fun, (0.0, h.end), h.y0, **options))

    names = ("RK45", "DOP853", "Tsit5", "Vern7", "Taylor")
    made = {f"fastdyn {name}": functools.partial(prepare, name) for name in names}
    return made | {"fastdyn RK45 by solve_ivp": plain}


def gradients(given):
    """Backward by `vjp`, and forward by `sensitivity`, through the plain call."""
    fun = given.arrays(np) if given.arrays else given.terms
    options = {"t_span": (0.0, given.end), "y0": given.y0, "t_eval": [given.end]}
    g = given.weights[:, None]

    def solved(method, tol, **derivatives):
        return fastdyn.solve_ivp(
            fun, method=method, args=(given.p,), rtol=tol, atol=tol, **options, **derivatives
        )

    def backward(method, tol):
        return lambda: solved(method, tol, adjoint="p").vjp(g)["p"]

    def forward(method, tol):
        return lambda: (
            given.weights @ solved(method, tol, sensitivity="p").sensitivity["p"][..., -1]
        )

    found = {
        f"fastdyn {name}, backward": functools.partial(backward, name)
        for name in ("Tsit5", "DOP853", "Vern7", "Vern9")
    }
    return found | {
        f"fastdyn {name}, forward": functools.partial(forward, name)
        for name in ("RK45", "DOP853", "Vern9", "Taylor")
    }


def _on_the_ground(t, y, d):
    return y[0]


vars(_on_the_ground)["direction"] = -1


TAYLOR_RTOL = 2.3e-16


WISDOM_HOLMAN_DAYS, WISDOM_HOLMAN_STARTS = (40, 60, 100), 8  # days in a step


def planets(times):
    """Taylor at its smallest tolerance, outputs by its series; WisdomHolman at several steps."""
    found = {
        f"fastdyn WisdomHolman, {days} days": functools.partial(_splitting, times, days)
        for days in WISDOM_HOLMAN_DAYS
    }
    return {"fastdyn Taylor": functools.partial(_series, times)} | found


def _series(times):
    run = fastdyn.prepare(
        outer_planets.fun, (0.0, times[-1]), outer_planets.start(0), "Taylor",
        rtol=TAYLOR_RTOL, atol=TAYLOR_RTOL, t_eval=times,
    )  # fmt: skip

    def go(y0):
        begun = time.perf_counter()
        found = run(y0)
        return time.perf_counter() - begun, found.y.T, found.n_accepted

    return go, 10**9


def _splitting(times, days):
    def go(y0):
        begun = time.perf_counter()
        planets = Planets(outer_planets.MASSES, *y0.reshape(2, -1, 3), outer_planets.G)
        found = planets.solve((0.0, times[-1]), step=days / outer_planets.YEAR, t_eval=times)
        return time.perf_counter() - begun, found.y.T, found.n_accepted

    return go, WISDOM_HOLMAN_STARTS
