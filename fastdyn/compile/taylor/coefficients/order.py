"""The data of one order: its number, reciprocals, and the registers of its sums."""

from fractions import Fraction

from ..text.instructions import ONE

LANES = 16  # more than a vector reads behind the last order


def rest(k):
    """The rounding error of 1 / k.

    It has the same sign in all steps, so that the errors add up.
    """
    return float(Fraction(1, k) - Fraction(1.0 / k))


class Tables:
    """Constants by order: k, 1 / k and its rounding error."""

    def __init__(self, text, last):
        numbers = range(last + 2 + LANES)
        self.numbers = text.table("numbers", [float(k) for k in numbers])
        self.inverses = text.table("inverses", [1.0 / max(k, 1) for k in numbers])
        self.rests = text.table("rests", [rest(max(k, 1)) for k in numbers])


class Order:
    """One order: its number as an LLVM value, its reciprocals, the registers of its sums.

    `first` is true for order 1.  `grows` is true if the coefficients of the order take a new lane.
    An `exact` order has the error of 1 / (k + 1): it is visible if the truncation error is below
    rounding.
    """

    def __init__(self, text, k, here, grows, width, tables, exact):
        self.k = k
        self.here = here
        self.grows = grows
        self.first = k == 1
        self.text = text
        self.numbers = tables.numbers
        self.inverses = tables.inverses
        self._rests = tables.rests
        self.exact = exact and grows
        self._known = {}
        self.number, self.inverse = (
            text.load(text.at(t, k)) for t in (self.numbers, self.inverses)
        )
        if self.first:
            self.number = self.inverse = ONE
            return
        if grows:
            lanes = text.constant(range((here - 1) * width + 1, here * width + 1))
            self.mask = text.of(width).compare("oeq", text.splat(self.number, width), lanes)

    def next(self, value, pace):
        """pace value / (k + 1)"""
        text = self.text
        if pace not in self._known:
            following = text.new(f"add i64 {self.k}, 1")
            inverse, rest = (text.load(text.at(t, following)) for t in (self.inverses, self._rests))
            self._known[pace] = (inverse, rest) if self.exact else (text.mul(pace, inverse), None)
        inverse, rest = self._known[pace]
        value = text.mul(pace, value) if self.exact else value
        return text.fma(value, inverse, text.mul(value, rest))
