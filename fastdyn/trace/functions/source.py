"""Functions of libraries that are written in Python, over the stand-ins of what they call."""

import builtins
import types
from typing import Any

from .python import BUILTINS

# All of NumPy's.  SciPy's often hand arrays to C code, keep caches, or look at types.
REBUILT = "numpy.", "scipy._lib.", "scipy.integrate._quadrature.", "scipy.signal._waveforms."


class _Module:
    """A module in rebuilt source."""

    def __init__(self, sources, module):
        self._sources = sources
        self._module = module

    def __getattr__(self, name):
        value = self._sources.inside(getattr(self._module, name))
        setattr(self, name, value)
        return value


class _Globals(dict):
    """The globals of the rebuilt functions of a module; a name is looked up when it is used."""

    def __init__(self, sources, outer):
        super().__init__(__builtins__={**vars(builtins), **BUILTINS}, __name__=outer["__name__"])
        self._sources = sources
        self._outer = outer

    def __missing__(self, name):
        self[name] = self._sources.inside(self._outer[name])
        return self[name]


class Sources:
    """Rebuilt functions; ``stand_in(value)`` is the stand-in of a value, or None."""

    def __init__(self, stand_in):
        self._stand_in = stand_in
        self._made = {}

    def inside(self, value) -> Any:
        """The value of a module as rebuilt source gets it: a stand-in, or a rebuilt function."""
        found = self._stand_in(value)
        if found is not None:
            return found
        return _Module(self, value) if isinstance(value, types.ModuleType) else self.of(value)

    def of(self, value) -> Any:
        """A function of a library that is written in Python, rebuilt, or the value unchanged."""
        f = getattr(value, "_implementation", value)
        if type(f) is not types.FunctionType or not f"{f.__module__}.".startswith(REBUILT):
            return value
        if f not in self._made:
            own = f.__globals__["__name__"]  # `__module__` names where NumPy offers the function
            names = self._made.setdefault(own, _Globals(self, f.__globals__))
            new = types.FunctionType(f.__code__, names, f.__name__, f.__defaults__, f.__closure__)
            new.__kwdefaults__ = f.__kwdefaults__
            self._made[f] = new
        return self._made[f]
