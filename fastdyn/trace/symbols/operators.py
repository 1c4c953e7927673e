"""Makers of the operators of symbols, and of the methods of arrays."""

from typing import Any

import numpy as np


def operators(method, of_python=None) -> tuple[Any, Any]:
    """The operator, and the reflected operator, that a method of two numbers of a graph gives.

    The class of the method has `lift`, which converts the other operand, or returns None.  The
    operator `of_python` computes with known whole numbers, and with a Pair and a complex operand,
    which `lift` does not convert.
    """

    def direct(self, other):
        if of_python is not None and (whole := self.whole_numbers(other)):
            return of_python(*whole)
        o = self.lift(other)
        if o is not None:
            return method(self, o)
        if of_python is None or not isinstance(other, complex):
            return NotImplemented
        return of_python(self.g.pair(self, 0.0), other)

    def reflected(self, other):
        if of_python is not None and (whole := self.whole_numbers(other)):
            return of_python(*whole[::-1])
        o = self.lift(other)
        if o is not None:
            return method(o, self)
        if of_python is None or not isinstance(other, complex):
            return NotImplemented
        return of_python(other, self.g.pair(self, 0.0))

    return direct, reflected


def by_function(name):
    """The method of an array that calls the function of NumPy with this name."""

    def method(self, *args, **kwargs):
        return getattr(np, name)(self, *args, **kwargs)

    return method
