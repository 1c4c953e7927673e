"""Trajectories a second: one function with many initial states or parameters, one core and two."""

import numpy as np

from .. import rivals
from ..problems.many import MANY
from ..report.timing import interleaved
from ..rivals import fastdyn, scipy


def median_error(found, truth):
    """Median over the trajectories of the largest error of a component."""
    return float(np.nanmedian(abs(found - truth).max(axis=1)))


def exact(many):
    """The end states, by DOP853 at a tight tolerance."""
    return fastdyn.ensemble(many, False, None, "DOP853", 1e-12, 1e-13)()


def _as_accurate(many, truth, rival):
    """fastdyn's pairs at the loosest tolerance that comes as close as the rival."""
    level, runs = median_error(rival(), truth), {}
    for method in ("RK45", "DOP853", "Vern7", "Vern9", "Taylor"):
        for k in range(6, 12):
            run = fastdyn.ensemble(many, "auto", 1, method, 10.0**-k, 10.0 ** -(k + 3))
            if median_error(run(), truth) <= level:
                runs[f"fastdyn {method}, 1 core, heyoka's error (rtol 1e-{k})"] = run
                break
    return runs


def rows(quick):
    """One row a problem and solver; SciPy solves a few of the trajectories."""
    count = 104 if quick else 10_000
    few = slice(0, count, max(1, count // (4 if quick else 20)))
    for many_of in MANY[:1] if quick else MANY:
        many = many_of(count)
        truth = exact(many)
        runs = rivals.trajectories(many)
        runs["fastdyn one by one, 1 core"] = fastdyn.ensemble(many, False, 1)
        if "heyoka batch" in runs:
            runs |= _as_accurate(many, truth, runs["heyoka batch"])
        errors = {name: median_error(run(), truth) for name, run in runs.items()}
        runs["SciPy"] = scipy.one_by_one(many.some(few))
        errors["SciPy"] = median_error(runs["SciPy"](), truth[few])
        times = interleaved(runs, 3 if quick else 9, 0.1 if quick else 60.0)
        for name, (least, median) in times.items():
            n = len(truth[few]) if name == "SciPy" else count
            yield {
                "problem": many.name,
                "solver": name,
                "median_error": errors[name],
                "a_second": n / least,
                "a_second_median": n / median,
            }
