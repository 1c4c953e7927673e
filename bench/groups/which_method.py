"""Three smooth problems and a stiff one, for the figure of `docs/which_method.md`."""

import functools
import importlib

import numpy as np

from ..problems import WORK, error, reference
from ..problems.stiff import STIFF
from ..report.work_precision import at_tolerance
from ..rivals import fastdyn as ours
from ..rivals import scipy
from .stiff import relative_to

TOLERANCES = [10.0**-k for k in range(2, 16)]
SMOOTH = ("satellite, e = 0.3", "pendulum, swinging", "Lorenz")
STIFF_PROBLEM = "van der Pol"
METHODS = ("Tsit5", "Vern7", "Vern9", "DOP853", "Taylor")
STIFF_METHODS = ("Vern9", "Taylor", "Radau", "BDF")


def rows(quick):
    """One row a problem, solver and tolerance."""
    turns = (5, 0.1) if quick else (60, 0.6)
    for name, made, far in list(_problems())[: 1 if quick else None]:
        for tol in [1e-4, 1e-8] if quick else TOLERANCES:
            yield from at_tolerance(tol, name, made, far, turns)


def _problems():
    """(name, solvers, error of an end state)."""
    for p in WORK:
        if p.name in SMOOTH:
            yield p.name, _smooth(p), functools.partial(error, exact=reference(p))
    (given,) = (s for s in STIFF if s.problem.name == STIFF_PROBLEM)
    yield STIFF_PROBLEM, _stiff(given), relative_to(np.array(given.end), given.floor)


def _smooth(problem):
    made = {name: prepare for name, prepare in ours.solvers(problem).items() if _shown(name)}
    made["SciPy DOP853"] = scipy.solvers(problem)["SciPy DOP853"]
    return made | _heyoka(problem)


def _shown(name):
    return name.removeprefix("fastdyn ") in METHODS


def _heyoka(problem):
    """With its fastest option; nothing if it is not installed."""
    try:
        made = importlib.import_module("bench.rivals.heyoka").solvers(problem)
    except ImportError:
        return {}
    return {"heyoka": made["heyoka, fast_math"]}


def _stiff(given):
    scipy_radau = "SciPy Radau, njit"
    return ours.stiff(given, STIFF_METHODS) | {scipy_radau: scipy.stiff(given)[scipy_radau]}
