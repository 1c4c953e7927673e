"""Stiff problems and a DAE: achieved error against time, over tolerances."""

import functools

import numpy as np

import fastdyn

from .. import rivals
from ..problems import compiled
from ..problems.reaction_diffusion import LINES
from ..problems.stiff import STIFF
from ..problems.stiff_physics import PHYSICS
from ..report.equal_error import equal_error
from ..report.work_precision import LIMIT, at_tolerance

PROBLEMS = (*STIFF, *PHYSICS, *LINES)
TOLERANCES = [10.0**-k for k in (2, 4, 6, 8, 10)]


@functools.cache
def _end(name):
    """The end state: published, or that of Radau at rtol 1e-12."""
    (stiff,) = [s for s in PROBLEMS if s.problem.name == name]
    if stiff.end is not None:
        return np.array(stiff.end)
    p = stiff.problem
    fun = compiled(p)
    return fastdyn.solve_ivp(fun, p.t_span, p.y0, "Radau", rtol=1e-12, atol=1e-12).y[:, -1]


def rows(quick):
    """One row a problem, solver and tolerance; rtol = tol, atol = tol times the problem's floor."""
    turns = (5, 0.1) if quick else (20, 0.2)
    for stiff in (STIFF[0], PHYSICS[-1]) if quick else PROBLEMS:
        p = stiff.problem
        far = relative_to(_end(p.name), stiff.floor)
        made = rivals.stiff(stiff)
        for tol in [1e-4, 1e-6] if quick else TOLERANCES:
            yield from at_tolerance(tol, p.name, made, far, turns, limit=2 * LIMIT)


def relative_to(exact, floor):
    """The error of an end state: the largest of a component, relative to it or to its floor."""
    size = np.maximum(np.abs(exact), floor)
    return lambda y: float(np.max(np.abs(y - exact) / size))


LEVELS = (1e-3, 1e-5, 1e-7)


def summary(found):
    """Microseconds at equal errors."""
    lines = [f"microseconds at an error of {', '.join(f'{x:g}' for x in LEVELS)}"]
    for problem, solvers in equal_error(found, LEVELS).items():
        lines.append(problem)
        for name, at in solvers.items():
            lines.append(
                f"  {name:28s}" + "".join(f"{x:12.0f}" if x else f"{'-':>12s}" for x in at)
            )
    return "\n".join(lines)
