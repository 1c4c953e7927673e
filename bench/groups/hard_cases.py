"""Single problems on which a method once failed, or took many steps, beside SciPy."""

import functools
import time

import numpy as np
import scipy.integrate

import fastdyn

from ..report.table import markdown

LENGTH = 100_000


def heat(t, u):
    rate = np.zeros_like(u)
    rate[1:-1] = 1e4 * (u[2:] - 2 * u[1:-1] + u[:-2])
    return rate


def robertson(t, y):
    first, second = -0.04 * y[0] + 1e4 * y[1] * y[2], 3e7 * y[1] ** 2
    return [first, -first - second, second]


def oscillators(inside):
    def fun(t, s):
        x, y, u, v = s
        d = np.where(inside(x, y), 0.01, 0.0)
        return [u, v, -x - d * u, -2 * y - d * v]

    return fun


TIGHT = {"rtol": 1e-12, "atol": 1e-12}
PROBLEMS = {  # fun, t_span, y0, options of both, options of fastdyn, options of SciPy
    "LSODA, too short to change t": (
        lambda t, y: [1e50 / y[0]], (1.0, 2.0), [1e6], {"method": "LSODA"}, {}, {},
    ),
    "LSODA, Robertson, nonnegative": (
        robertson, (0.0, 4e10), [1.0, 0.0, 0.0],
        {"method": "LSODA", "rtol": 1e-2, "atol": 1e-4}, {"nonnegative": True}, {},
    ),
    "LSODA, heat, 10^5 states": (
        heat, (0.0, 0.1), np.sin(np.linspace(0.0, np.pi, LENGTH)),
        {"method": "LSODA", "rtol": 1e-6, "atol": 1e-9}, {}, {"lband": 1, "uband": 1},
    ),
    "a condition on a square": (
        oscillators(lambda x, y: x * x + y * y < 0.64), (0.0, 50.0), [1.0, 0.0, 0.0, 0.9],
        TIGHT, {"method": "Taylor"}, {"method": "DOP853"},
    ),
    "a condition on a distance": (
        oscillators(lambda x, y: np.hypot(x, y) < 0.8), (0.0, 50.0), [1.0, 0.0, 0.0, 0.9],
        TIGHT, {"method": "Taylor"}, {"method": "DOP853"},
    ),
}  # fmt: skip


def rows(quick):
    """One row a problem: steps, least time of a solve, end."""
    for name, (fun, span, y0, both, mine, theirs) in PROBLEMS.items():
        if quick and len(y0) == LENGTH:
            continue
        row = {"problem": name}
        for tool, solver, options in (
            ("fastdyn", fastdyn.solve_ivp, mine), ("SciPy", scipy.integrate.solve_ivp, theirs),
        ):  # fmt: skip
            solve = functools.partial(solver, fun, span, y0, **both, **options)
            found = solve()
            row |= {f"{tool}_status": found.status, f"{tool}_steps": len(found.t) - 1}
            row |= {f"{tool}_ms": 1e3 * min(_time(solve) for _ in range(3))}
            row |= {f"{tool}_end": float(found.y[0, -1]), f"{tool}_least": float(found.y.min())}
        yield row


def _time(function):
    begun = time.perf_counter()
    function()
    return time.perf_counter() - begun


def summary(found):
    """A line a problem."""
    fields = "status", "steps", "ms", "end"
    head = ["", *[f"{tool} {field}" for tool in ("fastdyn", "SciPy") for field in fields]]
    lines = [
        [r["problem"], *[f"{r[f'{tool}_{field}']:.4g}" for tool in ("fastdyn", "SciPy")
                         for field in fields]]
        for r in found
    ]  # fmt: skip
    return "\n".join(markdown(head, lines))
