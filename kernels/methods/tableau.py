"""Coefficients as data: rows of exact fractions that the compiler knows."""

import sys
from dataclasses import dataclass
from fractions import Fraction
from itertools import zip_longest

from ..state.constant import Constant

LONGEST = 25  # letters of a coefficient that is shown as printed, and not as a float
EXACT = 6  # the digits up to which a decimal, such as 0.25, is no rounded number


def _fraction(word):
    try:
        return Fraction(word)
    except (ValueError, ZeroDivisionError):
        raise ValueError(
            f"{word!r} is no coefficient: write fractions or decimals, such as 3/40 or .075"
        ) from None


def _digits(word):
    """The number of significant digits of a decimal."""
    return len(word.lower().partition("e")[0].replace(".", "").lstrip("+-0"))


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
        words = text.split()
        self.to_the_end = to_the_end
        self.exact = tuple(map(_fraction, words))
        self.floats = tuple(float(a) for a in self.exact)
        both = zip(words, self.floats, strict=True)
        self.shown = tuple(word if len(word) <= LONGEST else repr(x) for word, x in both)
        self.digits = max((_digits(word) for word in words if "." in word), default=0)

    @classmethod
    def of(cls, exact, to_the_end=False):
        """A Row of the fractions `exact`."""
        return cls(" ".join(map(str, exact)), to_the_end)

    def __repr__(self):
        return f"Row({', '.join(map(str, self.exact))})" + " to the end" * self.to_the_end

    def __str__(self):
        return " ".join(self.shown)

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
    lines = [line.split(":") for line in text.split(";")]
    for i, line in enumerate(lines, 2):
        if len(line) != 2 or len(line[0].split()) != 1:
            raise ValueError(
                f"stage {i} of a tableau is {':'.join(line).strip()!r}: write its time, a colon "
                "and its coefficients, 3/10: 3/40 9/40, and a semicolon between two stages"
            )
    times, stages = zip(*lines, strict=True)
    return Row(" ".join(times)), tuple(map(Row, stages))


@dataclass(frozen=True)
class Table:
    """The tables of an explicit method of s stages, checked when it is made.

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

    Raises
    ------
    ValueError
        If a row is too short or too long, or has a wrong sum.
    """

    stages: tuple
    b: Row
    errors: tuple = ()
    d: tuple = ()
    extra: tuple = (Row(), ())

    def __post_init__(self):
        for name in "errors", "d":
            if isinstance(getattr(self, name), Row):
                raise TypeError(
                    f"{name} is a tuple of Rows, got one Row: write ({name[0].upper()},)"
                )
        times, stages = self.stages
        later, extra = self.extra
        s = len(stages) + 1
        each = "one for each stage"
        self._check("b", self.b, s, each, 1)
        for first, c, rows in (2, times, stages), (s + 2, later, extra):
            for i, (row, time, word) in enumerate(zip(rows, c.exact, c.shown, strict=True), first):
                self._check(f"stage {i}", row, i - 1, f"{each} before it", time, f"its time {word}")
        each += " and the derivative at the end"
        for i, row in enumerate(self.errors, 1):
            self._check(f"row {i} of errors", row, s + 1, each, 0)
        each += " and each stage of the interpolant" * bool(extra)
        for i, row in enumerate(self.d, 1):
            self._check(f"row {i} of d", row, s + 1 + len(extra), each, 0)

    def _check(self, what, row, n, each, total, meaning=""):
        if not isinstance(row, Row):
            raise TypeError(f"{what} is a Row, got {row!r}")
        if len(row) != n:
            raise ValueError(f"{what} has {len(row)} coefficients instead of {n}, {each}: {row}")
        found = sum(row.exact)
        sizes = sum(map(abs, row.exact))
        if not sizes:
            raise ValueError(f"{what} has no coefficient but zeros")
        if abs(found - total) > self.accuracy * (sizes + abs(total)):
            expected = meaning or total
            raise ValueError(f"{what} has the sum {float(found):.16g} instead of {expected}: {row}")

    @property
    def accuracy(self):
        """The relative error of a coefficient: of rounding to the digits printed, or to a float."""
        rows = (
            self.b,
            *self.errors,
            *self.d,
            *(r for c, a in (self.stages, self.extra) for r in (c, *a)),
        )
        digits = max(row.digits for row in rows)
        rounding = 8 * sys.float_info.epsilon
        return max(10.0 ** (1 - digits), rounding) if digits > EXACT else rounding
