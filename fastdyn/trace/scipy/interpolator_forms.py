"""The computation of an interpolator: its components, and its values outside the range."""

from typing import Any

import numpy as np

from ..symbols.arrays import Array
from ..symbols.conditions import select
from ..symbols.lazy import complete
from ..symbols.real import symbol
from ..symbols.symbolic import graph_of


class Form:
    """The computation of an interpolator.

    Parameters
    ----------
    columns : list
        One object for each component; ``at(v)`` gives the component's value.
    shape : tuple
        Shape of the value at one number.
    ends : (float, float)
        The range of definition.
    outside : None, str or ((...), (...))
        Values of the components below and above the range.  With None, the components extrapolate.
        A str is the message of the exception that the interpolator raises outside the range.
    axis : int
        The place in `shape` at which the axes of the argument are inserted.
    period : float or None
    finite : bool
        Whether infinite arguments are left to Python, because their result depends on the order of
        operations.
    """

    def __init__(self, columns, shape, ends, outside=None, axis=0, period=None, finite=False):
        self.columns, self.shape, self.ends = columns, shape, ends
        self.outside, self.axis, self.period, self.finite = outside, axis, period, finite

    def at(self, v) -> list:
        low, high = self.ends
        if self.finite and self.outside is None:
            g = v.g
            size = g.make("abs", (v.node,))
            g.leaves_to_python_if(g.compare(size, g.const(np.inf), "eq"))
        if self.period is not None:
            v = low + (v - low) % self.period
        if isinstance(self.outside, str) and (v < low) | (v > high):
            raise ValueError(self.outside)
        values = [column.at(v) for column in self.columns]
        if self.outside is None or isinstance(self.outside, str):
            return values
        ends = zip(values, *self.outside, strict=True)
        return [select(v < low, a, select(v > high, b, one)) for one, a, b in ends]

    def __call__(self, v) -> Any:
        g = graph_of(v)
        values = complete(v)
        if not isinstance(values, np.ndarray | list | tuple):
            return self._shaped(self.at(symbol(g, values)))
        values = Array.of(values)
        flat = [self._shaped(self.at(symbol(g, one))) for one in values.flat]
        result = np.empty((len(flat), *self.shape), dtype=object)
        for i, one in enumerate(flat):
            result[i] = one
        n, result = values.ndim, result.reshape(*values.shape, *self.shape)
        return np.moveaxis(result, range(n), range(self.axis, self.axis + n)).view(Array)

    def _shaped(self, values):
        return Array.of(values).reshape(self.shape) if self.shape else values[0]
