"""What a function refers to outside itself: globals, closure variables, attributes of `self`.

Found in Numba's own reading of the bytecode, so that what is found is what is compiled.
"""

import builtins
import dis
import functools
import hashlib
import sys
import types as python
from typing import Any, NamedTuple

import numpy as np
from numba.core import ir
from numba.core.compiler import run_frontend
from numba.core.dispatcher import Dispatcher

from .parameters import Constant, kind

MISSING = object()
TUPLES = "__fastdyn_tuples__"  # on a function whose returned list may be a tuple where it is called


class Reference(NamedTuple):
    """A root, "global", "free" or "self", and attributes taken of it."""

    root: str
    name: str
    attributes: tuple = ()


class Opaque:
    """The token of a value that only this process can tell from others; it keeps the value."""

    def __init__(self, value):
        self.value = value

    def __eq__(self, other):
        return isinstance(other, Opaque) and self.value is other.value

    def __hash__(self):
        return id(self.value)


def track(blocks, n_definitions, owned):
    """Yield (block, position, statement, path) for each use of an outside name in Numba IR.

    `owned` says that the first argument is bound (`self`).  A path is a Reference; attributes
    taken of a path extend it, and every prefix is yielded too.
    """
    paths = {}
    for label in sorted(blocks):
        block = blocks[label]
        for i, statement in enumerate(block.body):
            if not isinstance(statement, ir.Assign):
                continue
            value, path = statement.value, None
            if isinstance(value, ir.Global):
                path = Reference("global", value.name)
            elif isinstance(value, ir.FreeVar):
                path = Reference("free", value.name)
            elif isinstance(value, ir.Arg) and owned and value.index == 0:
                path = Reference("self", value.name)
            elif isinstance(value, ir.Var):
                path = paths.get(value.name)
            elif isinstance(value, ir.Expr) and value.op == "getattr":
                before = paths.get(value.value.name)
                if before is not None:
                    path = before._replace(attributes=(*before.attributes, value.attr))
            if path is not None and n_definitions[statement.target.name] == 1:
                paths[statement.target.name] = path
                yield block, i, statement, path


def count_definitions(blocks):
    """How often each variable is assigned."""
    counts = {}
    for block in blocks.values():
        for statement in block.find_insts(ir.Assign):
            counts[statement.target.name] = counts.get(statement.target.name, 0) + 1
    return counts


def _references(code, owned):
    cells = tuple(python.CellType(None) for _ in code.co_freevars)
    names = {name: None for name in _names(code) if not hasattr(builtins, name)}
    function = python.FunctionType(code, names, code.co_name, None, cells)
    blocks = run_frontend(function).blocks
    counts = count_definitions(blocks)
    found = {path for *_, path in track(blocks, counts, owned)}
    inner = [c for c in code.co_consts if isinstance(c, python.CodeType)]
    for nested in inner:
        found |= {r for r in _references(nested, False) if r.root == "global"}
    longest = {
        r
        for r in found
        if not any(
            o.root == r.root
            and o.name == r.name
            and len(o.attributes) > len(r.attributes)
            and o.attributes[: len(r.attributes)] == r.attributes
            for o in found
        )
    }
    return tuple(sorted(longest))


def _names(code):
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, python.CodeType):
            yield from _names(constant)


_known: dict = {}


def references(function, owned):
    """The outside names that a Python function uses, as long paths.

    Raises what Numba raises on bytecode that it cannot read.
    """
    code = function.__code__
    known = _known.get((id(code), owned))  # hashing the code itself would take a microsecond
    if known is None:
        if len(_known) > 4096:
            _known.clear()
        known = _known[id(code), owned] = (_references(code, owned), code)
    return known[0]


def walks_into(value):
    """Whether attributes of a value are looked up here, because Numba could not."""
    if isinstance(value, python.ModuleType | type):
        return True
    plain = (str, bytes, int, float, complex, tuple, list, np.ndarray, np.generic, type(None))
    return not isinstance(value, plain) and not callable(value)


def resolve(reference, function, owner):
    """The value that a path leads to now, and the number of attributes that were followed."""
    if reference.root == "self":
        value = owner
    elif reference.root == "global":
        value = function.__globals__.get(reference.name, MISSING)
        if value is MISSING:
            value = getattr(builtins, reference.name, MISSING)
    else:
        index = function.__code__.co_freevars.index(reference.name)
        try:
            value = function.__closure__[index].cell_contents
        except ValueError:
            value = MISSING
    depth = 0
    for attribute in reference.attributes:
        if not (walks_into(value) or (reference.root == "self" and depth == 0)):
            break
        value = getattr(value, attribute, MISSING)
        depth += 1
    return value, depth


