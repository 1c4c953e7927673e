"""Tokens that identify a value, or a function with everything that it uses."""

import dis
import hashlib
import sys
import types as python
from typing import Any, NamedTuple

import numpy as np

from . import memory
from .callables import EMPTY, Uncompilable, is_jitted

ATOMS = {bool, int, str, bytes, type(None), type(Ellipsis)}
KERNELS = f"{__name__.partition('.')[0]}.kernels."
LIBRARIES = {"numpy", "math", "cmath", "builtins", "operator", "numba", "_operator", "scipy"}
STORES = ("STORE_GLOBAL", "DELETE_GLOBAL", "STORE_DEREF", "DELETE_DEREF")
LARGEST = 10**6  # bytes of an array in code; Numba puts only the address of a larger array there
HEAP_TYPE = 1 << 9  # the flag of classes written in Python


class Constant(NamedTuple):
    """A value that is part of the code; `token` identifies it."""

    token: Any
    value: Any

    def __eq__(self, other):
        return isinstance(other, Constant) and self.token == other.token

    def __hash__(self):
        return hash(self.token)

    def __repr__(self):
        return repr(self.token)


class Unknown(Exception):
    """A value that another process could not identify, by its type."""

    def __init__(self, value):
        kind = type(value).__name__
        super().__init__(
            f"of type {kind}, which compiled code cannot hold: pass its numbers as `args`"
        )


def frozen(value: Any, seen=()) -> Any:
    """A hashable token; equal tokens mean equal constants.  Raises Unknown if there is no token."""
    kind: Any = type(value)
    if kind in ATOMS:
        return (kind.__name__, value)
    if kind is float:
        return ("float", value.hex())
    if kind is complex:
        return ("complex", value.real.hex(), value.imag.hex())
    if kind is tuple:
        return ("tuple", *[frozen(v, seen) for v in value])
    if kind is np.ndarray and not value.dtype.hasobject:
        digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return ("array", value.dtype.str, value.shape, digest)
    if kind is python.ModuleType and value.__name__.split(".")[0] in LIBRARIES:
        return ("module", value.__name__)
    if isinstance(value, np.generic) and not value.dtype.hasobject:
        return ("scalar", value.dtype.str, value.tobytes())
    if is_jitted(value):
        options = tuple(sorted((k, repr(v)) for k, v in value.targetoptions.items()))
        typed = () if value._can_compile else tuple(map(str, value.nopython_signatures))  # pyright: ignore
        return ("njit", options, typed, frozen_function(value.py_func, seen))
    if kind is python.FunctionType:
        return frozen_function(value, seen)
    if isinstance(value, type) or (callable(value) and not kind.__flags__ & HEAP_TYPE):
        name: Any = getattr(value, "__qualname__", None) or getattr(value, "__name__", None)
        for module in (getattr(value, "__module__", None), "numpy", "scipy.special"):
            if name and module and _is_named(value, module, name):
                return ("builtin", module, name)
    raise Unknown(value)


def _is_named(value, module, name):
    """Whether the name in the module, which a value claims for itself, refers to this value."""
    if module.split(".")[0] not in LIBRARIES and not module.startswith(KERNELS):
        return False
    found = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    return found is value or (is_jitted(found) and found.py_func is value)


def of_library(function):
    """Whether Numba or a kernel implements a Python function."""
    return _is_named(function, function.__module__ or "", function.__qualname__)


def kernels_in(token):
    """The modules of kernels, from fastdyn on, that a token or a Constant names."""
    if isinstance(token, Constant):
        return kernels_in(token.token)
    if not isinstance(token, tuple):
        return set()
    named = len(token) == 3 and token[0] in ("library", "builtin") and str(token[1])
    if named and named.startswith(KERNELS):
        return {named.partition(".")[2]}
    return set().union(*map(kernels_in, token))


def frozen_function(function, seen=()):
    """The token of a function with the values that it uses.

    Raises Uncompilable, with the name of the value, if a value has no token; and for recursion,
    whose depth compiled code would not limit, and for effects that compiled code would lose.
    """
    if of_library(function):
        return ("library", function.__module__, function.__qualname__)
    if function in seen:
        raise Uncompilable("it calls itself, and compiled code would not stop at any depth")
    seen = (*seen, function)
    tokens = []
    defaults = [("a default", value) for value in function.__defaults__ or ()]
    for name, value in (*outside(function), *defaults):
        try:
            tokens.append((name, frozen(value, seen)))
        except Unknown as reason:
            raise Uncompilable(f"it uses `{name}`, {reason}") from None
    return ("function", code_token(function.__code__), *tokens)


def outside(function):
    """The (name, value) of each global, and of each closure variable, that a function reads."""
    code = function.__code__
    space = function.__globals__
    found = [(name, space[name]) for name in names_of(code) if name in space]
    cells = zip(code.co_freevars, function.__closure__ or (), strict=True)
    found += [(name, cell.cell_contents) for name, cell in cells if cell != EMPTY]
    for name, value in found:
        if isinstance(value, np.ndarray) and value.nbytes > LARGEST:
            size = f"an array of {value.nbytes} bytes, which are too many for code"
            raise Uncompilable(f"it uses `{name}`, {size}: pass it as `args`")
    return found


@memory.cached
def names_of(code):
    """The names of the globals that a code object and the code in it read."""
    found = set()
    for step in dis.get_instructions(code):
        if step.opname == "LOAD_GLOBAL":
            found.add(step.argval)
        elif step.opname in STORES and step.argval not in code.co_cellvars:
            raise Uncompilable(f"it assigns to `{step.argval}`, a variable outside itself")
        elif step.argval == "random":
            raise Uncompilable("it draws random numbers, which follow NumPy's seed in Python only")
    for constant in code.co_consts:
        if isinstance(constant, python.CodeType):
            found.update(names_of(constant))
    return tuple(sorted(found))


@memory.cached
def code_token(code):
    """A digest of everything in a code object that machine code depends on."""
    parts = [code.co_code, code.co_exceptiontable, code.co_names, code.co_varnames]
    parts += [code.co_freevars, code.co_cellvars, code.co_flags]
    parts += [code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount]
    for constant in code.co_consts:
        nested = isinstance(constant, python.CodeType)
        some = sorted(map(repr, constant)) if isinstance(constant, frozenset) else repr(constant)
        parts.append(code_token(constant) if nested else some)
    return hashlib.sha256(repr(parts).encode()).hexdigest()
