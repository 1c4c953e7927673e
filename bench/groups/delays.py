"""Equations with constant delays beside C++ by hand, JiTCDDE and ddeint: error against time."""

import numpy as np

from .. import rivals
from ..problems.delays import DELAYS
from ..report.equal_error import table
from ..report.work_precision import LIMIT, at_tolerance
from .stiff import relative_to

TOLERANCES = [10.0**-k for k in range(3, 12)]
LEVELS = (1e-4, 1e-6, 1e-8)


def rows(quick):
    """One row a problem, solver and tolerance, with rtol = atol = tol."""
    turns = (5, 0.1) if quick else (20, 0.5)
    for given in DELAYS[:1] if quick else DELAYS:
        far, made = relative_to(np.array(given.solution), 0.0), rivals.delays(given)
        for tol in [1e-4, 1e-6] if quick else TOLERANCES:
            yield from at_tolerance(tol, given.name, made, far, turns, limit=2 * LIMIT)


def summary(found):
    """Microseconds at equal errors."""
    return "\n".join(table(found, LEVELS))
