"""F and its Jacobians at a fixed time, for the work before the first step."""

import copy
from typing import Any

import numpy as np

from fastdyn.code_store import Call
from fastdyn.compile.derivatives.jacobian_block import entries_of, groups_of
from fastdyn.run.matrices.residual import pattern_of_residual
from fastdyn.specialise.scalar import evaluate_kernel

STEP = np.finfo(float).eps ** (1 / 3)
DENSE = 500  # equations, up to which matrices are full
ROUNDING, OF_DIFFERENCES = 1e-11, 1e-6  # of elements, relative to the largest


class Equations:
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

    def residual(self, both):
        """The n numbers of F."""
        return np.asarray(self._bound.python(self._t, both.copy()), float)[: self.n]

    def jacobian(self, both):
        """[dF/dy, dF/dy'], (n, 2 n): sparse for many equations."""
        if self._address:
            entries, block = self._entries, self._bound.block.copy()
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
        entries, n = self.pattern.both, self.n
        group, numbers = groups_of(entries, 2 * n), np.zeros(len(entries.rows))
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
        high, low = both + steps, both - steps
        above, below = self.residual(high), self.residual(low)
        change = above - below
        rounding = np.finfo(float).eps * (np.abs(above) + np.abs(below))
        return np.where(np.abs(change) <= 4 * rounding, 0.0, change), high - low

    def rates(self, both):
        """Which components' derivatives occur in F."""
        if self.pattern is not None:
            return self.pattern.rates
        found, rng = np.zeros(self.n, bool), np.random.default_rng(0)
        for k in range(3):
            near = both + 0.1 * k * rng.uniform(0.5, 1.0, len(both)) * np.maximum(np.abs(both), 1.0)
            columns = [self._column(near, self.n + j) for j in range(self.n)]
            found |= [bool(np.any(np.nan_to_num(column) != 0.0)) for column in columns]
        return found
