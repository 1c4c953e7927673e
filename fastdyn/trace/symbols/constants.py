"""Arrays of whole numbers and truth values, which no symbol can be stored in, but may index."""

import warnings
from typing import Any

import numpy as np

from .lift import symbol
from .lookup import item
from .symbol import graph_of, is_plain, is_symbolic, refuse

CUT = (
    "a number is stored in an array of whole numbers, which cuts its fraction off, as in SciPy: "
    "make the array of floats, `np.zeros(2)` or `np.array([0.0, 0.0])`."
)


class Constants(np.ndarray):
    """An array of constants; its arithmetic is NumPy's own."""

    def __getitem__(self, key) -> Any:
        if is_plain(key):
            return super().__getitem__(key)
        return item(symbol(_graph(key), self.view(np.ndarray)), key)

    def __setitem__(self, key, value):
        if not is_plain(key):
            refuse("a store at an index that depends on the state")
        if self.dtype.kind in "iu" and is_symbolic(value):
            if symbol(graph_of(value), value).kind != "i":
                warnings.warn(CUT, UserWarning, stacklevel=2)
        super().__setitem__(key, value)

    def searchsorted(self, v: Any, side: Any = "left", sorter: Any = None) -> Any:
        if not is_symbolic(v):
            return super().searchsorted(v, side, sorter)
        return np.searchsorted(self.view(np.ndarray), v, side, sorter)


def _graph(key):
    return graph_of(*key) if isinstance(key, tuple) else graph_of(key)
