"""The numbers of a traced function."""

from typing import Any

import numpy as np

from ...operations import NAMES
from ...operations.domains import LARGEST
from ..graph.kinds import INT, NUMPY
from .arithmetic import Arithmetic
from .symbolic import graph_of, kind_of, refuse

MAX_INDEX = 8  # a symbol as a plain index gets paths for 0, ..., MAX_INDEX - 1 and -1


class Symbol(Arithmetic):
    """A real number that acts as a plain number, and as a NumPy array without axes."""

    __slots__ = ()

    # -- as a plain number: if parameters determine the value, the code assumes the value

    def _plain(self, *_):
        if self.node.varies:
            refuse("a value that depends on t or y is needed as a plain number")
        self.g.assume(self.node)
        return int(self.node.value) if self.kind == INT else self.node.value

    def __hash__(self):
        return hash(self._plain())

    def __index__(self):
        if self.kind != INT:
            raise TypeError("'float' object cannot be interpreted as an integer")
        if not self.node.varies:
            return self._plain()
        for value in (*range(MAX_INDEX), -1):  # one path for each value
            if self == value:
                return value
        return self.g.abandon("a whole number that depends on t or y is needed as a plain one")

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        if hasattr((0, 0.0, np.float64(0.0))[self.kind], name):
            refuse(f"`{name}` of what depends on the state")
        raise AttributeError(f"'float' object has no attribute '{name}'")

    def __float__(self):
        return float(self._plain())

    def __int__(self):
        return int(self._plain())

    def __complex__(self):
        return complex(self._plain())

    def __format__(self, spec):
        return self.g.as_text() if self.node.varies else format(self._plain(), spec)

    def __repr__(self):
        return self.g.as_text() if self.node.varies else repr(self._plain())

    def is_integer(self):
        return (self == self.to_whole("floor")) & self.finite()

    def __iter__(self):
        raise TypeError("'float' object is not iterable")

    # -- as NumPy's numbers

    def as_type(self, dtype) -> Any:
        kind = kind_of(dtype)
        if kind in "iu":
            return self.__trunc__()
        if kind == "b":
            return self != 0
        return self if kind in "fcO" else refuse(f"a conversion to {dtype}")

    def finite(self):
        return abs(self) <= LARGEST

    def nan(self):
        return self != self

    def conjugate(self):
        return self

    conj = conjugate
    real = property(lambda self: self)
    imag = property(lambda self: 0.0)

    def __getitem__(self: Any, key) -> Any:
        if self.kind != NUMPY:
            raise TypeError("'float' object is not subscriptable")
        return np.reshape(self, ())[key]


def as_python(value):
    """A value under Python's rules."""
    return value.as_python() if isinstance(value, Symbol) else value


def _of_numpy(function):
    """An attribute of NumPy's numbers that Python's numbers lack."""

    def attribute(number):
        if number.kind != NUMPY:
            raise AttributeError  # Python then calls `Symbol.__getattr__`, whose message is better
        return function(number)

    return property(attribute)


def _itself(number):
    return lambda *_, **__: number


OF_NUMPY: dict[str, Any] = {
    "shape": lambda _: (), "ndim": lambda _: 0, "size": lambda _: 1, "T": lambda number: number,
    "dtype": lambda _: np.dtype(float),
    "astype": lambda number: lambda dtype, *_, **__: number.as_type(dtype),
    "dot": lambda number: lambda other: number * other,
    "round": lambda number: lambda decimals=0, out=None: np.round(number, decimals, out),
    "clip": lambda number: lambda lowest=None, highest=None, **_: np.clip(number, lowest, highest),
    "reshape": lambda number: lambda *shape: np.reshape(
        number, shape[0] if len(shape) == 1 else shape
    ),
    "item": lambda number: lambda *_: number.as_python(),
    **dict.fromkeys("squeeze copy flatten ravel sum max min mean prod".split(), _itself),
}  # fmt: skip
for _name, _function in OF_NUMPY.items():
    setattr(Symbol, _name, _of_numpy(_function))


def symbol(g, value):
    """Convert a value to a Symbol; refuse a value that is no real number."""
    found = Symbol(g, g.true).lift(value)
    if found is None:
        refuse(f"a {type(value).__name__} where a real number is needed")
    return found


def by_name(name):
    """The function of symbols with a name in Python; None if the graph has no such operation."""
    if name not in NAMES:
        return None

    def function(*values):
        g = graph_of(values)
        first, *others = (symbol(g, v) for v in values)
        return first.call(NAMES[name], *others)

    return function
