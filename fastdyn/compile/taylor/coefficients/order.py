"""The data of one order: its number, reciprocals, and the registers of its sums."""

from ..text.instructions import ONE

LANES = 16  # more than a vector reads behind the last order


class Tables:
    """Constants by order: k, 1 / k and 1 / (k (k + 1))."""

    def __init__(self, text, last):
        numbers = range(last + 2 + LANES)
        self.numbers = text.table("numbers", [float(k) for k in numbers])
        self.inverses = text.table("inverses", [1.0 / max(k, 1) for k in numbers])
        self.twice = text.table("twice", [1.0 / max(k * k + k, 1) for k in numbers])


class Order:
    """One order: its number as an LLVM value, its reciprocals, the registers of its sums.

    `first` is true for order 1.  `grows` is true if the coefficients of the order take a new lane.
    In an `exact` order, numbers are divided by k + 1, not multiplied by a reciprocal.  The rounding
    error of the reciprocal has the same sign in all steps, so that the errors add up.  Their sum
    is visible if the truncation error is below rounding.
    """

    def __init__(self, text, k, here, grows, width, tables, exact):
        self.k, self.here, self.grows, self.first, self.text = k, here, grows, k == 1, text
        self.numbers, self.inverses, self._twice = tables.numbers, tables.inverses, tables.twice
        self.exact, self._known = exact and grows, {}
        self.number, self.inverse = (
            text.load(text.at(t, k)) for t in (self.numbers, self.inverses)
        )
        if self.first:
            self.number = self.inverse = ONE
            return
        if grows:
            lanes = text.constant(range((here - 1) * width + 1, here * width + 1))
            self.mask = text.of(width).compare("oeq", text.splat(self.number, width), lanes)

    def next(self, value, pace, ahead):
        """pace value / (k + 1) for ahead = 1, pace value / ((k + 1) (k + 2)) for ahead = 2."""
        text, k = self.text, self._later(1)
        if self.exact:
            below = text.load(text.at(self.numbers, k))
            if ahead == 2:
                below = text.mul(below, text.load(text.at(self.numbers, self._later(2))))
            return text.div(text.mul(pace, value), below)
        if (pace, ahead) not in self._known:
            table = self.inverses if ahead == 1 else self._twice
            self._known[pace, ahead] = text.mul(pace, text.load(text.at(table, k)))
        return text.mul(self._known[pace, ahead], value)

    def _later(self, ahead):
        return self.text.new(f"add i64 {self.k}, {ahead}")
