"""Coefficients as data: rows of exact fractions that the compiler knows."""

from fractions import Fraction
from itertools import zip_longest
from typing import NamedTuple

from ..state.constant import Constant


class Row(Constant):
    """A row of a Butcher tableau: exact fractions, known to the compiler.

    Parameters
    ----------
    text : str
        Fractions or decimals as printed in the source, separated by blanks: ``"3/40 9/40"``.
    to_the_end : bool
        Whether compiled code multiplies by a zero in the last place, too.  A last stage that is not
        finite then makes the sum NaN.
    """

    def __init__(self, text="", to_the_end=False):
        self.to_the_end = to_the_end
        self.exact = tuple(Fraction(word) for word in text.split())
        self.floats = tuple(float(a) for a in self.exact)

    @classmethod
    def of(cls, exact, to_the_end=False):
        """A Row of the fractions `exact`."""
        return cls(" ".join(map(str, exact)), to_the_end)

    def __repr__(self):
        return f"Row({', '.join(map(str, self.exact))})" + " to the end" * self.to_the_end

    def __len__(self):
        return len(self.exact)

    def __sub__(self, other):
        """The difference; zeros extend the shorter row."""
        both = zip_longest(self.exact, other.exact, fillvalue=0)
        return Row.of(a - b for a, b in both)


def rows(text):
    """The rows of a text that separates rows by semicolons."""
    return tuple(map(Row, text.split(";")))


def tableau(text):
    """(times, rows) of the stages from a Butcher tableau, ``"3/10: 3/40 9/40; 4/5: ..."``."""
    times, stages = zip(*(line.split(":") for line in text.split(";")), strict=True)
    return Row(" ".join(times)), tuple(map(Row, stages))


class Table(NamedTuple):
    """The tables of an explicit method of s stages.

    Parameters
    ----------
    stages : tuple (Row, tuple of Row)
        Times and rows of the stages from the second on; see `tableau`.
    b : Row
        Weights of the s stages.
    errors : tuple of Row
        Weights of the error estimates; s + 1 numbers, the last for the derivative at the end.
    d : tuple of Row
        Weights of all stages in the rows of the interpolant beyond the Hermite polynomial.
    extra : tuple (Row, tuple of Row)
        Times and rows of the stages of the interpolant.
    """

    stages: tuple
    b: Row
    errors: tuple = ()
    d: tuple = ()
    extra: tuple = (Row(), ())
