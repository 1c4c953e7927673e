"""Special functions: compiled code calls SciPy's C functions by their addresses.

The addresses are parameters of the code, because an address is valid in one process only.
"""

import ctypes
import functools
import sys
from typing import Any

import numpy as np

from ..graph.kinds import NUMPY
from ..symbols.arrays import elementwise
from ..symbols.complex_pair import is_complex
from ..symbols.real import Symbol, symbol
from ..symbols.symbolic import Symbolic, graph_of
from .island import Address

FORMS = {  # signatures of Cython's functions: number of arguments
    f"double ({'double, ' * n}int __pyx_skip_dispatch)": n for n in range(1, 8)
}


class InC:
    """A special function in C, together with its NumPy ufunc."""

    def __init__(self, ufunc, address):
        self.ufunc, self.address = ufunc, Address(address)
        self.address.of = self

    def values(self, args):
        with np.errstate(all="ignore"):
            return self.ufunc(*args)


@functools.cache
def in_c(ufunc):
    """The InC of a SciPy ufunc with a C function for real numbers; None for any other ufunc."""
    name, special = ufunc.__name__, sys.modules.get("scipy.special")
    if special is None or getattr(special, name, None) is not ufunc:
        return None
    from scipy.special import cython_special

    capsules: Any = cython_special.__pyx_capi__  # pyright: ignore[reportAttributeAccessIssue]
    api = ctypes.pythonapi
    form, pointer = api.PyCapsule_GetName, api.PyCapsule_GetPointer
    form.restype, form.argtypes = ctypes.c_char_p, [ctypes.py_object]
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    for fused in ("", "__pyx_fuse_0", "__pyx_fuse_1"):
        capsule = capsules.get(fused + name)
        if capsule is not None and FORMS.get(form(capsule).decode()) == ufunc.nin:
            return InC(ufunc, pointer(capsule, form(capsule)))
    return None


def by_address(ufunc, *args) -> Any:
    """``ufunc(*args)`` by the C function of the ufunc; NotImplemented if there is no C function."""
    known = in_c(ufunc) if ufunc.nout == 1 else None
    if known is None or _any_complex(args):
        return NotImplemented
    g = graph_of(args)
    (slot,) = g.reads.parameters(g.reads.step(g.reads.root(0), "island", known), known.address)
    g.islands[slot] = known

    def one(*values):
        if not any(isinstance(v, Symbolic) for v in values):
            return ufunc(*values)
        return Symbol(g, g.make("in c", [symbol(g, v).node for v in values], (slot,)), NUMPY)

    return elementwise(one, *args)


def _any_complex(args):
    return any(is_complex(v) for a in args for v in np.asarray(a, dtype=object).flat)
