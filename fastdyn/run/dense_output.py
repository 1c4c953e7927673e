"""The continuous solution, the field `sol` of a result."""

from functools import cached_property
from typing import Any

import numpy as np


class OdeSolution:
    """The continuous solution: ``sol(t)`` has shape (n,), or (n, k) for k times.

    Parameters are those of `scipy.integrate.OdeSolution`.  Times outside the span are extrapolated
    from the nearest step.  At the common end of two segments the earlier segment holds, or the
    later segment if `alt_segment` is set.

    Parameters
    ----------
    ts : array_like, shape (n_segments + 1,)
        Ends of the segments, strictly monotonic.
    interpolants : list of callable
        One for each segment: ``interpolant(t)`` with the shape of ``sol(t)``.
    alt_segment : bool
    """

    def __init__(self, ts, interpolants, alt_segment=False):
        ts = np.asarray(ts)
        steps = np.diff(ts)
        of_no_length = ts.size == 2 and ts[0] == ts[-1]
        if not (of_no_length or np.all(steps > 0) or np.all(steps < 0)):
            raise ValueError("`ts` must be strictly increasing or decreasing.")
        if ts.shape != (len(interpolants) + 1,):
            raise ValueError("Numbers of time stamps and interpolants don't match.")
        self.interpolants: Any = interpolants
        self._lay_out(ts, alt_segment)

    def __repr__(self):
        span = f"t = {self.ts[0]:g} to {self.ts[-1]:g}"
        return f"<OdeSolution: {span}, {self.n_segments} segments>"

    def _lay_out(self, ts, alt_segment):
        self.ts, self.n_segments = ts, len(ts) - 1
        self.ascending = bool(ts[-1] >= ts[0])
        self.t_min, self.t_max = (ts[0], ts[-1]) if self.ascending else (ts[-1], ts[0])
        self._side: Any = "left" if self.ascending != bool(alt_segment) else "right"

    def _segments(self, times):
        """The segment of each time."""
        if self.ascending:
            found = np.searchsorted(self.ts, times, side=self._side) - 1
        else:
            found = self.n_segments - np.searchsorted(self.ts[::-1], times, side=self._side)
        return np.clip(found, 0, self.n_segments - 1)

    def __call__(self, t):
        t = np.asarray(t, dtype=float)
        if t.ndim > 1:
            raise ValueError("`t` must be a float or a 1-D array.")
        times = np.atleast_1d(t)
        y = self._values(times, self._segments(times))
        return y[:, 0] if t.ndim == 0 else y

    def _values(self, times, segments):
        """States of shape (n, k) at the k times, each in its segment."""
        found = {s: np.asarray(self.interpolants[s](times[segments == s])) for s in set(segments)}
        first = next(iter(found.values()), np.empty((0, 0)))
        y = np.empty((len(first), len(times)), first.dtype)
        for s, values in found.items():
            y[:, segments == s] = values
        return y


def floors_of(nonnegative, n_segments):
    """The floors of a PiecewisePolynomial, 0 where `nonnegative`, n bools or None, is True."""
    if nonnegative is None:
        return None
    return np.broadcast_to(np.where(nonnegative, 0.0, -np.inf), (n_segments, len(nonnegative)))


class PiecewisePolynomial(OdeSolution):
    """The continuous solution of our own methods, evaluated for all times at once.

    Parameters
    ----------
    ts : ndarray, shape (n_segments + 1,)
    polynomials : ndarray, shape (n_segments, rows, n)
        See `kernels.output.dense_output`.
    spans : ndarray, shape (n_segments, 2)
        Start and length of the step that each polynomial belongs to.
    floors : ndarray, shape (n_segments, n), optional
        The least value of each component, -inf for a component without a bound.
    """

    def __init__(self, ts, polynomials, spans, floors=None):
        self.polynomials = polynomials
        self.spans = spans
        self.floors = floors
        self._lay_out(ts, False)

    def _values(self, times, segments):
        y = self._expanded(times, segments)[0]
        return (y if self.floors is None else np.maximum(y, self.floors[segments])).T

    def derivative(self, t):
        """The derivative of the polynomials by t, in the shape of ``sol(t)``."""
        times = np.atleast_1d(np.asarray(t, dtype=float))
        segments = self._segments(times)
        found = (self._expanded(times, segments)[1] / self.spans[segments, 1:]).T
        return found[:, 0] if np.ndim(t) == 0 else found

    def _expanded(self, times, segments):
        """Values and derivatives by x = (t - t_old) / h, one row a time."""
        start, length = self.spans[segments].T
        x = ((times - start) / length)[:, None]
        d = self.polynomials[segments]
        total = np.zeros_like(d[:, 0])
        slope = np.zeros_like(d[:, 0])
        for j in range(d.shape[1] - 1, 0, -1):
            total = d[:, j] + total
            way = 1.0 if (j - 1) % 2 == 0 else -1.0
            factor = x if way > 0 else 1 - x
            slope = slope * factor + way * total
            total = total * factor
        return d[:, 0] + total, slope

    @cached_property
    def interpolants(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        """One solution a segment, with the attributes `t_old` and `t` of SciPy's interpolants."""
        parts = []
        for i in range(self.n_segments):
            one = slice(i, i + 1)
            floors = None if self.floors is None else self.floors[one]
            part: Any = PiecewisePolynomial(
                self.ts[i : i + 2], self.polynomials[one], self.spans[one], floors
            )
            part.t_old, part.t = self.ts[i : i + 2]
            parts.append(part)
        return parts
