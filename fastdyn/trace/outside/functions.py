"""Rebuilds functions over wrapped values: their globals are read when they are first used."""

import builtins
import contextlib
import dis
import functools
import sys
import types
from typing import Any, NamedTuple

from ..functions.python import BUILTINS, impure, vectorized
from ..functions.stand_ins import IMPURE, PURE, root_of
from ..symbols.symbol import Symbol, refuse

ORIGINAL = dict(vars(builtins))
# Attributes with the names of functions and classes: names may change, and few functions ask.
NAMES = "__name__", "__qualname__", "__module__", "__doc__"
# Instructions that look into the dict of globals itself, past `Scope.__missing__`.
PAST = frozenset(("LOAD_NAME", "LOAD_FROM_DICT_OR_GLOBALS", "STORE_GLOBAL", "DELETE_GLOBAL"))


class Scope(dict):
    """The globals of rebuilt functions; a name is wrapped when it is first read."""

    def __init__(self, outside, outer, by_name):
        super().__init__(__builtins__=by_name, __name__=outer.get("__name__"))
        self._outside, self._outer, self.seen = outside, outer, dict(self)

    def __missing__(self, name):
        reads = self._outside.reads
        outer = self._outer
        row = reads.step(reads.known(outer), "item", name)
        if name not in outer:
            reads.expect(row, "absent")
            outer = vars(builtins)
            row = reads.step(reads.known(vars(builtins)), "item", name)
            if name not in outer:  # an undefined name must stay undefined
                reads.expect(row, "absent")
            if outer.get(name) is ORIGINAL.get(name):
                reads.part(row, ORIGINAL.get(name))
                raise KeyError(name)
        self[name] = self.seen[name] = self._outside.wrap(outer[name], row)
        return self[name]


class RebuiltFunctions:
    """The rebuilt functions of one run, and the variables that they share."""

    def __init__(self, outside):
        self.outside = outside
        self._builtins = {**ORIGINAL, **BUILTINS, "__import__": self._import}
        self._scopes = {}
        self._cells = {}

    def copy(self, f, row=None):
        """Rebuild a function over its wrapped globals, closure, defaults and attributes."""
        outside = self.outside
        reads = self.outside.reads
        facts = _facts(f.__code__)
        if facts.subclasses:
            refuse("it asks which classes inherit from one", alive=True)
        reads.expect(row, "code", (f.__code__, f.__globals__))
        if root_of(f) in IMPURE:
            return impure(f"{f.__module__}.{f.__name__}")
        if root_of(f) in PURE:
            return f
        scope = self._scopes.get(id(f.__globals__))
        if scope is None:
            scope = Scope(outside, f.__globals__, self._builtins)
            self._scopes[id(f.__globals__)] = scope
            outside.watched.append(("a global variable", scope, scope.seen))
        cells = [self._cell(c) for c in f.__closure__ or ()]
        new = types.FunctionType(f.__code__, scope, f.__name__, None, tuple(cells) or None)
        new.__doc__ = f.__doc__
        new.__module__ = f.__module__
        new.__qualname__ = f.__qualname__
        outside.keep(f, new, row)
        for name in ("__defaults__", "__kwdefaults__", "__dict__"):
            self._optional(f, new, name, reads.step(row, "attribute", name))
        outside.watch("what makes a function", new)
        for name in facts.past:
            with contextlib.suppress(KeyError):
                scope[name]
        reads.names |= facts.names
        reads.identities |= facts.identities
        reads.truths |= facts.truths
        for i, (cell, old) in enumerate(zip(cells, f.__closure__ or (), strict=True)):
            self._fill(cell, old, reads.step(row, "cell", i))
        return new

    def _optional(self, f, new, name, row):
        """Copy defaults or attributes; later calls check that there are none, if there are none."""
        outside = self.outside
        value = getattr(f, name)
        if not value:
            outside.reads.expect(row, "nothing")
        elif name == "__dict__":
            outside.reads.expect(row, "keys", (dict, list(value)))
            for each in [each for each in value if each[0] != "_"]:
                vars(new)[each] = outside.part(value, row, "item", each)
        else:
            setattr(new, name, outside.wrap(value, row))

    def _import(self, name, *how):
        module = __import__(name, *how)
        package = name.partition(".")[0]
        full = module.__name__
        if package in PURE and full.partition(".")[0] == package:
            return self.outside.wrap(module, self.outside.reads.known(module))
        reads = self.outside.reads
        known = sys.modules.get(full) is module
        row = reads.step(reads.known(sys.modules), "item", full) if known else None
        return self.outside.wrap(module, row)

    def _cell(self, old):
        if id(old) not in self._cells:
            self._cells[id(old)] = types.CellType(), old, []
        return self._cells[id(old)][0]

    def _fill(self, new, old, row):
        outside = self.outside
        filled = self._cells[id(old)][2]
        if filled:
            if filled[0] is not None:
                outside.reads.alias(row, filled[0])
            return
        filled.append(row)
        try:
            content = old.cell_contents
        except ValueError:  # the variable is not assigned yet
            outside.reads.expect(row, "absent")
            return
        new.cell_contents = outside.wrap(content, row)
        outside.watch("a variable of an outer function", new)

    def _remembered(self, cached, row):
        """The stand-in of a function with `lru_cache`; refuses arguments that are not known."""
        reads = self.outside.reads

        def of_known(*args, **named):
            given = tuple(map(_plain, args)), tuple((k, _plain(v)) for k, v in named.items())
            before = cached.cache_info()
            found = cached(*given[0], **dict(given[1]))
            held = cached.cache_info().misses == before.misses
            if not before.currsize:  # else the cache would keep the value of this trace
                cached.cache_clear()
            return self.outside.wrap(found, reads.step(row if held else None, "remembered", given))

        return of_known

    def wrapper(self, value, row):
        """A method, a partial, or what a wrapper of a function wraps; None for any other value."""
        kind = type(value)
        outside = self.outside
        reads = self.outside.reads
        # hasattr would call `__getattr__`, which may accept any name
        for name in ("py_func", "pyfunc", "__wrapped__"):
            static = name in getattr(value, "__dict__", ()) or name in vars(kind)
            wraps = name != "__wrapped__" or kind is functools._lru_cache_wrapper
            if static and wraps:
                reads.expect(row, "type", kind)
                if name == "__wrapped__":
                    return outside.keep(value, self._remembered(value, row), row)
                if name == "pyfunc":
                    reads.expect(reads.step(row, "attribute", "otypes"), "equal", None)
                    if value.otypes is not None or value.excluded or value.signature:
                        refuse("np.vectorize with options")
                with outside.numbers_fixed(name == "py_func"):  # as in Numba's code
                    inner = outside.part(value, row, "attribute", name)
                new = vectorized(inner) if name == "pyfunc" else inner
                return outside.keep(value, new, row)
        if kind is types.MethodType:
            reads.expect(row, "type", kind)
            function = outside.part(value, row, "attribute", "__func__")
            return types.MethodType(function, outside.part(value, row, "attribute", "__self__"))
        if kind is functools.partial:
            reads.expect(row, "type", kind)
            function, args, keywords = [
                outside.part(value, row, "attribute", name) for name in ("func", "args", "keywords")
            ]
            new = outside.keep(value, Partial(function, *args, **keywords), row)
            outside.watch("a keyword", new.keywords)
            return new
        return None


