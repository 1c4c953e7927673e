"""Achieved error and time of all solvers of a problem at one tolerance."""

import math
import time

from .timing import WARM, interleaved

LIMIT = 0.5  # s; who needs longer for an error below 1 is not asked for tighter tolerances,
HOPELESS = 10  # nor who needs so many times longer for any
ONCE = 1.0  # s; what takes longer is timed once


def at_tolerance(tol, problem, made, error, turns, limit=LIMIT):
    """One row a solver.

    Parameters
    ----------
    tol : float
    problem : str
        Its name.
    made : dict
        {name: prepare} as `rivals` has it; who takes longer than `limit` is left out of it.
    error : function
        ``error(y)`` of an end state.
    turns : tuple
        (repetitions, seconds) of the timing; what takes longer than WARM is timed apart, with three
        repetitions, and what takes longer than ONCE with one.
    limit : float
        s.
    """
    runs = {name: prepare(tol) for name, prepare in made.items()}
    found = {name: _judged(run, error) for name, run in runs.items()}
    took = {name: seconds for name, (_, seconds) in found.items()}
    fast = {name: run for name, run in runs.items() if took[name] < WARM}
    slow = {name: run for name, run in runs.items() if WARM <= took[name] <= ONCE}
    times = {name: (seconds, seconds) for name, seconds in took.items()}
    times |= interleaved(fast, *turns) | interleaved(slow, 3, 0.0)
    for name, (far, seconds) in found.items():
        if seconds > limit and (far < 1.0 or seconds > HOPELESS * limit):
            made.pop(name)
        yield {
            "problem": problem,
            "solver": name,
            "tol": tol,
            "error": far if math.isfinite(far) else None,
            "min_us": times[name][0] * 1e6,
            "median_us": times[name][1] * 1e6,
        }


def _judged(run, error):
    """(error, seconds) of a run, the second of two: the first may compile."""
    run()
    begun = time.perf_counter()
    far = error(run())
    return far, time.perf_counter() - begun
