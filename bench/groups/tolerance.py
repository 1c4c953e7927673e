"""Errors in units of the tolerance, on problems whose components have unlike sizes."""

import numpy as np

import fastdyn

from ..problems.unlike import UNLIKE
from ..report.table import markdown

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10)
METHODS = ("RK45", "DOP853", "Tsit5", "Vern7", "Vern9", "Taylor")
TIMES = 201  # of output


def times_of(problem):
    return np.linspace(0.0, problem.end, TIMES)


def exact(problem):
    """The states at the `times_of` a problem, by Vern9, which has the same norm for each size."""
    return solved(problem, "Vern9", 3e-14, 1e-3).y


def solved(problem, method, tol, finer=1.0):
    """The solution; `finer` multiplies the absolute tolerances."""
    p = problem
    return fastdyn.solve_ivp(
        p.fun, (0.0, p.end), p.y0, method, t_eval=times_of(p), rtol=tol,
        atol=finer * tol * np.array(p.floors),
    )  # fmt: skip


def off(problem, y, true, tol):
    """The largest error of each component over all times, in units of its tolerance."""
    allowed = tol * (np.array(problem.floors)[:, None] + np.abs(true))
    return (np.abs(y - true) / allowed).max(axis=1)


def rows(quick):
    """One row a problem, method and tolerance; rtol = tol, atol = tol times the floors."""
    for p in UNLIKE[:1] if quick else UNLIKE:
        true = exact(p)
        for method in METHODS:
            for tol in TOLERANCES[:2] if quick else TOLERANCES:
                run = solved(p, method, tol)
                yield {
                    "problem": p.name, "solver": method, "tol": tol, "steps": run.n_accepted,
                    "error": float(off(p, run.y, true, tol).max()),
                }  # fmt: skip


def summary(found):
    """A line a problem: by method, the largest error over all tolerances."""
    worst = {}
    for row in found:
        at = worst.setdefault(row["problem"], {})
        at[row["solver"]] = max(row["error"], at.get(row["solver"], 0.0))
    lines = [[name, *(errors.get(m) for m in METHODS)] for name, errors in worst.items()]
    return "\n".join(markdown(["problem", *METHODS], lines))