def frozen(value: Any, seen=()) -> Any:
    """A hashable token that tells a constant from every other one; Opaque if there is none."""
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
    if isinstance(value, Dispatcher):
        options = tuple(sorted((k, repr(v)) for k, v in value.targetoptions.items()))
        typed = () if value._can_compile else tuple(map(str, value.nopython_signatures))  # pyright: ignore
        return ("njit", options, typed, frozen(value.py_func, seen))
    if isinstance(value, python.FunctionType):
        return _frozen_function(value, seen)
    if isinstance(value, python.MethodType) and not isinstance(value.__self__, type):
        return ("method", _frozen_function(value.__func__, seen, value.__self__))
    if callable(value):
        name: Any = getattr(value, "__qualname__", None) or getattr(value, "__name__", None)
        for module in (getattr(value, "__module__", None), "numpy", "scipy.special"):
            if name and module and is_named(value, module, name):
                return ("builtin", module, name)
    return Opaque(value)


KERNELS = f"{__name__.partition('.')[0]}.kernels."
LIBRARIES = {"numpy", "math", "cmath", "builtins", "operator", "numba", "_operator", "scipy"}


def is_named(value, module, name):
    """Whether this very object is what a library calls by this name (others may claim it)."""
    if module.split(".")[0] not in LIBRARIES and not module.startswith(KERNELS):
        return False
    found = sys.modules.get(module)
    for part in name.split("."):
        found = getattr(found, part, None)
    return found is value or (isinstance(found, Dispatcher) and found.py_func is value)


def of_library(function):
    """Whether Numba, or a kernel, knows a Python function by itself."""
    return is_named(function, function.__module__ or "", function.__qualname__)


def draws_random(value):
    """Whether a value is a generator of random numbers, or one of its methods."""
    owner = getattr(value, "__self__", None) or value
    kind = owner if isinstance(owner, type | python.ModuleType) else type(owner)
    name = kind.__name__ if isinstance(kind, python.ModuleType) else kind.__module__
    return name == "random" or name.startswith("numpy.random")


STORES = ("STORE_GLOBAL", "DELETE_GLOBAL", "STORE_DEREF", "DELETE_DEREF")


def stored_outside(code):
    """A global or enclosing variable that a function assigns to, or None."""
    todo, free = [code], set(code.co_freevars)
    while todo:
        one = todo.pop()
        for instruction in dis.get_instructions(one):
            if instruction.opname in STORES:
                if instruction.opname.endswith("GLOBAL") or instruction.argval in free:
                    return instruction.argval
        todo += [c for c in one.co_consts if isinstance(c, python.CodeType)]
    return None


def _frozen_function(function, seen, owner=None):
    if of_library(function):
        return ("library", function.__module__, function.__qualname__)
    if function in seen:
        return ("recursion", seen.index(function))
    seen = (*seen, function)
    try:
        outside = references(function, owner is not None)
    except Exception:  # Numba says why when it is asked to compile
        return Opaque(function)
    values = tuple((r, frozen(resolve(r, function, owner)[0], seen)) for r in outside)
    return ("function", code_token(function.__code__), frozen(function.__defaults__), values)


@functools.lru_cache(4096)
def code_token(code):
    """Everything of a code object that machine code depends on."""
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
    """Whether a token has a part that only this process can identify."""
    if isinstance(token, Opaque):
        return True
    if isinstance(token, Constant):
        return contains_opaque(token.token)
    return isinstance(token, tuple) and any(contains_opaque(t) for t in token)


def calls_itself(token):
    """Whether a token has a function that refers to itself."""
    if isinstance(token, Constant):
        return calls_itself(token.token)
    if not isinstance(token, tuple):
        return False
    if len(token) == 2 and token[0] == "recursion" and isinstance(token[1], int):
        return True
    return any(calls_itself(t) for t in token)


def outside_kind(value):
    """The kind of an outside value: floats, arrays and lists are parameters, else constant."""
    if isinstance(value, float | complex | np.ndarray | np.floating | np.complexfloating | list):
        return kind(value, frozen)
    return Constant(frozen(value), value)
