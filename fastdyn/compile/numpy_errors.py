"""Whether NumPy raises, or calls something, where its numbers overflow or are none."""

from typing import Any

import numpy as np

state: Any = None  # what NumPy looks at; the object is another one where a setting was changed
try:
    from numpy._core.umath import _extobj_contextvar as state
except ImportError:  # of another version
    pass
_usual = None if state is None else state.get()


def are_heard():
    """Whether a function must run in Python, because compiled code makes no errors."""
    if state is not None and state.get() is _usual:
        return False
    return not {"ignore", "warn"}.issuperset(np.geterr().values())
