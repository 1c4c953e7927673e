"""Truth values that depend on symbols, and selections by such truth values."""

from typing import Any

import numpy as np

from ..graph.kinds import INT
from .complex_pair import Pair, is_complex, parts
from .real import Symbol, symbol
from .symbolic import Symbolic, kind_of, refuse


class Condition(Symbolic):
    """A truth value of Python or NumPy; ``bool(condition)`` chooses a path."""

    __slots__ = ("g", "node", "python")

    def __init__(self, g, node, python=False):
        self.g, self.node, self.python = g, node, python
        g.conditions = True

    def __bool__(self):
        return self.g.decide(self.node)

    def _truth(self, other):
        if isinstance(other, Symbol) or type(other) is int:
            refuse("bits of a whole number")
        if isinstance(other, bool | np.bool_):
            return self.g.const(bool(other))
        return other.node if isinstance(other, Condition) else None

    def _truth_of_numpy(self, other):
        """Whether `other` is a truth value, too, and NumPy's rules hold for the two."""
        python = self.python and getattr(other, "python", isinstance(other, bool))
        return isinstance(other, Condition | bool | np.bool_) and not python

    def _beside(self, other):
        """The truth value as a number, for arithmetic with `other`."""
        if self._truth_of_numpy(other):
            refuse("arithmetic of two truth values")  # True + True is 2 in Python, True in NumPy
        return self.number()

    def __add__(self, other):
        return self._beside(other) + other

    def __sub__(self, other):
        return self._beside(other) - other

    def __rsub__(self, other):
        return other - self._beside(other)

    def __mul__(self, other):
        return self & other if self._truth_of_numpy(other) else self.number() * other

    __radd__, __rmul__ = __add__, __mul__

    def _combine(self, other, op):
        node = self._truth(other)
        if node is None:
            return NotImplemented
        python = self.python and (isinstance(other, bool) or getattr(other, "python", False))
        return self.g.condition(self.g.both(self.node, node, op), python)

    def __and__(self, other):
        return self._combine(other, "and")

    def __or__(self, other):
        return self._combine(other, "or")

    def __xor__(self, other):
        node = self._truth(other)
        if node is None:
            return NotImplemented
        other = Condition(self.g, node)
        return (self & other.negation()) | (self.negation() & other)

    __rand__, __ror__, __rxor__ = __and__, __or__, __xor__

    def __invert__(self) -> Any:
        return -1 - self.number() if self.python else self.negation()

    def as_numpy(self):
        """The truth value under NumPy's rules."""
        return Condition(self.g, self.node)

    def negation(self):
        """The opposite truth value."""
        return self.g.condition(self.g.negation(self.node), self.python)

    def __neg__(self) -> Any:
        return -self.number() if self.python else np.negative(np.True_)  # raises TypeError

    def choose(self, a, b):
        """a if the condition is true, else b."""
        return select(self, a, b)

    def number(self):
        return Symbol(self.g, self.g.select(self.node, self.g.const(1.0), self.g.const(0.0)), INT)

    def astype(self, dtype, *_, **__):
        return self.as_type(dtype)

    def as_type(self, dtype):
        """The truth value as a number of a type."""
        kind = kind_of(dtype)
        if kind in "iuf":
            return self.number()
        return self if kind in "bcO" else refuse(f"a conversion to {dtype}")

    def all(self, *_, **__):
        return self

    any = all

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.number(), name)

    def __hash__(self):
        return hash(bool(self))  # equal to the hash of True or False


def _of_number(name):
    def method(self, *args):
        return getattr(self.number(), name)(*args)

    return method


for _name in (
    "truediv rtruediv pos pow rpow abs lt le gt ge eq ne float int index mod floordiv round"
).split():
    setattr(Condition, f"__{_name}__", _of_number(f"__{_name}__"))


def negated(value):
    """The negation of a truth value, symbolic or not."""
    return value.negation() if isinstance(value, Condition) else not value


def select(condition, a, b):
    """a if the condition holds, else b."""
    if isinstance(condition, Symbol):
        condition = condition != 0
    if not isinstance(condition, Condition):
        return a if condition else b
    g = condition.g
    truths = (bool, np.bool_, Condition)
    if isinstance(a, truths) and isinstance(b, truths):
        return (condition & a) | (condition.negation() & b)
    if is_complex(a) or is_complex(b):
        return Pair(*(select(condition, p, q) for p, q in zip(parts(a), parts(b), strict=True)))
    a, b = symbol(g, a), symbol(g, b)
    kind = max(a.kind, b.kind)
    return Symbol(g, g.select(condition.node, a.node, b.node), kind)


def both(a, b):
    """The conjunction of a and b: truth values, numbers, Conditions or Symbols."""
    a, b = (v != 0 if isinstance(v, Symbol) else v for v in (a, b))
    if isinstance(a, Condition):
        return a & b
    return b if a else False


def either(a, b):
    """The disjunction of a and b: truth values, numbers, Conditions or Symbols."""
    a, b = (v != 0 if isinstance(v, Symbol) else v for v in (a, b))
    if isinstance(a, Condition):
        return a | b
    return True if a else b


def kind_of_number(value):
    """NumPy's kind letter of a number: "b", "i", "f" or "c"."""
    if isinstance(value, Symbol):
        return "i" if value.kind == INT else "f"
    if isinstance(value, Condition | bool | np.bool_):
        return "b"
    if is_complex(value):
        return "c"
    return "i" if isinstance(value, int | np.integer) else "f"


def cast(value, dtype):
    """Convert a number, symbolic or not, to a whole number, a truth value or a float."""
    if isinstance(value, Symbol | Condition):
        return value.as_type(dtype)
    kind = kind_of(dtype)
    if kind in "iu":
        return int(value)
    if kind == "b":
        return value != 0
    if kind == "f":
        return value.real if is_complex(value) else value
    return value if kind in "cO" else refuse(f"a conversion to {dtype}")
