"""A compiled function of the user, by tracing or by Numba."""

import math
import threading
from dataclasses import dataclass, field
from typing import Any

from ..mode import DERIVATIVE, Mode

_growing = threading.Lock()  # one thread at a time may extend a graph


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

    def derived(self, place, make) -> Any:
        """What `make()` derives from this function and its graph, made once: see `notes`."""
        with _growing:
            if place not in self.notes:
                self.notes[place] = make()
            return self.notes[place]
