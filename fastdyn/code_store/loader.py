"""Object code into this process: each file its own name space, its needs from a closed list."""

import functools
import importlib.machinery
import importlib.util
import itertools
import pathlib
import sys
import threading

import llvmlite.binding as llvm

from .object_file import NotWhole

LIBC = frozenset("malloc realloc free abort memcpy memset memmove memcmp".split())
LIBM = frozenset(
    "acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp10 exp2 "
    "expm1 fabs floor fma fmax fmin fmod frexp hypot ldexp lgamma llrint log log10 log1p log2 "
    "nearbyint pow rint round sin sincos sinh sqrt tan tanh tgamma trunc".split()
)
PYTHON = frozenset("PyGILState_Ensure PyGILState_Release Py_FatalError".split())  # of LAPACK's end
PREFIX = "numba_"

_lock = threading.Lock()
PIECES = 32  # of code that a linker has
_loaded: list = []
_linkers: list = []
_numbers = itertools.count()  # of the libraries, those that did not link included


class UnknownSymbol(Exception):
    """A symbol that no provider of ours has."""


def provider(symbol):
    """Who has a symbol that object code needs: "libc", "libm", "python" or "numba"."""
    if symbol in LIBC:
        return "libc"
    if symbol in PYTHON:
        return "python"
    if symbol.removesuffix("f") in LIBM or symbol in LIBM:
        return "libm"
    if symbol.startswith(PREFIX) and symbol.removeprefix(PREFIX) in _helpers():
        return "numba"
    raise UnknownSymbol(symbol)


@functools.cache
def _helpers():
    """Addresses of Numba's C helpers by name (BLAS, LAPACK, random numbers), without Numba."""
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


def _address(symbol):
    if provider(symbol) == "numba":
        return _helpers()[symbol.removeprefix(PREFIX)]
    address = llvm.address_of_symbol(symbol)
    if not address:
        raise UnknownSymbol(symbol)
    return address


@functools.cache
def initialise():
    """Let LLVM know this machine."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()


def _linker():
    """The linker of the next library; each has a few, as what one keeps grows faster than they."""
    initialise()
    if len(_loaded) % PIECES == 0:
        _linkers.append(llvm.create_lljit_compiler())
    return _linkers[-1]


def load(code, symbol, needs):
    """The address of `symbol` in object code, linked by itself; it is never taken out again.

    Blocks and kernels hold addresses as numbers, which would keep nothing in place.  Raises
    UnknownSymbol, or NotWhole for what cannot be linked.
    """
    with _lock:
        linker = _linker()  # first: it makes the symbols of the process known to LLVM
        builder = llvm.JITLibraryBuilder().add_object_img(code).export_symbol(symbol)
        for name in needs:
            builder.import_symbol(name, _address(name))
        try:
            library = builder.link(linker, f"{symbol} {next(_numbers)}")
            _loaded.append(library)
            return library[symbol]
        except RuntimeError as error:  # all that LLVM says
            raise NotWhole(f"it cannot be linked: {error}") from None
