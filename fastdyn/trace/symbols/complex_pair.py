"""A complex number as a pair of real numbers."""

from typing import Any

import numpy as np

from ..graph.kinds import INT
from .operators import operators
from .real import Symbol, symbol
from .symbolic import Lazy, Symbolic, graph_of, is_symbolic, refuse

NUMBER = bool | int | float | complex | np.bool_ | np.number


def is_complex(value):
    """Whether a value is a complex number, symbolic or not."""
    return isinstance(value, Pair | complex | np.complexfloating)


def any_complex(value):
    """Whether a value is, or contains, complex numbers."""
    if isinstance(value, list | tuple):
        return any(map(any_complex, value))
    if isinstance(value, Lazy) or not isinstance(value, np.ndarray):
        return is_complex(value)
    if value.dtype == object:
        return any(map(is_complex, value.view(np.ndarray).flat))
    return value.dtype.kind == "c"


def parts(value) -> tuple[Any, Any]:
    """Real and imaginary part of a number."""
    if isinstance(value, Pair):
        return value.real, value.imag
    if isinstance(value, complex | np.complexfloating):
        return float(value.real), float(value.imag)
    return value, 0.0


def product(a, b) -> Any:
    """a times b; the plain number 0.0 if a factor is a plain zero."""
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
        return graph_of(self.real, self.imag)  # None if no part is a symbol

    def lift(self, other):
        """Convert `other` to a Pair; None if `other` is no number."""
        return Pair(*parts(other)) if isinstance(other, NUMBER | Symbolic) else None

    def _add(self, o):
        return Pair(self.real + o.real, self.imag + o.imag)

    def _sub(self, o):
        return Pair(self.real - o.real, self.imag - o.imag)

    def _mul(self, o):
        real = total([product(self.real, o.real), -product(self.imag, o.imag)])
        return Pair(real, total([product(self.real, o.imag), product(self.imag, o.real)]))

    def _truediv(self, o):
        if not is_symbolic(o.imag) and o.imag == 0:
            return Pair(self.real / o.real, self.imag / o.real)
        size = o.real * o.real + o.imag * o.imag
        top = self._mul(o.conjugate())
        return Pair(top.real / size, top.imag / size)

    __add__ = __radd__ = operators(_add)[0]
    __sub__, __rsub__ = operators(_sub)
    __mul__ = __rmul__ = operators(_mul)[0]
    __truediv__, __rtruediv__ = operators(_truediv)
    __eq__ = operators(lambda a, b: (a.real == b.real) & (a.imag == b.imag))[0]
    __ne__ = operators(lambda a, b: (a.real != b.real) | (a.imag != b.imag))[0]

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
