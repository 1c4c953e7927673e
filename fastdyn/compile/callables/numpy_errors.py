"""Tells whether NumPy's floating-point errors raise or call a handler."""

from typing import Any

import numpy as np
from numpy._core import umath

# NumPy's error state, which not all versions have; each new setting is a new object.
state: Any = getattr(umath, "_extobj_contextvar", None)
REASON = "NumPy's errors are exceptions here (np.errstate, np.seterr)"
USUAL = None if state is None else state.get()


def are_heard():
    """Whether NumPy reports errors; functions then run in Python, as compiled code reports none."""
    if state is not None and state.get() is USUAL:
        return False
    return not {"ignore", "warn"}.issuperset(np.geterr().values())
