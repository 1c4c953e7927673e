"""A complex number as two real ones."""

from typing import Any

import numpy as np

from ..graph.kinds import INT
from .real import Symbol, symbol
from .symbolic import Symbolic, graph_of, is_symbolic, refuse

NUMBER = bool | int | float | complex | np.bool_ | np.number


def is_complex(value):
    """Whether a value is a complex number, symbolic or not."""
    return isinstance(value, Pair | complex | np.complexfloating)


def parts(value) -> tuple[Any, Any]:
    """Real and imaginary part of a number."""
    if isinstance(value, Pair):
        return value.real, value.imag
    if isinstance(value, complex | np.complexfloating):
        return float(value.real), float(value.imag)
    return value, 0.0


def product(a, b) -> Any:
    """a b; exactly 0 if a factor is an exact zero."""
    for factor in (a, b):
        if not is_symbolic(factor) and factor == 0:
            return 0.0
    return a * b


class Pair(Symbolic):
    """real + i imag, where at least one part is a symbol."""

    __slots__ = ("imag", "real")

    def __init__(self, real, imag):
        self.real, self.imag = real, imag

    @property
    def g(self):
        return graph_of(self.real, self.imag)  # None for a product with zero

    def _parts(self, other) -> tuple[Any, Any] | None:
        return parts(other) if isinstance(other, NUMBER | Symbolic) else None

    def __add__(self, other):
        o = self._parts(other)
        return NotImplemented if o is None else Pair(self.real + o[0], self.imag + o[1])

    def __sub__(self, other):
        o = self._parts(other)
        return NotImplemented if o is None else Pair(self.real - o[0], self.imag - o[1])

    def __rsub__(self, other):
        return -self + other

    def __mul__(self, other):
        o = self._parts(other)
        if o is None:
            return NotImplemented
        (a, b), (c, d) = (self.real, self.imag), o
        real = total([product(a, c), -product(b, d)])
        return Pair(real, total([product(a, d), product(b, c)]))

    __radd__, __rmul__ = __add__, __mul__

    def __truediv__(self, other):
        o = self._parts(other)
        if o is None:
            return NotImplemented
        c, d = o
        if not is_symbolic(d) and d == 0:
            return Pair(self.real / c, self.imag / c)
        size = c * c + d * d
        top = self * Pair(c, -d)
        return Pair(top.real / size, top.imag / size)

    def __rtruediv__(self, other):
        o = self._parts(other)
        return NotImplemented if o is None else Pair(*o) / self

    def __neg__(self):
        return Pair(-self.real, -self.imag)

    def __pos__(self):
        return self

    def __pow__(self: Any, exponent) -> Any:
        return np.power(self, exponent)

    def __rpow__(self: Any, base) -> Any:
        return np.power(base, self)

    def __abs__(self):
        return np.hypot(self.real, self.imag)

    def __eq__(self, other):
        o = self._parts(other)
        return NotImplemented if o is None else (self.real == o[0]) & (self.imag == o[1])

    def __ne__(self, other):
        o = self._parts(other)
        return NotImplemented if o is None else (self.real != o[0]) | (self.imag != o[1])

    def conjugate(self):
        return Pair(self.real, -self.imag)

    conj = conjugate

    def astype(self, *_, **__):
        return self

    def _no(self, *_):
        refuse("a complex number is needed as a real one")

    __bool__ = __float__ = __int__ = __complex__ = __index__ = __hash__ = _no
    __lt__ = __le__ = __gt__ = __ge__ = _no


def total(values) -> Any:
    """The sum of numbers, some of them symbols."""
    values = list(values)
    if any(is_complex(v) for v in values):
        return Pair(*(total(part) for part in zip(*map(parts, values), strict=True)))
    g = graph_of(values)
    if g is None:
        return sum(values)
    values = [symbol(g, v) for v in values]
    node, kind = g.sum([v.node for v in values]), max(v.kind for v in values)
    if kind == INT:
        g.keep_exact(node)
    return Symbol(g, node, kind)
