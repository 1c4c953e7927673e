"""Kernels that few solves of implicit methods need, compiled when a solve calls one.

Small traced equations have an exact Jacobian, and straight-line code that eliminates their
matrices.  Differences, the user's Jacobians, bands, sparse matrices and our own elimination are
kernels of their own, shared by all implicit methods: they were a quarter of a first solve.  In the
place of a kernel's address, the first call finds a function that loads or compiles the kernel.
"""

import ctypes
import threading

import numpy as np

from fastdyn.code_store.call import KERNEL, address_of
from fastdyn.kernels.calls.block import RAISED_WORD
from fastdyn.kernels.state.record import RAISED

from .scalar import kernel_for_all

# In the order of `kernels/calls/block.py`: the name, and the word with the address of the block.
KERNELS = (
    ("other jacobian", 8),
    ("other factors", 5),
    ("other solution", 5),
    ("other complex factors", 5),
    ("other complex solution", 5),
)
_failures: dict = {}  # what a thread raised while it compiled a kernel


def _stand_in(at, name, word):
    """The function that the first call finds; later calls find the kernel."""
    load = kernel_for_all(name)

    @KERNEL
    def kernel(words):
        try:
            address = addresses[at] = load().address
        except BaseException as error:  # the solve ends as if the equations had raised
            _failures[threading.get_ident()] = error
            block = ctypes.c_void_p.from_address(words + 8 * word).value or 0
            ctypes.c_int64.from_address(block + 8 * RAISED_WORD).value = 1
            return RAISED
        return KERNEL(address)(words)

    return kernel


def raise_failure():
    """Raise what a kernel's compilation raised within a solve, if anything."""
    if _failures and (error := _failures.pop(threading.get_ident(), None)):
        raise error


_stand_ins = [_stand_in(at, *kernel) for at, kernel in enumerate(KERNELS)]
_places = [ctypes.cast(f, ctypes.c_void_p).value for f in _stand_ins]
addresses = np.array([*_places, 0], np.int64)  # 0: without a past
ADDRESS = address_of(addresses)  # the word RARE of a block
