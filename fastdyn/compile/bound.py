"""A bound function: machine code or a callback, and the block that kernels pass to either."""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.kernels.calls.block import FAULT, FIRST

from .callables.compiled import Function
from .mode import Mode
from .parameters import n_words, pack_all
from .python_callback import Callback


class Bound(NamedTuple):
    """A function with the parameter values of one solve.

    `python(t, y)` is the function as written.  `values` has a (type, value) for each parameter;
    `at` has the indices of the arguments in `values`.  `pair` has the two functions of
    a Pair (`fastdyn/problem/second_order_and_pairs.py`), and is empty for any other function.
    `seen` stores what `rebind` knows about the outside values.
    """

    function: Function | None
    block: np.ndarray
    python: Any
    keepalive: list
    callback: Callback | None
    values: list
    mode: Mode
    pair: tuple = ()
    seen: Any = None
    at: tuple = ()

    @property
    def n(self):
        """The number of components of a compiled function's y.

        The block ends with one word a component: the state at the first exception.
        """
        return len(self.block) - int(self.block[FAULT])

    @property
    def given(self):
        """The present values of the parameters, by group."""
        kept = self.keepalive
        if len(kept) == 4 and kept[2] is self.function:  # as `rebind` leaves it
            return kept[3]
        return [value for _, value in self.values]

    def word(self, j):
        """The index of the block's first word for argument j."""
        return FIRST + sum([n_words(k) for k, _ in self.values[: self.at[j]]])


def with_code(function, python, keepalive, parameters, mode, n, at=()):
    """The Bound of a compiled function of n components; `keepalive` gets the function, too."""
    end = FIRST + function.n_words
    block = np.zeros(end + n, np.int64)
    block[0], block[FAULT] = function.address, end
    if parameters:
        pack_all(parameters, block, keepalive)
    keepalive.append(function)
    return Bound(function, block, python, keepalive, None, parameters, mode, (), {}, at)


def with_callback(callback, python, keepalive, mode, block=None):
    """The Bound of a function that runs in Python."""
    block = np.zeros(FIRST, np.int64) if block is None else block
    block[0] = callback.address
    return Bound(None, block, python, [*keepalive, callback], callback, [], mode)
