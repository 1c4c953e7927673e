"""Arrays of constants that a symbol may index."""

import warnings
from typing import Any

import numpy as np

from ..graph.domains import WHOLE
from ..graph.kinds import INT, NUMPY
from ..reads.reads import MAX_ARRAY
from ..symbols.arrays import Array
from ..symbols.lazy import complete
from ..symbols.real import Symbol
from ..symbols.symbolic import is_symbolic, refuse
from ..symbols.symbolic_indices import by_elements, chosen, namer, spread

CUT = (
    "a number is stored in an array of whole numbers, which cuts its fraction off, as in SciPy: "
    "make the array of floats, `np.zeros(2)` or `np.array([0.0, 0.0])`."
)
KINDS = {np.dtype(float): NUMPY, np.dtype(np.int64): INT, np.dtype(bool): bool}


class Constants(np.ndarray):
    """An array of constants; symbols may index it."""

    @classmethod
    def made(cls, content):
        """A copy of an array; read-only if long."""
        array = content.copy("K").view(cls)
        array.flags.writeable = content.size <= MAX_ARRAY
        return array

    def watch(self):
        """(kind of object, current content, content before the run), to find writes."""
        if not self.flags.writeable:
            return "an array", [], []
        return "an array", Content(self), [self.tobytes()]

    def reset(self):
        """The array itself, for another run; None if a run may have written to the array."""
        return None if self.flags.writeable else self

    def searchsorted(self, v: Any, side: Any = "left", sorter: Any = None) -> Any:
        if not is_symbolic(v):
            return super().searchsorted(v, side, sorter)
        return np.searchsorted(self, v, side, sorter)

    def __setitem__(self, key, value):
        if not self.flags.writeable:
            refuse("it changes an array", final=True)
        if is_symbolic(key):
            refuse("a store at an index that depends on the state")
        if self.dtype.kind in "iu" and isinstance(value, Symbol) and value.kind != INT:
            warnings.warn(CUT, UserWarning, stacklevel=2)
        super().__setitem__(key, value)

    def __getitem__(self, key) -> Any:
        key = complete(key)
        if not is_symbolic(key):
            return super().__getitem__(key)
        found = by_elements(self, key)
        if found is not None:
            return found.view(Array)
        parts, kind = spread(key, self.ndim), KINDS.get(self.dtype)
        if parts is None or kind is None or not _are_exact(self):
            return super().__getitem__(key)
        if not is_symbolic(parts):
            return super().__getitem__(parts)
        g = next(k for k in parts if isinstance(k, Symbol)).g
        flat = np.ascontiguousarray(self.view(np.ndarray)).reshape(-1)
        at = np.arange(self.size).reshape(self.shape)
        found = chosen(at, parts, namer(g, flat), kind)
        if found is None:
            return Array.of(self.view(np.ndarray))[key]
        return found.view(Array) if isinstance(found, np.ndarray) else found


def _are_exact(array):
    if array.dtype != np.int64 or not array.size:
        return True
    return -WHOLE <= array.min() and array.max() <= WHOLE


class Content:
    """The content of an array, compared to find out whether a run wrote to it."""

    def __init__(self, array):
        self.array = array

    def __iter__(self):
        return iter([self.array.tobytes()])
