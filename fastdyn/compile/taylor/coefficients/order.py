"""The data of one order: its number, reciprocals, and the registers of its sums."""

from ..text.instructions import ONE

LANES = 8  # lanes of the vectors that compute the tables


class Tables:
    """Numbers by order: k, 1 / k, and scale / k and scale^2 / (k (k + 1)) of the current step."""

    def __init__(self, text, scale, last):
        self.text, count = text, -(-(last + 2) // LANES) * LANES
        self.numbers = text.table("numbers", [float(k) for k in range(count + LANES)])
        inverses = [1.0 / max(k, 1) for k in range(count + LANES)]
        both = [1.0 / max(k * k + k, 1) for k in range(count)]
        self.inverses = text.table("inverses", inverses)
        self.paced = self._times(self.inverses, scale, count)
        scales = text.mul(scale, scale)
        self.paced_twice = self._times(text.table("twice", both), scales, count)

    def _times(self, table, factor, count):
        """A copy of a table, multiplied."""
        wide = self.text.of(LANES)
        room, factor = self.text.slot("double", count), wide.splat(factor, LANES)
        for first in range(0, count, LANES):
            value = wide.load(wide.at(table, first))
            wide.store(wide.mul(value, factor), wide.at(room, first))
        return room


class Order:
    """One order: its number as an LLVM value, its reciprocals, the registers of its sums.

    `first` is true for order 1.  `grows` is true if the coefficients of the order take a new lane.
    In an `exact` order, numbers are divided by k + 1, not multiplied by a reciprocal.  The rounding
    error of the reciprocal has the same sign in all steps, so that the errors add up.  Their sum
    is visible if the truncation error is below rounding.
    """

    def __init__(self, text, k, here, grows, width, tables, exact):
        self.k, self.here, self.grows, self.first = k, here, grows, k == 1
        self.text, self.width, self.last_lane = text, width, (here - 1) * width
        self.numbers, self.inverses = tables.numbers, tables.inverses
        self.exact, self._tables, self._known = exact and grows, tables, {}
        self.number, self.inverse = (
            text.load(text.at(t, k)) for t in (self.numbers, self.inverses)
        )
        if self.first:
            self.number = self.inverse = ONE
            return
        if grows:
            kind = f"<{width} x i64>"
            one = text.new(f"insertelement {kind} poison, i64 {k}, i64 0")
            zeros = f"<{width} x i32> zeroinitializer"
            all_k = text.new(f"shufflevector {kind} {one}, {kind} poison, {zeros}")
            lanes = ", ".join(f"i64 {self.last_lane + j + 1}" for j in range(width))
            self.mask = text.new(f"icmp eq {kind} {all_k}, <{lanes}>")

    def next(self, value, factor, pace, ahead):
        """scale f value / (k + 1) for ahead = 1, scale^2 f value / ((k + 1) (k + 2)) for 2.

        `factor` is f; `pace` is f times the power of the scale.
        """
        text, k = self.text, self._later(1)
        if self.exact:
            below = text.load(text.at(self.numbers, k))
            if ahead == 2:
                below = text.mul(below, text.load(text.at(self.numbers, self._later(2))))
            return text.div(text.mul(pace, value), below)
        if (factor, ahead) not in self._known:
            table = self._tables.paced if ahead == 1 else self._tables.paced_twice
            self._known[factor, ahead] = text.mul(factor, text.load(text.at(table, k)))
        return text.mul(self._known[factor, ahead], value)

    def _later(self, ahead):
        return self.text.new(f"add i64 {self.k}, {ahead}")
