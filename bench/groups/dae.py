"""Equations F(t, y, y') = 0 beside IDA: achieved error against time, over tolerances."""

import numpy as np

from .. import rivals
from ..problems.daes import DAES
from ..report.equal_error import table
from ..report.work_precision import LIMIT, at_tolerance
from .stiff import relative_to

TOLERANCES = [10.0**-k for k in (4, 5, 6, 7, 8, 9)]
LEVELS = (1e-3, 1e-4, 1e-5)


def rows(quick):
    """One row a problem, solver and tolerance; rtol = tol, atol = tol times the problem's floor."""
    turns = (5, 0.1) if quick else (20, 0.5)
    for dae in DAES[:1] if quick else DAES:
        far, made = relative_to(np.array(dae.solution), 0.0), rivals.dae(dae)
        for tol in [1e-4, 1e-6] if quick else TOLERANCES:
            yield from at_tolerance(tol, dae.name, made, far, turns, limit=20 * LIMIT)


def summary(found):
    """Microseconds at equal errors."""
    return "\n".join(table(found, LEVELS))
