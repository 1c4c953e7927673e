"""Hybrid systems: a sampled controller, doses, impacts; achieved error against time."""

import numpy as np

from .. import rivals
from ..problems.hybrids import HYBRIDS
from ..report.equal_error import table
from ..report.work_precision import LIMIT, at_tolerance
from .stiff import relative_to

TOLERANCES = [10.0**-k for k in (3, 4, 5, 6, 7, 8, 9, 10)]
LEVELS = (1e-4, 1e-6, 1e-8)


def rows(quick):
    """One row a problem, solver and tolerance; rtol = atol = tol."""
    turns = (5, 0.1) if quick else (20, 0.5)
    for hybrid in HYBRIDS[:1] if quick else HYBRIDS:
        far, made = relative_to(np.array(hybrid.solution), 1.0), rivals.hybrid(hybrid)
        for tol in [1e-4, 1e-6] if quick else TOLERANCES:
            yield from at_tolerance(tol, hybrid.name, made, far, turns, limit=4 * LIMIT)


def summary(found):
    """Microseconds at equal errors."""
    return "\n".join(table(found, LEVELS))
