"""Coefficients as data: rows of exact fractions that the compiler knows."""

from fractions import Fraction

from numba import types
from numba.core.imputils import lower_constant
from numba.extending import models, register_model, typeof_impl


class Row:
    """A row of a Butcher tableau: exact fractions, known to the compiler.

    Parameters
    ----------
    text : str
        Fractions or decimals as printed in the source, separated by blanks: ``"3/40 9/40"``.
    """

    def __init__(self, text=""):
        self.exact = tuple(Fraction(word) for word in text.split())
        self.floats = tuple(float(a) for a in self.exact)

    def __len__(self):
        return len(self.exact)

    def __sub__(self, other):
        difference = Row()
        difference.exact = tuple(a - b for a, b in zip(self.exact, other.exact, strict=True))
        difference.floats = tuple(float(a) for a in difference.exact)
        return difference


class RowType(types.Type):
    """The type of one Row.  The numbers are part of the type: no memory, no zero multiplied."""

    def __init__(self, exact):
        self.exact = exact
        super().__init__(name=f"Row({', '.join(map(str, exact))})")


register_model(RowType)(models.OpaqueModel)


@typeof_impl.register(Row)
def _typeof_row(value, context):
    return RowType(value.exact)


@lower_constant(RowType)
def _constant_row(context, builder, ty, value):
    return context.get_dummy_value()
