"""How a kernel stores values of vectors: known to the compiler, without memory of its own."""

from numba import types

from ..vector.number import Vector
from .constant import Constant


class Form(Constant):
    """How values are stored: tuples of n vectors, `value` their type."""

    def __init__(self, n, width, exact=False):
        self.value = types.UniTuple(Vector(width, exact), n)

    def __repr__(self):
        return f"Form({self.value})"
