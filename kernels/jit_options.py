"""How kernels are compiled: options of Numba, and its decorator, which nothing switches off."""

import contextlib

import numba
from numba import config

# Of every kernel.  Numba's entry points for Python and C are left out: the one way in is by words,
# see calls/calling_convention.py.
INTERNAL = {
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
    "error_model": "numpy",
    "nogil": True,
    "forceinline": False,  # else Numba takes that of whoever calls it first
}

# Of kernels that take functions: a function left as a run-time argument would be a pointer into
# this process, and the code could not be kept on disk.
INLINED = {**INTERNAL, "forceinline": True}


@contextlib.contextmanager
def jit_enabled():
    """While it holds, decorators compile although NUMBA_DISABLE_JIT is set."""
    before, config.DISABLE_JIT = config.DISABLE_JIT, 0
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
