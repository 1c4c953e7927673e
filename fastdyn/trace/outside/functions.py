"""Rebuilds functions over copies of everything that they refer to."""

import builtins
import dis
import functools
import types

from ..graph.kinds import INT
from ..numpy.builtins import BUILTINS, impure, vectorized
from ..numpy.stand_ins import IMPURE, PURE, root_of
from ..reads.reads import STABLE
from ..symbols.real import Symbol
from ..symbols.symbolic import refuse
from .changes import facts
from .identities import compared_by_identity

GLOBAL = frozenset(
    "LOAD_GLOBAL LOAD_NAME LOAD_FROM_DICT_OR_GLOBALS STORE_GLOBAL DELETE_GLOBAL".split()
)


ORIGINAL = dict(vars(builtins))


class Functions:
    """The rebuilt functions of one run, and the variables that they share."""

    def __init__(self, outside):
        self.outside = outside
        self._scopes, self._cells = {}, {}

    def copy(self, f, row=None):
        """Rebuild a function over copies of its globals, closure, defaults and attributes."""
        outside, reads, step = self.outside, self.outside.reads, self.outside.reads.step
        made = outside.known(f)
        if made is not None:
            return made
        if _asks_who_inherits(f.__code__):
            refuse("it asks which classes inherit from one", alive=True)
        n_defaults = len(f.__defaults__ or ()), len(f.__kwdefaults__ or ())
        reads.expect(row, "code", (f.__code__, f.__globals__, *n_defaults))
        if root_of(f) in IMPURE:
            return impure(f"{f.__module__}.{f.__name__}")
        if root_of(f) in PURE:
            return f
        scope, seen = self._scope(f.__globals__)
        cells = tuple([self._cell(c) for c in f.__closure__ or ()])
        new = types.FunctionType(f.__code__, scope, f.__name__, None, cells or None)
        new.__doc__, new.__module__, new.__qualname__ = f.__doc__, f.__module__, f.__qualname__
        outside.keep(f, new)
        self._attributes(f, new, step(row, "inside", "__dict__"))
        if f.__defaults__ is not None:
            places = range(len(f.__defaults__))
            new.__defaults__ = tuple(outside.parts(f, row, "default", places).values())
        if f.__kwdefaults__ is not None:
            new.__kwdefaults__ = outside.parts(f, row, "keyword default", f.__kwdefaults__)
        outside.watched.append(("what makes a function", new, facts(new)))
        for name in _names(f.__code__):
            if name in f.__globals__ and name not in scope:
                scope[name] = seen[name] = outside.part(f, row, "global", name)
            elif name not in f.__globals__ and name not in scope:
                reads.expect(step(row, "global", name), "absent")
                self._builtin(name, scope["__builtins__"], step(row, "builtin", name))
        compared = compared_by_identity(f.__code__)
        reads.identities |= f.__code__ in compared
        reads.truths |= any(isinstance(each, bool) for each in compared)
        for i, (cell, old) in enumerate(zip(cells, f.__closure__ or (), strict=True)):
            self._fill(cell, old, step(row, "cell", i))
        return new

    def _builtin(self, name, scope, row):
        """Copy a builtin that the user added or replaced; an undefined name must stay undefined."""
        value = vars(builtins).get(name)
        if name in vars(builtins) and value is not ORIGINAL.get(name):
            scope[name] = self.outside.copy(value, row)
        elif name not in ORIGINAL:
            self.outside.reads.expect(row, "absent")

    def _attributes(self, f, new, row):
        outside = self.outside
        outside.reads.expect(row, "keys", (dict, list(vars(f))))
        names = [name for name in vars(f) if name[0] != "_"]
        found = outside.parts(vars(f), row, "item", names)
        vars(new).update(found)
        outside.watched.append(("an attribute of a function", new, found))

    def _scope(self, outer):
        if id(outer) not in self._scopes:
            names = {
                "__builtins__": {
                    **vars(builtins),
                    **BUILTINS,
                    "__import__": self._import,
                },
                "__name__": outer.get("__name__"),
            }
            self._scopes[id(outer)] = names, dict(names)
            self.outside.watched.append(("a global variable", *self._scopes[id(outer)]))
        return self._scopes[id(outer)]

    def _import(self, name, *how):
        module = __import__(name, *how)
        package = name.partition(".")[0]
        known = STABLE if package in PURE and module.__name__.partition(".")[0] == package else None
        return self.outside.copy(module, known)

    def _cell(self, old):
        if id(old) not in self._cells:
            self._cells[id(old)] = (types.CellType(), old, [])
        return self._cells[id(old)][0]

    def _fill(self, new, old, row):
        *_, filled = self._cells[id(old)]
        if filled:
            if filled[0] is not None:
                self.outside.reads.alias(row, filled[0])
            return
        filled.append(row)
        try:
            content = old.cell_contents
        except ValueError:  # the variable is not assigned yet
            self.outside.reads.expect(row, "absent")
            return
        new.cell_contents = self.outside.copy(content, row)
        self.outside.watched.append(("a variable of an outer function", new, new.cell_contents))

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
            return self.outside.copy(found, reads.step(row if held else None, "remembered", given))

        return of_known

    def wrapper(self, value, row):
        """A copy of a method, a partial, or a wrapper of a function; None for any other value."""
        kind, outside, reads = type(value), self.outside, self.outside.reads
        # hasattr would call `__getattr__`, which may accept any name
        for name in ("py_func", "pyfunc", "__wrapped__"):
            static = name in getattr(value, "__dict__", ()) or name in vars(kind)
            wraps = name != "__wrapped__" or kind is functools._lru_cache_wrapper
            if static and wraps and not isinstance(value, type):
                reads.expect(row, "type", kind)
                if name == "__wrapped__":
                    return outside.keep(value, self._remembered(value, row))
                if name == "pyfunc":
                    reads.expect(reads.step(row, "inside", "otypes"), "equal", None)
                    if value.otypes is not None or value.excluded or value.signature:
                        refuse("np.vectorize with options")
                with outside.numbers_fixed(name == "py_func"):  # as in Numba's code
                    inner = outside.part(value, row, "inside", name)
                return outside.keep(value, vectorized(inner) if name == "pyfunc" else inner)
        if isinstance(value, types.MethodType):
            reads.expect(row, "type", kind)
            function = outside.part(value, row, "function")
            return types.MethodType(function, outside.part(value, row, "self"))
        if isinstance(value, functools.partial):
            reads.expect(row, "type", kind)
            reads.expect(reads.step(row, "inside", "args"), "length", (tuple, len(value.args)))
            keys = (dict, list(value.keywords))
            reads.expect(reads.step(row, "inside", "keywords"), "keys", keys)
            function = outside.part(value, row, "inside", "func")
            args = outside.parts(value, row, "argument", range(len(value.args)))
            keywords = outside.parts(value, row, "keyword", value.keywords)
            copy = functools.partial(function, *args.values(), **keywords)
            outside.keep(value, copy)
            outside.watched.append(("a keyword", copy.keywords, dict(copy.keywords)))
            return copy
        return None


def _plain(value):
    """Convert an argument of a cached function to a plain number or text."""
    if isinstance(value, Symbol) and not value.node.varies:
        return int(value) if value.kind == INT else float(value)
    if not isinstance(value, bool | int | float | str | None):
        refuse("it keeps what it gave")
    return value


@functools.lru_cache(1024)
def _asks_who_inherits(code):
    inner = [c for c in code.co_consts if isinstance(c, types.CodeType)]
    return "__subclasses__" in code.co_names or any(map(_asks_who_inherits, inner))


@functools.lru_cache(1024)
def _names(code):
    """The names of globals in the code of a function and of nested functions."""
    found = [i.argval for i in dis.get_instructions(code) if i.opname in GLOBAL]
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            found += _names(constant)
    return list(dict.fromkeys(found))
