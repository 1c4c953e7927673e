"""The state that a traced function gets, and its results, number by number."""

import numpy as np

from ..graph.refusal import Refusal
from ..symbols.arrays import Array
from ..symbols.complex_pair import Pair, is_complex, parts
from ..symbols.real import Symbol, symbol


class Numbers:
    """A state of symbols.

    Parameters
    ----------
    g : Graph
    n : int
        Number of components.
    zeros : int
        Number of constant zeros behind the components.
    complex_state : bool
        Whether entries 2 i and 2 i + 1 are the real and the imaginary part of component i.
    """

    def __init__(self, g, n, zeros=0, complex_state=False):
        self.g, self.complex_state = g, complex_state
        self._states: list = [Symbol(g, g.make("y", (), i)) for i in range(n * (1 + complex_state))]
        self._states += [Symbol(g, g.const(0.0)) for _ in range(zeros)]
        if complex_state:
            pairs = zip(self._states[::2], self._states[1::2], strict=True)
            self._states = [Pair(*pair) for pair in pairs]

    def start(self):
        """A new array of the state for a run."""
        return Array.of(self._states)

    def written(self, y):
        """Whether a run wrote to its state."""
        return any(a is not b for a, b in zip(y.flat, self._states, strict=True))

    def results(self, result, shape):
        """The nodes of a result; two nodes for each complex number."""
        g, flat = self.g, _flat(result)
        size = 1 if shape is None else int(np.prod(shape))
        if len(flat) == 1 and size > 1 and not isinstance(result, list | tuple | np.ndarray):
            flat *= size
        if len(flat) != size:
            raise Refusal(f"it returns {len(flat)} numbers, not {size}")
        if self.complex_state and shape is not None:
            return [symbol(g, part).node for v in flat for part in parts(v)]
        if any(map(is_complex, flat)):
            raise Refusal("it returns complex numbers")
        return [symbol(g, v).node for v in flat]

    def chosen(self, node, yes, no):
        """Select the results `yes` or `no` by the condition `node`."""
        return [self.g.select(node, a, b) for a, b in zip(yes, no, strict=True)]

    def lost(self, n):
        """The results of a path that raises or is left to Python: n times NaN."""
        return [self.g.const(np.nan)] * n


def _flat(value):
    if isinstance(value, np.ndarray):
        return [v for each in value.reshape(-1).tolist() for v in _flat(each)]
    if isinstance(value, list | tuple):
        return [v for each in value for v in _flat(each)]
    return [value]
