"""Tokens that identify a value, or a function with everything that it uses."""

import hashlib
import sys
import types as python
from typing import Any, NamedTuple

import numpy as np

from . import memory
from .callables.captured import HEAP_TYPE, references, resolve
from .callables.jitted import is_jitted


class Opaque:
    """The token of a value that only this process can identify; the token keeps the value alive."""

    def __init__(self, value):
        self.value = value

    def __eq__(self, other):
        return isinstance(other, Opaque) and self.value is other.value

    def __hash__(self):
        return id(self.value)


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


def frozen(value: Any, seen=()) -> Any:
    """A hashable token; equal tokens mean equal constants.  Opaque if no other token exists."""
    if isinstance(value, bool | int | str | bytes | type(None) | type(Ellipsis)):
        return (type(value).__name__, value)
    if isinstance(value, float):
        return ("float", float(value).hex())
    if isinstance(value, complex):
        return ("complex", value.real.hex(), value.imag.hex())
    if isinstance(value, np.generic):
        return ("scalar", value.dtype.str, value.tobytes())
    if isinstance(value, tuple | list):
        fields = getattr(value, "_fields", None)  # of a named tuple
        return (type(value).__qualname__, fields, *(frozen(v, seen) for v in value))
    if isinstance(value, np.ndarray) and not value.dtype.hasobject:
        digest = hashlib.sha256(np.ascontiguousarray(value).tobytes()).hexdigest()
        return ("array", value.dtype.str, value.shape, value.flags.c_contiguous, digest)
    if isinstance(value, python.ModuleType):
        return ("module", value.__name__)
    if is_jitted(value):
        options = tuple(sorted((k, repr(v)) for k, v in value.targetoptions.items()))
        typed = () if value._can_compile else tuple(map(str, value.nopython_signatures))  # pyright: ignore
        return ("njit", options, typed, frozen(value.py_func, seen))
    if isinstance(value, python.FunctionType):
        return frozen_function(value, seen)
    if isinstance(value, python.MethodType) and not isinstance(value.__self__, type):
        return ("method", frozen_function(value.__func__, seen, value.__self__))
    kind: Any = type(value)
    if isinstance(value, type) or (callable(value) and not kind.__flags__ & HEAP_TYPE):
        name: Any = getattr(value, "__qualname__", None) or getattr(value, "__name__", None)
        for module in (getattr(value, "__module__", None), "numpy", "scipy.special"):
            if name and module and is_named(value, module, name):
                return ("builtin", module, name)
    return Opaque(value)


KERNELS = f"{__name__.partition('.')[0]}.kernels."


LIBRARIES = {"numpy", "math", "cmath", "builtins", "operator", "numba", "_operator", "scipy"}


def is_named(value, module, name):
    """Whether the name in the module, which a value claims for itself, refers to this value."""
    if module.split(".")[0] not in LIBRARIES and not module.startswith(KERNELS):
        return False
    found = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    return found is value or (is_jitted(found) and found.py_func is value)


def of_library(function):
    """Whether Numba or a kernel implements a Python function."""
    return is_named(function, function.__module__ or "", function.__qualname__)


def frozen_function(function, seen=(), owner=None):
    """The token of a function with the values that it uses; `owner` is the `self` of a method."""
    if of_library(function):
        return ("library", function.__module__, function.__qualname__)
    if function in seen:
        return ("recursion", seen.index(function))
    seen = (*seen, function)
    try:
        outside = references(function, owner is not None)
    except Exception:  # Numba gives the reason when it compiles
        return Opaque(function)
    values = tuple((r, frozen(resolve(r, function, owner)[0], seen)) for r in outside)
    defaults = (function.__defaults__, *sorted((function.__kwdefaults__ or {}).items()))
    return ("function", code_token(function.__code__), frozen(defaults), values)


@memory.cached
def code_token(code):
    """A digest of everything in a code object that machine code depends on."""
    parts = [code.co_code, code.co_exceptiontable, code.co_names, code.co_varnames]
    parts += [code.co_freevars, code.co_cellvars, code.co_flags]
    parts += [code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount]
    for constant in code.co_consts:
        nested = isinstance(constant, python.CodeType)
        parts.append(code_token(constant) if nested else frozen_constant(constant))
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def frozen_constant(constant):
    if isinstance(constant, frozenset):
        return sorted(repr(frozen(c)) for c in constant)
    return repr(frozen(constant))


def contains_opaque(token):
    """Whether a token has a part that is valid in this process only."""
    return any(isinstance(part, Opaque) for part in _parts(token))


def calls_itself(token):
    """Whether a token contains a function that refers to itself."""
    return any(
        isinstance(part, tuple)
        and len(part) == 2
        and part[0] == "recursion"
        and isinstance(part[1], int)
        for part in _parts(token)
    )


def _parts(token):
    """Yield a token and the tokens in it, at any depth."""
    if isinstance(token, Constant):
        token = token.token
    yield token
    if isinstance(token, tuple):
        for each in token:
            yield from _parts(each)
