"""Tells whether a value is an `@njit` function, without importing Numba."""

import sys
from typing import Any, TypeGuard


def is_jitted(value) -> TypeGuard[Any]:
    """Whether `value` is a Numba dispatcher; without Numba in the process, no value is."""
    module = sys.modules.get("numba.core.dispatcher")
    kind = getattr(module, "Dispatcher", None)
    return kind is not None and isinstance(value, kind)
