"""Achieved error against time, over tolerances, for every solver and problem."""

import itertools
import math
import time

from . import rivals
from .problems import WORK, error, reference
from .timing import WARM, interleaved

TOLERANCES = [10.0**-k for k in range(3, 14)]
LEVELS = (1e-4, 1e-8, 1e-12)


LIMIT = 0.5  # s; who needs longer for an error below 1 is not asked for tighter tolerances


def rows(quick):
    """One row a problem, solver and tolerance; rtol = atol, the error relative to the state.

    What takes longer than WARM is timed apart, with three repetitions.
    """
    for problem in [WORK[4]] if quick else WORK:
        exact = reference(problem)
        made = rivals.solvers(problem)
        for tol in [1e-4, 1e-8] if quick else TOLERANCES:
            runs = {name: prepare(tol) for name, prepare in made.items()}
            found = {name: _judged(run, exact) for name, run in runs.items()}
            fast = {name: run for name, run in runs.items() if found[name][1] < WARM}
            slow = {name: run for name, run in runs.items() if name not in fast}
            times = interleaved(fast, 5 if quick else 100, 0.1 if quick else 1.0)
            times |= interleaved(slow, 3, 0.0)
            for name, (far, seconds) in found.items():
                if seconds > LIMIT and far < 1.0:
                    made.pop(name)
                yield {
                    "problem": problem.name,
                    "solver": name,
                    "tol": tol,
                    "error": far if math.isfinite(far) else None,
                    "min_us": times[name][0] * 1e6,
                    "median_us": times[name][1] * 1e6,
                }


def _judged(run, exact):
    """(error, seconds) of a run, the second of two: the first may compile."""
    run()
    begun = time.perf_counter()
    far = error(run(), exact)
    return far, time.perf_counter() - begun


def at_error(points, level):
    """Microseconds at which a solver reaches an error, or None.

    `points` are pairs of error and time, of one solver and one problem.  Between two of the points
    that no other point beats in both, the logarithms are interpolated; an error better than
    all but reached more cheaply than asked for costs what the cheapest such point does.
    """
    front, best = [], math.inf
    for cost, far in sorted((cost, max(far, 1e-17)) for far, cost in points if far is not None):
        if far < best:
            front.append((far, cost))
            best = far
    if not front or best > level:
        return None
    for (coarse, cheap), (fine, dear) in itertools.pairwise(front):
        if coarse > level >= fine:
            part = math.log(coarse / level) / math.log(coarse / fine)
            return cheap * (dear / cheap) ** part
    return front[0][1]


def equal_error(rows):
    """{problem: {solver: [microseconds at each of LEVELS]}} from the rows of the group."""
    points = {}
    for row in rows:
        each = points.setdefault(row["problem"], {}).setdefault(row["solver"], [])
        each.append((row["error"], row["min_us"]))
    return {
        problem: {
            name: [at_error(each, level) for level in LEVELS] for name, each in solvers.items()
        }
        for problem, solvers in points.items()
    }
