"""F(t, y, y') = 0 with its sensitivities, as one residual that BDF solves.

The sensitivities satisfy dF/dy S + dF/dy' S' + dF/dp = 0.  S. Li and L. Petzold, "Software and
algorithms for sensitivity analysis of large-scale differential algebraic systems", J. Comput. Appl.
Math. 125 (2000).
"""

import functools
from typing import Any

import numpy as np

from fastdyn.compile.compare import machine_value
from fastdyn.compile.mode import RESIDUAL_SENSITIVITIES
from fastdyn.problem.sensitivities import Tolerances, VariationalResidual
from fastdyn.run.functions.bound import bind_functions
from fastdyn.run.functions.compared import off_the_solution
from fastdyn.run.matrices.check_jacobian import STEP

from ..consistent import completed, consistent_behind, held_of, solution
from ..index import names
from ..jumps import with_jumps
from .acting import Acting

LEAST = 1e-3  # of the largest component, to which the others are moved at least
OFF = 1e-6  # of the terms of the equations, that a start of the sensitivities may leave


class Tangent:
    """A problem of [y, y'] as one of [y, S, y', S'], and the consistent starts of the latter.

    Parameters
    ----------
    problem : Problem
        Of [y, y'], from a consistent start.
    equations : Equations
    directions : list of Direction
    held : object
        `given` of `solve_dae`, which says how the start depends on `y0`.
    """

    def __init__(self, problem, equations, directions, held):
        self._problem = problem
        self._equations = equations
        self._held = held
        self.directions = directions
        n = equations.n
        m = sum([d.size for d in directions])
        positions = tuple([d.position for d in directions])
        self.equations = VariationalResidual(problem.fun, problem.mode, n, positions, m, n)
        own = problem._replace(y0=problem.y0[:n], **_halves(problem, n))
        tolerances = Tolerances(own, m)
        sizes = np.concatenate([np.abs(d.value).ravel() for d in directions])
        near = self.equations.joined(off_the_solution(problem.y0), np.zeros((2 * n, m)))
        longer = problem._replace(
            fun=self.equations, mode=RESIDUAL_SENSITIVITIES, y0=near,
            rtol=np.tile(np.broadcast_to(tolerances.rtol, n * (1 + m)), 2),
            atol=np.tile(tolerances.atol(sizes), 2),
        )  # fmt: skip
        plain = with_jumps(longer, lambda act: None)
        self.bound, self.others = bind_functions(plain)
        self.problem = self._acting(longer._replace(y0=self._start()))

    def _acting(self, problem):
        """The longer problem, with functions that act on [y, S, y', S']."""
        p: Any = problem
        events = p.events and [
            e.acting(functools.partial(Acting, self, self._problem, e.function)) for e in p.events
        ]
        schedules = [
            each._replace(jump=each.jump and Acting(self, self._problem, None, each.jump))
            for each in p.schedules
        ]
        return p._replace(events=events, schedules=tuple(schedules))

    def consistent(self, t, start):
        """The consistent [y, y'] at a time, whose differential components hold."""
        return consistent_behind(self._equations, start, t, start.y0)

    def again(self, t, z):
        """The consistent [y, S, y', S'] at a time, whose differential components hold."""
        both, columns = self.equations.parts(z)
        both = self.consistent(t, self._problem._replace(t0=t, y0=both))
        return self.behind(t, both, columns)

    def behind(self, t, both, columns):
        """[y, S, y', S'] for a consistent [y, y'] and the columns of differential components."""
        held = held_of("differential", self._equations.at(t).rates(both))
        return self._solved(t, both, columns, held)

    def _start(self):
        p = self._problem
        n = self._equations.n
        word = "differential" if self._held is None else self._held
        held = held_of(word, self._equations.rates(p.y0))
        columns = [
            np.eye(2 * n, n) if d.position == 0 else np.zeros((2 * n, d.size))
            for d in self.directions
        ]
        return self._solved(p.t0, p.y0, np.hstack(columns), held)

    def _solved(self, t, both, columns, held):
        """[y, S, y', S'] with the rows of columns that are held, and the others computed."""
        equations = self._equations.at(t)
        n = equations.n
        m = columns.shape[1]
        columns = np.where(held[:, None], columns, 0.0)
        at_rest = self.equations.joined(both, np.zeros((2 * n, m)))
        found = machine_value(self.bound, t, at_rest)
        jacobian = equations.jacobian(both)
        if found is None or not np.isfinite(found).all():
            raise ValueError(
                f"The sensitivities have no start at t = {t:.10g}: a derivative of `F` is nan or "
                "inf there."
            )
        by_parameters = found[n : n + n * m].reshape(n, m)
        right = -(jacobian @ columns + by_parameters)
        columns[~held] = solution(jacobian[:, ~held], right, n * equations.noise)
        terms = abs(jacobian) @ np.abs(columns) + np.abs(by_parameters)
        off = np.abs(jacobian @ columns + by_parameters) > OFF * terms
        if off.any():
            self._refuse(t, off)
        if not held[n:][equations.rates(both)].any():
            columns = self._with_all_derivatives(t, both, columns, jacobian)
        return self.equations.joined(both, columns)

    def _with_all_derivatives(self, t, both, columns, jacobian):
        """The columns with the part of S' that does not occur in the equations, for predictions."""
        equations = self._equations.at(t)
        p = self._problem
        n, m, (y, rate) = equations.n, columns.shape[1], np.split(both, 2)
        unit = min(abs(p.tf - p.t0), 1.0) if p.tf != p.t0 else 1.0
        with np.errstate(all="ignore"):
            sizes = np.maximum(np.abs(y), LEAST * np.abs(y).max())
            unit = min(unit, float(np.nanmin(sizes / np.abs(rate), initial=1.0)))
        step = STEP * np.copysign(max(unit, LEAST * abs(t)), p.tf - p.t0)

        def at(k):
            moved = self.equations.joined(np.r_[y + k * step * rate, rate], columns)
            found = machine_value(self.bound, t + k * step, moved)
            found = np.full(2 * n * (1 + m), np.nan) if found is None else found
            return found[n : n + n * m].reshape(n, m)

        here = at(0)
        next_ = at(1)
        last = at(2)
        by_time = (4.0 * next_ - 3.0 * here - last) / (2.0 * step)
        if not np.isfinite(by_time).all():
            return columns
        found = completed(equations, jacobian, equations.rates(both), columns[n:], by_time)
        return columns if found is None else np.concatenate([columns[:n], found])

    def _refuse(self, t, off):
        rows = np.flatnonzero(off.any(axis=1))
        column = np.flatnonzero(off.any(axis=0))[0]
        sizes = np.cumsum([d.size for d in self.directions])
        name = self.directions[int(np.searchsorted(sizes, column, side="right"))].name
        raise ValueError(
            f"The sensitivity by {name!r} has no start at t = {t:.10g}: {names('equation', rows)} "
            "of `F` cannot stay 0 while the held components are varied one by one. Hold fewer of "
            "them: `given` takes numbers of components of `y0`."
        )


def _halves(problem, n):
    """`rtol` and `atol` of y, from those of [y, y']."""
    return {
        name: value[:n] if np.ndim(value) else value
        for name, value in (("rtol", problem.rtol), ("atol", problem.atol))
    }
