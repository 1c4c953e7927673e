"""Achieved error against time, over tolerances, for every solver and problem."""

import functools

from .. import rivals
from ..problems import WORK, error, reference
from ..report.work_precision import at_tolerance

TOLERANCES = [10.0**-k for k in range(3, 16)]


def rows(quick):
    """One row a problem, solver and tolerance; rtol = atol, the error relative to the state."""
    turns = (5, 0.1) if quick else (100, 1.0)
    for problem in [WORK[4]] if quick else WORK:
        far = functools.partial(error, exact=reference(problem))
        made = rivals.solvers(problem)
        for tol in [1e-4, 1e-8] if quick else TOLERANCES:
            yield from at_tolerance(tol, problem.name, made, far, turns)
