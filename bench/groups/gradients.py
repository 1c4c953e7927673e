"""Gradients of a number of the end state by all parameters: achieved error against time."""

import numpy as np

from .. import rivals
from ..problems.gradients import GRADIENTS
from ..report.equal_error import equal_error
from ..report.table import best, markdown
from ..report.work_precision import at_tolerance
from .stiff import relative_to

TOLERANCES = [10.0**-k for k in (4, 5, 6, 7, 8, 9, 10, 11)]
LEVELS = (1e-4, 1e-6, 1e-8)
WAYS = ("backward", "forward")
LIBRARIES = ("fastdyn", "heyoka", "diffrax", "CVODES")


def rows(quick):
    """One row a problem, solver and tolerance; rtol = atol = tol; errors of the derivatives."""
    turns = (5, 0.1) if quick else (20, 0.5)
    for given in GRADIENTS[:1] if quick else GRADIENTS:
        true = given.true
        far, made = relative_to(true, float(np.abs(true).max())), rivals.gradients(given)
        for tol in [1e-4, 1e-6] if quick else TOLERANCES:
            yield from at_tolerance(tol, given.name, made, far, turns)


def summary(found):
    """Microseconds at equal errors, by the fastest method of each library."""
    body = []
    for problem, solvers in equal_error(found, LEVELS).items():
        for way in WAYS:
            of_way = {name: each for name, each in solvers.items() if name.endswith(way)}
            for i, level in enumerate(LEVELS):
                fastest = best(of_way, i)
                times = [fastest.get(name, (None,))[0] for name in LIBRARIES]
                body.append([problem, way, f"{level:g}", *times])
    return "\n".join(markdown(["problem", "derivatives", "error", *LIBRARIES], body))
