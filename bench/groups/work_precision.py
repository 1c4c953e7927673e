"""Achieved error against time, over tolerances, for every solver and problem."""

import math
import time

from .. import rivals
from ..problems import WORK, error, reference
from ..report.timing import WARM, interleaved

TOLERANCES = [10.0**-k for k in range(3, 14)]
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
