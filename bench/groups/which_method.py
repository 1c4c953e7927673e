"""Three smooth problems and a stiff one, for the figure of `docs/which_method.md`."""

import importlib
import math
import time

import numpy as np

from ..problems import WORK, error, reference
from ..problems.stiff import STIFF
from ..report.timing import WARM, interleaved
from ..rivals import fastdyn as ours
from ..rivals import scipy

TOLERANCES = [10.0**-k for k in range(2, 16)]
SMOOTH = ("satellite, e = 0.3", "pendulum, swinging", "Lorenz")
STIFF_PROBLEM = "van der Pol"
METHODS = ("Tsit5", "Vern7", "Vern9", "DOP853", "Taylor")
STIFF_METHODS = ("Vern9", "Taylor", "Radau", "BDF")
LIMIT = 0.5  # s; who needs longer for an error below 1 is not asked for tighter tolerances


def rows(quick):
    """One row a problem, solver and tolerance."""
    problems = [(p.name, _smooth(p), reference(p), error) for p in WORK if p.name in SMOOTH]
    (given,) = (s for s in STIFF if s.problem.name == STIFF_PROBLEM)
    floored = np.maximum(np.abs(given.end), given.floor)
    problems.append((STIFF_PROBLEM, _stiff(given), np.array(given.end), _far(floored)))
    for name, made, exact, far in problems[:1] if quick else problems:
        for tol in [1e-4, 1e-8] if quick else TOLERANCES:
            yield from _at(tol, name, made, exact, far)


def _at(tol, problem, made, exact, far):
    """Rows of all solvers that are still asked."""
    runs = {name: prepare(tol) for name, prepare in made.items()}
    found = {name: _judged(run, exact, far) for name, run in runs.items()}
    fast = {name: run for name, run in runs.items() if found[name][1] < WARM}
    slow = {name: run for name, run in runs.items() if name not in fast}
    times = interleaved(fast, 60, 0.6) | interleaved(slow, 3, 0.0)
    for name, (off, seconds) in found.items():
        if seconds > LIMIT and off < 1.0:
            made.pop(name)
        yield {
            "problem": problem, "solver": name, "tol": tol,
            "error": off if math.isfinite(off) else None,
            "min_us": times[name][0] * 1e6, "median_us": times[name][1] * 1e6,
        }  # fmt: skip


def _judged(run, exact, far):
    run()
    begun = time.perf_counter()
    return far(run(), exact), time.perf_counter() - begun


def _far(size):
    """The largest error of a component, relative to it or to its floor."""
    return lambda y, exact: float(np.max(np.abs(y - exact) / size))


def _smooth(problem):
    made = {name: prepare for name, prepare in ours.solvers(problem).items() if _shown(name)}
    made["SciPy DOP853"] = scipy.solvers(problem)["SciPy DOP853"]
    return made | _heyoka(problem)


def _shown(name):
    return name.removeprefix("fastdyn ") in METHODS


def _heyoka(problem):
    """Nothing if it is not installed."""
    try:
        return importlib.import_module("bench.rivals.heyoka").solvers(problem)
    except ImportError:
        return {}


def _stiff(given):
    scipy_radau = "SciPy Radau, njit"
    return ours.stiff(given, STIFF_METHODS) | {scipy_radau: scipy.stiff(given)[scipy_radau]}
