"""The outputs of a solve in shapes that are known before it; what is not reached is nan."""

import math
from typing import Any, NamedTuple

import numpy as np


class Solution(NamedTuple):
    """The result of a solve inside another library.

    Attributes
    ----------
    t : array, shape (n_points,)
        The times of output.
    y : array, shape (n, n_points)
        The states there; nan where the run has ended before.
    t_events, y_events : tuple of arrays, or None
        For each event, its first occurrences, of shape (occurrences,), and the states there, of
        shape (occurrences, n); nan for those that there are not.
    status : array of int
        As in `OdeResult`: 0 for the end of the span, 1 for an event that ends the run, -1 for a
        failure.
    """

    t: Any
    y: Any
    t_events: Any
    y_events: Any
    status: Any


class Shapes(NamedTuple):
    """The numbers of components, times of output, events, and occurrences of each event."""

    n: int
    n_points: int
    n_events: int
    occurrences: int

    def arrays(self):
        """The shapes of the arrays of outputs: y, the times of each event and its states."""
        k = self.occurrences
        return [(self.n, self.n_points), *[(k,), (k, self.n)] * self.n_events]

    @property
    def size(self):
        """The number of all numbers in the outputs."""
        return sum([math.prod(shape) for shape in self.arrays()])

    def unreached(self):
        """Arrays full of nan."""
        return [np.full(shape, np.nan) for shape in self.arrays()]

    def outputs(self, result):
        """The arrays of outputs of an OdeResult."""
        rows = result.y.T if len(result.t) else np.empty((0, self.n))  # SciPy's empty y is a list
        found = [np.ascontiguousarray(padded(rows, self.n_points).T)]
        for i in range(self.n_events):
            times = result.t_events[i]
            states = result.y_events[i] if len(times) else np.empty((0, self.n))
            found += [padded(each, self.occurrences) for each in (times, states)]
        return found

    def solution(self, t, arrays, status):
        """The Solution of arrays of outputs."""
        at_events = (None, None)
        if self.n_events:
            at_events = tuple(arrays[1::2]), tuple(arrays[2::2])
        return Solution(t, arrays[0], *at_events, status)

    def slopes(self, result, names):
        """For each array of outputs, its derivatives of shape (..., m) by all directions in a row.

        `result` is one with sensitivities, `names` are those of the directions.
        """
        m = sum([math.prod(result.sensitivity[name].shape[1:-1]) for name in names])
        if not m:
            return [np.zeros((*shape, 0)) for shape in self.arrays()]

        def rows(of_names, *before):
            """The derivatives by names, (*before, ..., k), as one array (k, *before, m)."""
            parts = [of_names[name] for name in names]
            k = parts[0].shape[-1]
            axes = len(before)
            flat = [p.reshape(*before, math.prod(p.shape[axes:-1]), k) for p in parts]
            whole = flat[0] if len(flat) == 1 else np.concatenate(flat, axis=-2)
            return whole.transpose(axes + 1, *range(axes + 1))

        found = [padded(rows(result.sensitivity, self.n), self.n_points).transpose(1, 0, 2)]
        for i in range(self.n_events):
            each = result.event_sensitivity[i]
            if each is None:  # an event without derivatives
                found += [np.full((*s, m), np.nan) for s in self.arrays()[1 + 2 * i : 3 + 2 * i]]
            else:
                own = rows(each.t), rows(each.y, self.n)
                found += [padded(each, self.occurrences) for each in own]
        return found


def padded(rows, n):
    """The first n rows; rows of nan stand for those that there are not."""
    missing = n - len(rows)
    if missing <= 0:
        return rows[:n]
    return np.concatenate([rows, np.full((missing, *rows.shape[1:]), np.nan)])


def contracted(slopes, g):
    """The derivatives by the directions, from slopes and the derivatives `g` by the outputs.

    An output on which nothing depends, with a `g` of 0, may be nan.
    """
    total: Any = 0.0
    for slope, each in zip(slopes, g, strict=True):
        used = np.asarray(each) != 0
        total = total + np.asarray(each)[used] @ slope[used]
    return total
