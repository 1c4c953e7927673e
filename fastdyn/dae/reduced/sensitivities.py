"""Sensitivities of equations of a higher index: of the reduced state, then of all components.

All equations and their derivatives hold for the vector z of all orders of all components, and so
dG/dz dz + dG/dp = 0: depth by depth, as in `structure/start.py`, dz moves to the nearest vector
that satisfies the constraints, and the last derivatives give the highest orders.
"""

import numpy as np

from fastdyn.compile.derivatives.sensitivities import decides, jump_of
from fastdyn.compile.mode import SENSITIVITIES
from fastdyn.compile.sentences import Uncompilable
from fastdyn.compile.traced.make import Near
from fastdyn.problem.schedules import listed
from fastdyn.problem.sensitivities import NEEDS, Tolerances, Variational, by_name, joined
from fastdyn.run.outcome import result_of
from fastdyn.run.result import OdeResult
from fastdyn.run.solve_problem import run_of
from fastdyn.solve.sensitivities import JUMPS, event_sensitivity

from ..structure.formulas import constraints
from ..structure.start import LOST, Unsolved
from .trajectory import MANY, complete, components, orders, places, projected, solved

OFF = 1e-6  # of the terms of the equations, that a start of the sensitivities may leave


class ReducedTangent:
    """The sensitivities of a reduced system.

    Parameters
    ----------
    reduction : Reduction
    given : problem.DaeArguments
    held : set of int or None
        The components of the start that are held.
    """

    def __init__(self, reduction, given, held):
        self._reduction = reduction
        self._given = given
        self._held = held
        self._system, self._slopes = reduction.system, reduction.slopes()
        self._size = (self._system.levels() + 1) * given.n
        self._places = places(self._system)
        by_start = any(d.position == 0 for d in given.directions)
        self._positions = (0,) * by_start + (1,) * bool(self._system.given.varied)
        self._m = sum([d.size for d in given.directions])
        at = given.n * by_start
        order = []  # of the columns, as the directions are given; those by y0 are the first here
        for d in given.directions:
            if d.position == 0:
                order += range(d.size)
            else:
                order += range(at, at + d.size)
                at += d.size
        self._order = order

    def start(self, t, z):
        """The derivatives of the reduced state at a consistent start z, shape (n, m)."""
        system = self._system
        n = self._given.n
        columns = np.zeros((self._size, self._m))
        m = self._m
        if 0 in self._positions:
            for k in range(n):
                column, order = system.given.place(k)
                columns[order * n + column, k] = 1.0
        t = np.array([float(t)])
        z = z[:, None]
        d = system.offsets.components
        for slopes, (depth, rows, at, _) in zip(
            self._slopes[:-1], constraints(system), strict=True
        ):
            free = [j for j in at if system.name(j, int(d[j]) - depth) not in (self._held or ())]
            where = [system.given.columns[j] + (int(d[j]) - depth) * n for j in free]
            matrix = slopes.at(system, t, z)[0]
            off = self._along(matrix, columns)
            columns[where] -= np.linalg.lstsq(matrix[:, where], off, rcond=LOST)[0]
            off = np.abs(self._along(matrix, columns))
            terms = np.abs(matrix[:, : self._size]) @ np.abs(columns)
            terms[:, m - len(system.given.varied) :] += np.abs(matrix[:, self._size :])
            if (off > OFF * terms).any():
                names = sorted(system.given.rows[i] for i in rows)
                raise Unsolved(
                    "the sensitivities have no start: the constraints of equations "
                    f"{', '.join(map(str, names))} cannot hold while the components that `given` "
                    "holds are varied one by one."
                )
        return columns[self._places]

    def _along(self, matrix, columns):
        """The derivatives of equations along the columns, shape (rows, m)."""
        found = matrix[..., : self._size] @ columns
        found[..., self._m - len(self._system.given.varied) :] += matrix[..., self._size :]
        return found

    def of_components(self, t, x, s):
        """The derivatives of all components, (n, m, k), from those of k states, (n_x, m, k)."""
        if len(t) > MANY:
            parts = [slice(k, k + MANY) for k in range(0, len(t), MANY)]
            found = [self.of_components(t[part], x[:, part], s[..., part]) for part in parts]
            return np.concatenate(found, axis=2)
        system = self._system
        n = self._given.n
        z = orders(system, x)
        projected(system, t, z)
        complete(system, t, z)
        d = system.offsets.components
        columns = np.zeros((len(t), self._size, self._m))
        columns[:, self._places] = np.moveaxis(s, -1, 0)
        for slopes, (depth, _, at, _) in zip(self._slopes[:-1], constraints(system), strict=True):
            where = [system.given.columns[j] + (int(d[j]) - depth) * n for j in at]
            matrix = slopes.at(system, t, z)
            a = matrix[:, :, where]
            turned = a.transpose(0, 2, 1)
            columns[:, where] -= turned @ solved(a @ turned, self._along(matrix, columns))
        highest = [int(d[j]) * n + column for j, column in enumerate(system.given.columns)]
        matrix = self._slopes[-1].at(system, t, z)
        columns[:, highest] = -solved(matrix[:, :, highest], self._along(matrix, columns))
        wanted = [order * n + column for column, order in map(system.given.place, range(n))]
        return np.moveaxis(columns[:, wanted], 0, -1)

    def solved(self, problem, z):
        """(The OdeResult of the reduced state, the OdeResult with its sensitivities behind it)."""
        p = problem
        n = len(problem.y0)
        tolerances = Tolerances(p, self._m)
        slots, varied = self._system.given.varied, self._system.given.values[
            list(self._system.given.varied)
        ]  # fmt: skip
        motion = _varied(self._reduction.motion, slots)
        project = p.project and _own_part(_varied(p.project, slots), n, whole=True)
        sizes = [np.abs(d.value).ravel() for d in self._given.directions]
        sizes = np.concatenate(sizes)[np.argsort(self._order)]
        longer = p._replace(
            fun=Variational(motion, p.mode, n, self._positions, self._m, self._given.n),
            mode=SENSITIVITIES, rtol=tolerances.rtol, atol=tolerances.atol(sizes),
            y0=joined(p.y0, self.start(p.t0, z), 1), project=project, jac=None,
            args=(varied, *p.args),
            events=p.events and [
                event.like(_own_part(_varied(event.function, slots), n)) for event in p.events
            ],
        )  # fmt: skip
        try:
            run = run_of(longer)
            if decides(run.bounds[0]):
                longer = longer._replace(dense_output=True)
                run = run_of(longer)
        except Uncompilable as reason:
            raise ValueError(NEEDS.format("sensitivity", reason)) from None
        whole = OdeResult(result_of(longer, run.solve(longer.y0), run))
        if decides(run.bounds[0]) and whole.sol is not None:
            at = jump_of(run.bounds[0], whole.t, lambda t: whole.sol(t)[:n])
            if at is not None:
                raise ValueError(JUMPS.format(at).replace("`fun`", "`F`"))
        return _first(whole, n), whole

    def put(self, result, whole):
        """Add `sensitivity` and `event_sensitivity` to the result of all components."""
        given = self._given
        m = self._m
        n = len(self._places)
        t = np.asarray(result.t)
        if given.t_eval is None:
            states = whole.y[:, : len(t)]
        else:
            states = whole.sol(t) if whole.sol is not None else np.repeat(whole.y[:, :1], len(t), 1)
        found = self.of_components(t, states[:n], states[n:].reshape(n, m, len(t)))
        result["sensitivity"] = by_name(found[:, self._order], given.directions)
        if result.t_events is None:
            return
        found = []
        near = Near(given.t0, given.tf, given.y0)
        events = listed(given.events, {}) or ()
        for event, t, z in zip(events, result.t_events, whole.y_events, strict=True):
            z = np.reshape(z, (-1, n * (1 + m)))[: len(t)].T
            x = z[:n]
            s = z[n:].reshape(n, m, len(t))
            s = self.of_components(t, x, s)[:, self._order]
            y, rate = (components(self._system, t, x, True, rates) for rates in (False, True))
            at = t, y, rate, s
            found.append(event_sensitivity(event, given.args, near, given.directions, at))
        result["event_sensitivity"] = found


def _varied(function, slots):
    """A function of (t, x, p) as one of (t, x, q, p): q stands in the slots of p."""

    def of_varied(t, x, q, p, *args):
        numbers = [*p]
        for i, slot in enumerate(slots):
            numbers[slot] = q[i]
        return function(t, x, numbers, *args)

    return of_varied


def _own_part(function, n, whole=False):
    """A function of n numbers as one of a longer state; `whole`: it returns the longer state."""

    def of_longer(t, z, *args):
        found = function(t, z[:n], *args)
        return [*found, *z[n:]] if whole else found

    return of_longer


def _first(whole, n):
    """The result of the first n components."""
    result = OdeResult(whole)
    result.y = np.asarray(whole.y)[:n]
    if whole.sol is not None:
        sol = whole.sol
        result.sol = type(sol)(sol.ts, sol.polynomials[:, :, :n], sol.spans)
    if whole.y_events is not None:
        result.y_events = [y[:, :n] if y.size else y for y in whole.y_events]
    return result
