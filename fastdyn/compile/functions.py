"""Compiled functions of the user, and Bounds: a function with the values of one solve.

A kernel calls machine code, or a callback into Python, by the block of a Bound.
"""

import math
import threading
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from fastdyn.kernels.calls.block import FAULT, FIRST

from .mode import DERIVATIVE, Mode
from .parameters import n_words, pack_all
from .python_callback import Callback, Held

BASE = "base"  # in the notes of a Function for sensitivities: the Function that it extends
GROWING = threading.RLock()  # one thread at a time may extend a graph


@dataclass(eq=False, slots=True)
class Function:
    """A compiled function of the user.

    Attributes
    ----------
    key : str
        Names the code on disk.
    address : int
        The address of the machine code ``function(t, y, n, block, out)``; 0 for a constant matrix.
    n_words : int
        Words of the parameters in a block.
    build : callable
        Makes a Numba dispatcher of the same function, for kernels that inline the function.
    keepalive : object
        Keeps the machine code in memory.
    seconds : float
        An upper bound for the time of an evaluation, if known.
    series : callable
        ``series(order)`` is the Taylor kernel.
    traced : Traced or None
        The trace.
    notes : dict
        Facts that live as long as the function: kernels around it, its Jacobian, comparisons.
    """

    key: str
    address: Any
    n_words: int
    build: Any
    keepalive: Any
    mode: Mode = DERIVATIVE
    seconds: float = math.inf
    series: Any = None
    traced: Any = None
    notes: dict = field(default_factory=dict)

    @property
    def in_batches(self):
        """Whether the function was traced as one on long arrays."""
        return self.traced is not None and self.traced.in_batches

    def derived(self, place, make) -> Any:
        """The result that `make()` derives from function and graph, once: see `notes`."""
        with GROWING:
            if place not in self.notes:
                self.notes[place] = make()
            return self.notes[place]


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
    held: Held
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
        if self.held.values is not None:
            return self.held.values
        return [value for _, value in self.values]

    def word(self, j):
        """The index of the block's first word for argument j."""
        return FIRST + sum([n_words(k) for k, _ in self.values[: self.at[j]]])


def with_code(function, python, held, parameters, mode, n, at=()):
    """The Bound of a compiled function of n components."""
    end = FIRST + function.n_words
    block = np.zeros(end + n, np.int64)
    block[0] = function.address
    block[FAULT] = end
    if parameters:
        pack_all(parameters, block, held.memory)
    return Bound(function, block, python, held, None, parameters, mode, (), {}, at)


def with_callback(callback, python, held, mode, block=None):
    """The Bound of a function that runs in Python."""
    block = np.zeros(FIRST, np.int64) if block is None else block
    block[0] = callback.address
    return Bound(None, block, python, held, callback, [], mode)