class Partial(functools.partial):
    """The copy of a partial, which refuses other contents."""

    __slots__ = ()

    def __setstate__(self, state):
        refuse("it changes a partial", effect=True)


def _plain(value):
    """Convert an argument of a cached function to a plain number or text."""
    if type(value) is Symbol and not value.many and not value.varies:
        return value.plain()
    if not isinstance(value, bool | int | float | str | None):
        refuse("it keeps what it gave")
    return value


class _Facts(NamedTuple):
    """The requests of a piece of code: see equal names in `Reads`, and `RebuiltFunctions.copy`."""

    identities: bool
    truths: bool
    subclasses: bool
    names: frozenset  # of the attributes NAMES
    past: tuple  # names that are looked up past a Scope


@functools.lru_cache(1024)
def _facts(code):
    identities = truths = False
    past: list = []
    before: Any = None
    for i in dis.get_instructions(code):
        if i.opname in PAST:
            past.append(i.argval)
        elif i.opname == "IS_OP":
            right = before.argval if before.opname == "LOAD_CONST" else code
            known = right is None or right is ... or isinstance(right, bool)
            identities |= not known
            truths |= any(isinstance(c, bool) for c in ([right] if known else code.co_consts))
        before = i
    texts = {*code.co_names, *[c for c in code.co_consts if isinstance(c, str)]}
    names = frozenset(texts.intersection(NAMES))
    found = [_Facts(identities, truths, "__subclasses__" in code.co_names, names, tuple(past))]
    found += [_facts(c) for c in code.co_consts if isinstance(c, types.CodeType)]
    identities, truths, subclasses = [any(f[i] for f in found) for i in range(3)]
    names = frozenset().union(*[f.names for f in found])
    past = [*dict.fromkeys(name for f in found for name in f.past)]
    return _Facts(identities, truths, subclasses, names, tuple(past))
