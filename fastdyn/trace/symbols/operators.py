"""Makers of the operators of symbols, and of the methods of arrays."""

from typing import Any

import numpy as np


def operators(method, beside_complex=None) -> tuple[Any, Any]:
    """The operator, and the reflected operator, that a method of two numbers of a graph gives.

    The class of the method has `lift`, which converts the other operand, or returns None.  If
    `lift` does not convert a complex operand, ``beside_complex(a, b)`` gets the operand and a Pair.
    """

    def direct(self, other):
        o = self.lift(other)
        if o is not None:
            return method(self, o)
        if beside_complex is None or not isinstance(other, complex):
            return NotImplemented
        return beside_complex(self.g.pair(self, 0.0), other)

    def reflected(self, other):
        o = self.lift(other)
        if o is not None:
            return method(o, self)
        if beside_complex is None or not isinstance(other, complex):
            return NotImplemented
        return beside_complex(other, self.g.pair(self, 0.0))

    return direct, reflected


def by_function(name):
    """The method of an array that calls the function of NumPy with this name."""

    def method(self, *args, **kwargs):
        return getattr(np, name)(self, *args, **kwargs)

    return method
