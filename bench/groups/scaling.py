"""Time against the number of revolutions, of springs, of bodies and of trajectories."""

import contextlib
import math

import numpy as np

from fastdyn.specialise.series import NoSeries

from .. import rivals
from ..problems import SATELLITE, bodies_of, chain_of, error, reference
from ..problems.many import satellites
from ..report.timing import interleaved
from . import ensemble

TOL = 1e-6
BY_HAND = ("SciPy RK45", "SciPy DOP853", "SciPy LSODA")  # loops in plain Python
UP_TO = {"SciPy odeint, njit": 1000, "SciPy LSODA, njit": 1000}  # room for n x n numbers
LIMIT = 0.05  # s; a solver that needs longer is not asked for a larger size


def revolutions(count):
    """The satellite for so many revolutions."""
    return SATELLITE._replace(t_span=(0.0, 2.0 * math.pi * count))


CASES = (
    ("revolutions", revolutions, (1, 10, 100, 1000)),
    ("components of a chain of springs", chain_of, (10, 100, 1000, 10_000)),
    ("components of bodies", lambda n: bodies_of(n // 6), (12, 102, 1002, 10_002)),
)


TRAJECTORIES = (8, 80, 800, 8000)


def rows(quick):
    """One row a size and solver; `growth` is `ns_each` over its least at any smaller size."""
    yield from _of_one(quick)
    yield from _of_many(quick)


def _of_many(quick):
    least = {}
    for size in TRAJECTORIES[:1] if quick else TRAJECTORIES:
        many = satellites(size)
        runs = rivals.trajectories(many)
        exact = ensemble.exact(many)
        errors = {name: ensemble.median_error(run(), exact) for name, run in runs.items()}
        times = interleaved(runs, 3 if quick else 50, 0.1 if quick else 10.0)
        for name in runs:
            yield _row("trajectories", size, name, errors[name], times[name], least)


def _of_one(quick):
    for against, problem_of, sizes in CASES:
        least, out = {}, set(BY_HAND)
        for size in sizes[:1] if quick else sizes:
            problem = problem_of(size)
            exact = np.array(SATELLITE.y0) if against == "revolutions" else reference(problem)
            runs, errors = {}, {}
            for name, prepare in rivals.solvers(problem).items():
                if name not in out and size <= UP_TO.get(name, math.inf):
                    with contextlib.suppress(NoSeries):  # Taylor, of loops that Numba compiles
                        runs[name] = prepare(TOL)
                        errors[name] = error(runs[name](), exact)
            times = interleaved(runs, 3 if quick else 50, 0.1 if quick else 2.0)
            out |= {name for name in runs if times[name][0] > LIMIT}
            for name in runs:
                yield _row(against, size, name, errors[name], times[name], least)


def _row(against, size, name, far, seconds, least):
    each = seconds[0] / size * 1e9
    least[name] = min(each, least.get(name, each))
    return {
        "against": against,
        "size": size,
        "solver": name,
        "error": far,
        "min_us": seconds[0] * 1e6,
        "median_us": seconds[1] * 1e6,
        "ns_each": each,
        "growth": each / least[name],
    }
