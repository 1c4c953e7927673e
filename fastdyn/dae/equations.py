"""F and its Jacobians at a fixed time, for the work before the first step."""

import copy
from typing import Any

import numpy as np

from fastdyn.code_store import Call
from fastdyn.compile.derivatives.jacobian_block import entries_of, groups_of
from fastdyn.run.matrices.check_jacobian import STEP
from fastdyn.run.matrices.residual import pattern_of_residual
from fastdyn.specialise.scalar import evaluate_kernel

SHARE = 0.1  # of its size, by which a number is displaced
DENSE = 200  # equations, up to which matrices are full
ROUNDING, OF_DIFFERENCES = 1e-12, 1e-8  # of elements, relative to the largest


class StartEquations:
    """F at the start time, as a function of [y, y'].

    Attributes
    ----------
    n : int
    pattern : Pattern or None
        Where the Jacobians may have elements; None if that is not known.
    noise : float
        Relative errors of the Jacobians' elements.
    """

    def __init__(self, problem, bound, block):
        p = problem
        self._t, self._bound, self.n = p.t0, bound, len(p.y0) // 2
        self.pattern: Any = pattern_of_residual(bound, block, self.n)
        self._entries: Any = entries_of(block, 2 * self.n)
        self._address = 0 if self._entries is None else block[0]
        self.noise = ROUNDING if self._address else OF_DIFFERENCES

    def at(self, t):
        """F at another time."""
        other = copy.copy(self)
        other._t = t
        return other

    def raise_own(self, both):
        """Raise the exception that F raises at [y, y']."""
        with np.errstate(all="ignore"):
            self._bound.python(self._t, both.copy())

    def residual(self, both):
        """The n numbers of F; NaN where F raises, at a state that the user did not give."""
        try:
            with np.errstate(all="ignore"):
                return np.asarray(self._bound.python(self._t, both.copy()), float)[: self.n]
        except (ArithmeticError, ValueError):
            return np.full(self.n, np.nan)

    def by_time(self, both, step):
        """dF/dt, from times ahead alone: F may begin at the start."""
        here, next_, last = (self.at(self._t + k * step).residual(both) for k in range(3))
        return (4.0 * next_ - 3.0 * here - last) / (2.0 * step)

    def jacobian(self, both):
        """[dF/dy, dF/dy'], (n, 2 n): sparse for many equations."""
        if self._address:
            entries = self._entries
            block = self._bound.block.copy()
            block[0] = self._address
            numbers = np.full(len(entries.rows), np.nan)
            Call(evaluate_kernel(), block, self._t, np.ascontiguousarray(both), numbers)()
            if np.isfinite(numbers).all():
                return self._matrix(numbers, entries)
        if self.pattern is not None:
            return self._matrix(*self._by_groups(both))
        return np.column_stack([self._column(both, j) for j in range(2 * self.n)])

    def _matrix(self, numbers, entries):
        shape = self.n, 2 * self.n
        if self.n > DENSE:
            from scipy.sparse import csc_matrix

            return csc_matrix((numbers, (entries.rows, entries.columns)), shape)
        matrix = np.zeros(shape)
        matrix[entries.rows, entries.columns] = numbers
        return matrix

    def _by_groups(self, both):
        """(elements, Entries) by differences, for many columns at once."""
        entries = self.pattern.both
        n = self.n
        group = groups_of(entries, 2 * n)
        numbers = np.zeros(len(entries.rows))
        for g in range(group.max(initial=-1) + 1):
            change, steps = self._difference(both, group == g)
            mine = group[entries.columns] == g
            numbers[mine] = change[entries.rows[mine]] / steps[entries.columns[mine]]
        return numbers, entries

    def _column(self, both, j):
        """A column by differences."""
        change, steps = self._difference(both, np.arange(len(both)) == j)
        return change / steps[j]

    def _difference(self, both, which):
        """The central difference of F between displacements of some numbers; their distances."""
        steps = np.where(which, STEP * np.maximum(np.abs(both), 1e-3), 0.0)
        high = both + steps
        low = both - steps
        above = self.residual(high)
        below = self.residual(low)
        change = above - below
        rounding = np.finfo(float).eps * (np.abs(above) + np.abs(below))
        return np.where(np.abs(change) <= 4 * rounding, 0.0, change), high - low

    def rates(self, both):
        """Which components' derivatives occur in F, by the structure and by numbers.

        A derivative that is multiplied by 0 does not occur; one that is squared does, even at 0.
        """
        found = np.zeros(self.n, bool)
        for state in (both, *beside(both)):
            if self.pattern is None:
                columns = [self._column(state, self.n + j) for j in range(self.n)]
                values = np.column_stack(columns)
            else:
                values = self.jacobian(state)[:, self.n :]
            found |= np.asarray((values != 0.0).sum(axis=0)).ravel() > 0  # NaN differs from 0
        return found


def beside(both):
    """Two states and derivatives beside given ones."""
    rng = np.random.default_rng(0)
    size = np.where(both == 0.0, 1.0, np.abs(both))
    return [both + SHARE * rng.uniform(0.5, 1.0, len(both)) * size for _ in range(2)]
