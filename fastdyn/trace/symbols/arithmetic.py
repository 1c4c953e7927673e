"""Arithmetic, functions and comparisons of real numbers that are nodes of a graph."""

import operator
from fractions import Fraction
from typing import Any, Self

import numpy as np

from ...operations import OPERATIONS
from ...operations.value import Value
from ..graph.domains import INDEX, WHOLE, bound, divided_by_zero
from ..graph.kinds import FLOAT, INT, NUMPY
from .division import floor_division, not_caught, to_decimals
from .operators import operators
from .powers import note_power
from .symbolic import Symbolic, refuse


def _comparison(sign) -> Any:
    return lambda self, other: self._compare(other, sign)


class Arithmetic(Symbolic):
    """A real number: a node of the graph, and the rules (`kinds`) of its arithmetic.

    `Paths.condition` makes a comparison a Condition; `Paths.pair` makes a complex result a Pair.
    """

    __slots__ = ("g", "kind", "node")

    def __init__(self, g, node, kind=NUMPY):
        self.g, self.node, self.kind = g, node, kind

    def _of(self, node, *others):
        kind = max([self.kind, *[o.kind for o in others]])
        if kind == INT:
            self.g.keep_exact(node)
            node = self.g.add(node, self.g.const(0.0)) if node.op in ("neg", "mul") else node
        return self.made(node, kind)

    def number(self):
        return self

    def made(self, node, kind) -> Self:
        """Another number of this graph."""
        return type(self)(self.g, node, kind)

    def lift(self, other) -> Self | None:
        """Convert `other` to a number of this graph; None if `other` is no real number."""
        if isinstance(other, Symbolic):
            found = other.number()
            of_numpy = self.kind == FLOAT and getattr(other, "python", True) is False
            return found.as_numpy() if of_numpy else found  # a float and a truth value of NumPy
        if isinstance(other, np.ndarray) and other.ndim == 0:
            return self.lift(other.item())
        if isinstance(other, bool | int | float | Fraction | np.bool_ | np.integer | np.floating):
            kind = NUMPY if isinstance(other, np.generic) else INT
            kind = FLOAT if type(other) in (float, Fraction) else kind
            try:
                value = float(other)
            except OverflowError:
                refuse("a whole number beyond the range of floats")
            if kind != FLOAT and self.kind == INT and abs(value) > WHOLE and value != other:
                refuse("a whole number beyond 2**53")
            return self.made(self.g.const(value), kind)
        return None

    def whole_numbers(self: Any, other) -> Any:
        """This number and `other`, if both are whole, and known; then the code assumes both."""
        if self.kind != INT or self.node.varies:
            return None
        if isinstance(other, type(self)):
            other = other._plain() if other.kind == INT and not other.node.varies else None
        return (self._plain(), other) if isinstance(other, int | np.integer) else None

    # -- arithmetic with a number of the same graph

    def _add(self, o):
        return self._of(self.g.add(self.node, o.node), o)

    def _sub(self, o):
        return self._of(self.g.sub(self.node, o.node), o)

    def _mul(self, o):
        return self._of(self.g.mul(self.node, o.node), o)

    def _truediv(self, o):
        kind = max(self.kind, o.kind, FLOAT)
        if kind == FLOAT:
            not_caught(self, o)
            zero = self.g.compare(o.node, self.g.const(0.0), "eq")
            self.g.raises_if(zero, divided_by_zero)
        return self.made(self.g.div(self.node, o.node), kind)

    def _divmod(self, o):
        g = self.g
        kind = max(self.kind, o.kind)
        if kind < NUMPY:
            not_caught(self, o)
            g.raises_if(g.compare(o.node, g.const(0.0), "eq"), divided_by_zero)
        whole, rest = floor_division(self, o)
        if kind == INT:
            g.bounds[whole.key], g.bounds[rest.key] = bound(g, self.node), bound(g, o.node)
        return self.made(whole, kind), self.made(rest, kind)

    def _pow(self, o):
        g, value = self.g, o.node.value
        whole = self.kind == o.kind == INT
        kind = max(self.kind, o.kind, INT if not o.node.varies and value >= 0 else FLOAT)
        if whole and self.node.varies and not o.node.varies and value < 0:
            refuse("a negative power of a whole number")  # NumPy raises, Python gives a float
        if whole and o.node.varies:
            g.leaves_to_python_if(g.compare(o.node, g.const(0.0), "lt"))
            kind = INT
        if not o.node.varies and 2 * value == np.rint(2 * value):  # constant exponent
            g.assume(o.node)
            result = g.power(self.node, value)
        else:
            result = g.call("pow", self.node, o.node)
        if kind != NUMPY:
            note_power(self, o, result, kind)
        return self.made(result, kind)

    __add__ = __radd__ = operators(_add, operator.add)[0]
    __sub__, __rsub__ = operators(_sub, operator.sub)
    _times = operators(_mul, operator.mul)[0]
    __truediv__, __rtruediv__ = operators(_truediv, operator.truediv)
    __floordiv__, __rfloordiv__ = operators(lambda a, b: a._divmod(b)[0], operator.floordiv)
    __mod__, __rmod__ = operators(lambda a, b: a._divmod(b)[1], operator.mod)
    __divmod__, __rdivmod__ = operators(_divmod, divmod)
    __pow__, __rpow__ = operators(_pow, operator.pow)

    def __mul__(self: Any, other) -> Any:
        if isinstance(other, list | tuple | str):
            return operator.index(self) * other
        return self._times(other)

    __rmul__ = __mul__

    def __neg__(self):
        return self._of(self.g.neg(self.node))

    def __pos__(self):
        return self

    def __abs__(self):
        return self._of(self.g.make("abs", (self.node,)))

    def to_whole(self, how):
        return self.made(self.g.call(how, self.node), self.kind)

    # -- rounding to whole numbers

    def __round__(self, digits=None):
        if not digits:
            whole = self.to_whole("rint")
            return whole.as_int() if digits is None else whole
        return to_decimals(self, digits, python=self.kind != NUMPY)

    def __floor__(self):
        return self.to_whole("floor").as_int()

    def __ceil__(self):
        return self.to_whole("ceil").as_int()

    def __trunc__(self):
        return self.to_whole("trunc").as_int()

    def as_numpy(self):
        """The number under NumPy's rules, where nothing raises."""
        return self.made(self.node, NUMPY)

    def as_python(self):
        """The number under Python's rules, where a division by zero raises."""
        return self.made(self.node, min(self.kind, FLOAT))

    def as_int(self):
        g, size = self.g, self.g.make("abs", (self.node,))
        if g.in_handler():
            g.raises_if(g.compare(self.node, self.node, "ne"), lambda: int(np.nan))
            g.raises_if(g.compare(size, g.const(np.inf), "eq"), lambda: int(np.inf))
        if bound(g, self.node) > INDEX:
            g.leaves_to_python_if(g.negation(g.compare(size, g.const(float(INDEX)), "le")))
            g.bounds[self.node.key] = INDEX
        return self.made(g.add(self.node, g.const(0.0)), INT)  # an integer cannot be -0.0

    # -- functions

    def call(self, name, *others, python=False):
        """Call a function of `OPERATIONS`; if `python`, the function raises outside its domain."""
        g, operation, args = self.g, OPERATIONS[name], (self.node, *[o.node for o in others])
        node = g.call(name, *args)
        if python and operation.raises:
            given = [Value(g, a) for a in (node, *args)]
            for condition, raising in operation.raises(operation.in_math, *given):
                g.raises_if(condition.of, raising)
        return self.made(node, FLOAT if python else NUMPY)

    # -- comparisons

    def _compare(self, other, sign):
        whole = self.whole_numbers(other)
        if whole:
            return getattr(operator, sign)(*whole)
        o = self.lift(other)
        if o is None:
            return NotImplemented
        of_python = max(self.kind, o.kind) < NUMPY
        return self.g.condition(self.g.compare(self.node, o.node, sign), of_python)

    __lt__, __le__ = _comparison("lt"), _comparison("le")
    __gt__, __ge__ = _comparison("gt"), _comparison("ge")
    __eq__, __ne__ = _comparison("eq"), _comparison("ne")

    def __bool__(self):
        return bool(self != 0.0)
