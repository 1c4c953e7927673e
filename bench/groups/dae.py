"""Equations F(t, y, y') = 0 beside IDA: achieved error against time, over tolerances."""

import numpy as np

from .. import rivals
from ..problems.daes import DAES
from ..report.equal_error import equal_error
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
    return "\n".join(table(found))


def table(found):
    """Lines of a table in Markdown: microseconds at equal errors."""
    return lines_of(equal_error(found, LEVELS), LEVELS)


def lines_of(reached, levels):
    """A table in Markdown of the result of `equal_error`."""
    head = ["problem", "solver", *(f"error {level:g}" for level in levels)]
    lines = [head, ["---"] * len(head)]
    for problem, solvers in reached.items():
        for name, times in solvers.items():
            lines.append([problem, name, *(f"{x:.0f}" if x else "-" for x in times)])
    return [f"| {' | '.join(line)} |" for line in lines]
