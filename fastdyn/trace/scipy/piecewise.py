"""Piecewise polynomials, step functions and polygons, for interpolators."""

from typing import Any

import numpy as np

from ..graph.kinds import INT, NUMPY
from ..symbols.complex_pair import Pair
from ..symbols.conditions import select
from ..symbols.real import Symbol
from ..symbols.symbolic_indices import entry, table_of


class Polynomials:
    """The sum over k of c[k] (x - x_i)^(m - k) between knots, as in SciPy's PPoly.

    Parameters
    ----------
    x : ndarray, shape (n + 1,)
        Knots, increasing.
    c : ndarray, shape (m + 1, n)
    nan : bool
        Whether the value at NaN is NaN even if the pieces are constant.
    """

    def __init__(self, x, c, nan=True):
        self.x, self.c = np.ascontiguousarray(x, float), np.ascontiguousarray(c, float)
        self.nan = nan

    def derivative(self, nu):
        """The nu-th derivative of each piece."""
        c = self.c
        for _ in range(nu):
            c = c[:-1] * np.arange(len(c) - 1, 0, -1.0)[:, None] if len(c) > 1 else 0 * c
        return Polynomials(self.x, c, self.nan)

    def at(self, v):
        g = v.g
        names = tuple([table_of(g, row) for row in (self.x, *self.c)])
        found = Symbol(g, g.make("piecewise", (v.node,), names))
        return select(v.nan(), np.nan, found) if len(self.c) == 1 and self.nan else found


class ComplexColumn:
    """A component whose real and imaginary parts are two components."""

    def __init__(self, real, imag):
        self.real, self.imag = real, imag

    def at(self, v):
        return Pair(self.real.at(v), self.imag.at(v))


class Steps:
    """``heights[searchsorted(bounds, x, side) + shift]``, with the index clipped to `heights`.

    `nan` tells whether the value at NaN is NaN.
    """

    def __init__(self, bounds, heights, side, shift=0, nan=False):
        self.bounds, self.heights = (np.ascontiguousarray(a, float) for a in (bounds, heights))
        self.side, self.shift, self.nan = side, shift, nan

    def derivative(self, nu):
        """The nu-th derivative; 0 if there is one."""
        heights = 0.0 * self.heights if nu else self.heights
        return Steps(self.bounds, heights, self.side, self.shift, nan=self.nan)

    def at(self, v):
        g = v.g
        i = _clipped(_place(self.bounds, v, self.side) + self.shift, 0, len(self.heights) - 1)
        found = entry(g, table_of(g, self.heights), i.node, NUMPY)
        return select(v.nan(), np.nan, found) if self.nan else found


class Line:
    """Linear interpolation that extrapolates the first and the last piece, as in interp1d."""

    def __init__(self, x, y):
        self.x, self.y = np.ascontiguousarray(x, float), np.ascontiguousarray(y, float)

    def at(self, v):
        g, (x, y) = v.g, (table_of(v.g, row) for row in (self.x, self.y))
        after = _clipped(_place(self.x, v, "left"), 1, len(self.x) - 1)
        before = after - 1
        (left, low), (right, high) = (
            [entry(g, name, i.node, NUMPY) for name in (x, y)] for i in (before, after)
        )
        return (high - low) / (right - left) * (v - left) + low


def _place(bounds, v, side):
    g = v.g
    return Symbol(g, g.make("search", (v.node,), (table_of(g, bounds), side)), INT)


def _clipped(i, low, high) -> Any:
    return select(i < low, low, select(i > high, high, i))
