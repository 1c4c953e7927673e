"""How kernels are compiled: options of Numba, and its decorator, which nothing switches off."""

import contextlib

import numba
from numba import config

try:
    from .pipeline import Lean
except (ImportError, AttributeError):  # a Numba whose inner parts differ: its own pipeline
    LEAN = {}
else:
    LEAN = {"pipeline_class": Lean}

# Options of functions that may own memory, as users' functions do.
OWNING = {
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "error_model": "numpy",
    "nogil": True,
    "forceinline": False,  # without this line, Numba takes the option of the first caller
}
OWNING_INLINED = {**OWNING, "forceinline": True}

# Options of every kernel.  Kernels have no entry points of Numba for Python and C, because they are
# called by words only: see ../calls/calling_convention.py.
INTERNAL = {**OWNING, **LEAN}

# Options of kernels that take functions.  A function passed at run time would be a pointer into
# this process, and the code could not be kept on disk.
INLINED = {**INTERNAL, "forceinline": True}


@contextlib.contextmanager
def jit_enabled():
    """A context in which decorators compile although NUMBA_DISABLE_JIT is set."""
    before = config.DISABLE_JIT
    config.DISABLE_JIT = 0
    try:
        yield
    finally:
        config.DISABLE_JIT = before


def njit(**options):
    """`numba.njit`, also where NUMBA_DISABLE_JIT is set: kernels have no form in Python."""

    def decorate(function):
        with jit_enabled():
            return numba.njit(**options)(function)

    return decorate
