"""Stiff problems: achieved error against time, over tolerances."""

import functools
import math
import time

import numpy as np

import fastdyn

from .. import rivals
from ..problems import compiled
from ..problems.stiff import STIFF
from ..report.timing import WARM, interleaved
from .work_precision import LIMIT

TOLERANCES = [10.0**-k for k in range(2, 12)]


@functools.cache
def _end(name):
    """The end state: published, or that of Radau at rtol 1e-12."""
    (stiff,) = [s for s in STIFF if s.problem.name == name]
    if stiff.end is not None:
        return np.array(stiff.end)
    p = stiff.problem
    fun = compiled(p)
    return fastdyn.solve_ivp(fun, p.t_span, p.y0, "Radau", rtol=1e-12, atol=1e-12).y[:, -1]


def rows(quick):
    """One row a problem, solver and tolerance; rtol = tol, atol = tol times the problem's floor.

    The error is the largest of a component, relative to it, or to the floor where that is larger.
    """
    for stiff in STIFF[:1] if quick else STIFF:
        p, exact = stiff.problem, _end(stiff.problem.name)
        size = np.maximum(np.abs(exact), stiff.floor)
        made = rivals.stiff(stiff)
        for tol in [1e-4, 1e-6] if quick else TOLERANCES:
            runs = {name: prepare(tol) for name, prepare in made.items()}
            found = {name: _judged(run, exact, size) for name, run in runs.items()}
            fast = {name: run for name, run in runs.items() if found[name][1] < WARM}
            slow = {name: run for name, run in runs.items() if name not in fast}
            times = interleaved(fast, 5 if quick else 30, 0.1 if quick else 0.5)
            times |= interleaved(slow, 2, 0.0)
            for name, (far, seconds) in found.items():
                if seconds > 4 * LIMIT and far < 1.0:
                    made.pop(name)
                yield {
                    "problem": p.name, "solver": name, "tol": tol,
                    "error": far if math.isfinite(far) else None,
                    "min_us": times[name][0] * 1e6, "median_us": times[name][1] * 1e6,
                }  # fmt: skip


def _judged(run, exact, size):
    """(error, seconds) of a run, the second of two: the first may compile."""
    run()
    begun = time.perf_counter()
    far = float(np.max(np.abs(run() - exact) / size))
    return far, time.perf_counter() - begun


LEVELS = (1e-3, 1e-5, 1e-7)


def summary(found):
    """Microseconds at equal errors."""
    from ..report.equal_error import at_error

    lines = [f"microseconds at an error of {', '.join(f'{x:g}' for x in LEVELS)}"]
    for problem in dict.fromkeys(row["problem"] for row in found):
        lines.append(problem)
        for name in dict.fromkeys(row["solver"] for row in found if row["problem"] == problem):
            points = [
                (row["error"], row["min_us"])
                for row in found
                if (row["problem"], row["solver"]) == (problem, name)
            ]
            at = [at_error(points, level) for level in LEVELS]
            lines.append(
                f"  {name:28s}" + "".join(f"{x:12.0f}" if x else f"{'-':>12s}" for x in at)
            )
    return "\n".join(lines)
