"""Trajectories a second: one function with many initial states or parameters, one core and two."""

import math

import numpy as np

from fastdyn.systems import building

from . import many
from .cpp import batches
from .timing import interleaved


def orbit(t, w, GM):
    """Point mass on a plane orbit: [x, y, vx, vy]."""
    x, y, vx, vy = w
    r2 = x * x + y * y
    c = -GM / (r2 * math.sqrt(r2))
    return [vx, vy, c * x, c * y]


def floors(t, w, k, m, omega, d, L, g):
    """The two-storey building: [y1, y2, v1, v2]."""
    y1, y2, v1, v2 = w
    s = d * math.sin(omega * t)
    lower, upper = 2.0 * k * (y1 - s - L), 2.0 * k * (y2 - y1 - L)
    return [v1, v2, (upper - lower) / m - g, -upper / m - g]


def orbits(count):
    """(function, end, states, parameters (count, n)) of satellites with many speeds."""
    y0 = np.zeros((count, 4))
    y0[:, 0], y0[:, 3] = 1.0, np.random.default_rng(0).uniform(0.8, 1.2, count)
    return orbit, 100.0, y0, np.ones((count, 1))


def buildings(count):
    """The same of buildings over ground of many frequencies."""
    system = building()
    parameters = np.tile(system.args[:6], (count, 1))
    parameters[:, 2] = np.linspace(1.0, 30.0, count)
    return floors, 20.0, np.tile(system.initial_state(), (count, 1)), parameters


PROBLEMS = {"satellite": orbits, "building": buildings}


def median_error(found, truth):
    """Median over the trajectories of the largest error of a component."""
    return float(np.nanmedian(abs(found - truth).max(axis=1)))


def exact(given):
    """The end states, by DOP853 at a tight tolerance."""
    return many.fastdyn(*given, "scalar", None, "DOP853", 1e-12, 1e-13)()


def solvers(problem, given):
    """{solver: run} of all that solve every trajectory of a problem at rtol 1e-6."""
    runs = {
        "fastdyn, 1 core": many.fastdyn(*given, "auto", 1),
        "fastdyn, 2 cores": many.fastdyn(*given, "auto", 2),
    }
    number = list(PROBLEMS).index(problem)  # in lanes.cpp
    for name, (each, lanes) in batches().items():
        runs[f"C++ {name}"] = many.cpp(each, number, *given[1:])
        runs[f"C++ {name}, 8 lanes by hand"] = many.cpp(lanes, number, *given[1:])
    for name, adapter in many.RIVALS.items():
        try:
            runs[name] = adapter(*given)
        except ImportError as error:
            print(f"skipped {name}: {error}")
    return runs


def _as_accurate(given, truth, rival):
    """fastdyn's pairs at the loosest tolerance that comes as close as the rival."""
    level, runs = median_error(rival(), truth), {}
    for method in ("RK45", "DOP853", "Vern7", "Vern9"):
        for k in range(6, 12):
            run = many.fastdyn(*given, "auto", 1, method, 10.0**-k, 10.0 ** -(k + 3))
            if median_error(run(), truth) <= level:
                runs[f"fastdyn {method}, 1 core, heyoka's error (rtol 1e-{k})"] = run
                break
    return runs


def rows(quick):
    """One row a problem and solver."""
    count = 104 if quick else 10_000
    for problem in list(PROBLEMS)[:1] if quick else PROBLEMS:
        given = fun, end, y0, parameters = PROBLEMS[problem](count)
        truth = exact(given)
        runs = solvers(problem, given)
        runs["fastdyn one by one, 1 core"] = many.fastdyn(*given, "scalar", 1)
        if "heyoka batch" in runs:
            runs |= _as_accurate(given, truth, runs["heyoka batch"])
        few = slice(0, count, max(1, count // (4 if quick else 20)))
        runs["SciPy"] = many.by_scipy(fun, end, y0[few], parameters[few])
        errors = {}
        for name, run in runs.items():
            expected = truth[few] if name == "SciPy" else truth
            errors[name] = median_error(run(), expected)
        times = interleaved(runs, 3 if quick else 9, 0.1 if quick else 60.0)
        for name, (least, median) in times.items():
            n = len(y0[few]) if name == "SciPy" else count
            yield {
                "problem": problem,
                "solver": name,
                "median_error": errors[name],
                "a_second": n / least,
                "a_second_median": n / median,
            }
