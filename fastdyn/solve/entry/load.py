"""The machine code of the entry in this process: kept on disk as other code, made without Numba.

No solve waits for the code: while Python solves, a thread loads the code, or compiles it in a fresh
installation.
"""

import ctypes
import os
from typing import Any

from fastdyn import code_store
from fastdyn.compile import background

from . import objects

ON = os.environ.get("FASTDYN_ENTRY", "on") != "off"
FASTCALL = 0x80 | 0x02  # METH_FASTCALL with METH_KEYWORDS


class _State:
    """The code, the task of the thread, and whether this process cannot have an entry."""

    code: Any = None
    job: Any = None
    refused = not ON


class _Method(ctypes.Structure):
    _fields_ = (
        ("name", ctypes.c_char_p), ("address", ctypes.c_void_p), ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    )  # fmt: skip


def is_here(wait=0.0):
    """Whether the code is in this process; the first call lets a thread load the code."""
    s = _State
    if s.code is None and not s.refused:
        if s.job is None or (s.job.wait(wait) and s.code is None and not s.refused):
            s.job = background.Job(_make)
        s.job.wait(wait)
    return s.code is not None


def _make():
    try:
        objects.table()
        _State.code = code_store.assembled(f"entry {objects.LAYOUT}", text)
    except (objects.Unknown, code_store.Unsealable):
        _State.refused = True


def text(symbol):
    """The text of an LLVM module with the entry under this name."""
    from llvmlite import ir

    from fastdyn.trace.graph.expressions import LARGEST_WHOLE

    from .follow import Follow
    from .given import Number, Sized, Span, State
    from .result import Result
    from .solve import Entry, Plain, Run

    module = ir.Module()
    number = Number(module)
    state = State(module, number)
    functions = [state, Sized(module), Span(module, number, state), Follow(module, LARGEST_WHOLE)]
    functions += [part(module) for part in (Run, Plain, Result)]
    Entry(module, symbol, {part.function.name: part for part in functions})
    return str(module)


@code_store.first_kept
def _method(address):
    return _Method(b"solver", address, FASTCALL, b"solver($self, y0=None, args=None, /)\n--\n\n")


def callable_of(words, *held):
    """The entry with given words, as a Python function that keeps the objects in `held` alive."""
    code = _State.code
    method = _method(code.address)
    new = ctypes.pythonapi.PyCFunction_NewEx
    thing, address = ctypes.py_object, ctypes.c_void_p
    new.restype, new.argtypes = thing, [address, thing, thing]
    return new(ctypes.addressof(method), (words, code.library, *held), None)
