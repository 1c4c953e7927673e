"""Kernels without the functions that they call: kept as LLVM's bitcode, linked to any functions.

Numba makes such a kernel once for a method and a length of the state.  LLVM alone links the kernel
to the texts of functions and optimises all together, in a tenth of the time and without the
interpreter lock.
"""

# Numba and llvmlite declare fewer attributes than their objects have.
# pyright: reportAttributeAccessIssue=false

from typing import NamedTuple

import llvmlite.binding as llvm

from .loader import initialise
from .target import drop_unused, for_machine, internal, optimise, settled, target

FUNCTION = "fastdyn_function"  # the name of the function; several functions append a number
KERNEL = "fastdyn_kernel"


class Unlinked(NamedTuple):
    """A kernel before its functions are known, and the layout of its arguments."""

    bitcode: bytes
    arguments: list


def linked(kernel, texts, symbol, look):
    """(object code, needs) of a kernel and of functions, each the LLVM text of its name.

    ``look()`` is called between LLVM's phases, and may raise an exception.
    """
    initialise()
    context = llvm.create_context()  # a shared context never frees memory
    module = llvm.parse_bitcode(kernel.bitcode, context)
    for_machine(module, target())
    for name, text in texts.items():
        function = llvm.parse_assembly(text, context)
        function.triple = module.triple
        function.data_layout = module.data_layout
        internal(function, name)
        module.link_in(function)
    module.get_function(KERNEL).name = symbol
    internal(module, symbol)
    look()
    optimise(module, look)
    return settled(module, symbol)


def without_function(module):
    """The bitcode of a module with `KERNEL`, which calls `FUNCTION`."""
    internal(module, KERNEL)
    drop_unused(module)
    return module.as_bitcode()
