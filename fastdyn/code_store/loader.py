"""Loading of object code: each file in a name space of its own, its needs from a closed list."""

import ctypes
import functools
import importlib.machinery
import importlib.util
import itertools
import pathlib
import re
import sys
import threading
from collections import deque
from ctypes import c_char_p, c_void_p, py_object
from typing import Any

import llvmlite.binding as llvm

from .object_file import OFFERED, NotWhole

LIBC = frozenset("malloc realloc free abort memcpy memset memmove memcmp bzero __chkstk".split())
# LLVM calls bzero for zeros on macOS, and __chkstk for a large frame of the stack on Windows.
LIBM = frozenset(
    "acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp10 exp2 "
    "expm1 fabs floor fma fmax fmin fmod frexp hypot ldexp lgamma llrint log log10 log1p log2 "
    "nearbyint pow rint round sin sincos sinh sqrt tan tanh tgamma trunc".split()
)
PYTHON = frozenset(  # LAPACK's errors; `self` of a builtin
    "PyGILState_Ensure PyGILState_Release Py_FatalError PyLong_AsVoidPtr".split()
)
PREFIX = "numba_"
OF_SCIPY = "scipy_special_"

_lock = threading.Lock()
PIECES = 32  # most pieces of code of a linker, whose data grow faster than their number
_numbers = itertools.count()  # numbers of libraries, including libraries that did not link
_released: deque = deque()  # (linker, name) of libraries that nobody holds


class _Linker:
    """A linker of LLVM, and the trackers of its libraries that somebody holds, by name.

    Code reaches its data within 2 GB only (4 GB on ARM).  JITLink puts code and data side by side.
    RuntimeDyld, LLVM's older linker, puts code and data anywhere, and ends the process if their
    distance is too long: in a process with large arrays, where the gaps between them are small.
    """

    def __init__(self):
        initialise()
        self.llvms = llvm.create_lljit_compiler(use_jit_link=True)
        self.left = PIECES
        self.trackers: dict = {}


class _Linkers:
    def __init__(self):
        self.newest: Any = None
        self.used: set = set()  # linkers with libraries: a linker ends after its libraries


_linkers = _Linkers()


class Library:
    """Object code in this process, which stays there as long as this object does."""

    __slots__ = ("_held", "address")

    def __init__(self, address, linker, name):
        self.address = address
        self._held = (linker, name)

    def __del__(self, released=_released):
        released.append(self._held)  # `_unload` calls LLVM later: an object may end anywhere


class UnknownSymbol(Exception):
    """A symbol that none of our providers has."""


def provider(symbol):
    """The provider of a symbol, such as "libc" or "numba"; "fastdyn" for OFFERED."""
    if symbol in OFFERED:
        return "fastdyn"
    if symbol in LIBC:
        return "libc"
    if symbol in PYTHON:
        return "python"
    if symbol.removesuffix("f") in LIBM or symbol in LIBM:
        return "libm"
    if symbol.startswith(OF_SCIPY):
        return "scipy"
    if symbol.startswith(PREFIX) and symbol.removeprefix(PREFIX) in _helpers():
        return "numba"
    raise UnknownSymbol(symbol)


@functools.cache
def _helpers():
    """Addresses of Numba's C helpers by name (BLAS, LAPACK, random numbers); imports no Numba."""
    if "numba" in sys.modules:
        from numba import _helperlib

        return _helperlib.c_helpers  # pyright: ignore
    spec = importlib.util.find_spec("numba")
    if spec is None or spec.origin is None:
        return {}
    for suffix in importlib.machinery.EXTENSION_SUFFIXES:
        file = pathlib.Path(spec.origin).parent / f"_helperlib{suffix}"
        if file.exists():
            found = importlib.util.spec_from_file_location("numba._helperlib", file)
            module = importlib.util.module_from_spec(found)  # pyright: ignore
            found.loader.exec_module(module)  # pyright: ignore
            return module.c_helpers
    return {}


def _of_scipy(name):
    """The address of a function of real numbers of `scipy.special`; None without one."""
    from scipy.special import cython_special

    capsules = vars(cython_special)["__pyx_capi__"]
    api = ctypes.pythonapi
    api.PyCapsule_GetName.restype = c_char_p
    api.PyCapsule_GetPointer.restype = c_void_p
    for variant in ("", "__pyx_fuse_0", "__pyx_fuse_1"):  # those of a type of numbers each
        capsule = py_object(capsules.get(variant + name))
        form = api.PyCapsule_GetName(capsule) if capsule.value else b""
        if re.fullmatch(rb"double \((double, )+int __pyx_skip_dispatch\)", form):
            return api.PyCapsule_GetPointer(capsule, c_char_p(form))
    return None


def _address(symbol):
    known = provider(symbol)
    if known == "numba":
        return _helpers()[symbol.removeprefix(PREFIX)]
    if known == "scipy":
        address = _of_scipy(symbol.removeprefix(OF_SCIPY))
    else:
        address = llvm.address_of_symbol(symbol)
    if not address:
        raise UnknownSymbol(symbol)
    return address


@functools.cache
def initialise():
    """Initialise LLVM for this machine."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


def _linker():
    """The linker of the next library."""
    if _linkers.newest is None or not _linkers.newest.left:
        _linkers.newest = _Linker()
    _linkers.newest.left -= 1
    return _linkers.newest


def _unload():
    """Remove the code of libraries that nobody holds, and close full linkers without libraries."""
    while _released:
        linker, name = _released.popleft()
        linker.trackers.pop(name).close()
        if not linker.trackers and not linker.left:
            _linkers.used.discard(linker)
            linker.llvms.close()


def unload():
    """Give back the memory of code that nobody holds; `load` begins with this step, too."""
    with _lock:
        _unload()


def load(code, symbol, needs):
    """The Library of object code, linked by itself, with the address of `symbol`.

    Blocks and kernels hold addresses as numbers: the code that stores an address also keeps the
    Library alive.  Raises UnknownSymbol, or NotWhole if the code cannot be linked.
    """
    own = {name: OFFERED[name]().address for name in needs if name in OFFERED}  # loads code, too
    with _lock:
        _unload()
        linker = _linker()  # first: a linker makes the symbols of the process known to LLVM
        builder = llvm.JITLibraryBuilder().add_object_img(code).export_symbol(symbol)
        for name in needs:
            builder.import_symbol(name, own.get(name) or _address(name))
        try:
            name = f"{symbol} {next(_numbers)}"
            tracker = linker.trackers[name] = builder.link(linker.llvms, name)
        except RuntimeError as error:  # raised for every failure in LLVM
            raise NotWhole(f"it cannot be linked: {error}") from None
        _linkers.used.add(linker)
        return Library(tracker[symbol], linker, name)
