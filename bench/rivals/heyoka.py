"""heyoka: Taylor's method, compiled for the formulas and for the tolerance."""

import functools

import heyoka as hy
import numpy as np

from . import MAX_STEPS


def solvers(problem):
    """The adaptive integrator with default options, for systems given by formulas."""
    return {"heyoka": functools.partial(_prepare, problem)} if problem.terms else {}


def integrator(problem, **options):
    """Build the integrator of a problem, at its start."""
    y = hy.make_vars(*(f"y{i}" for i in range(len(problem.y0))))
    rates = problem.terms(hy)(hy.time, y, *problem.args)
    system = list(zip(y, rates, strict=True))
    return hy.taylor_adaptive(system, [float(value) for value in problem.y0], **options)


def _prepare(problem, tol, times=None):
    run = integrator(problem, tol=tol)
    y0, (begin, end) = np.array(problem.y0, dtype=float), problem.t_span

    def solve():
        run.time = begin
        run.state[:] = y0
        if times is not None:
            return run.propagate_grid(times)[-1][-1]
        run.propagate_until(end, max_steps=MAX_STEPS)
        return run.state.copy()

    return solve
