"""The storage of values in vectors, as a constant that the compiler knows."""

from numba import types

from ..vector.number import Vector
from .constant import Constant


class Form(Constant):
    """The storage of a value as a tuple of n vectors; `value` is the type of the tuple."""

    def __init__(self, n, width, exact=False):
        self.value = types.UniTuple(Vector(width, exact), n)

    def __repr__(self):
        return f"Form({self.value})"
