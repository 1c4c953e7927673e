"""The data of one order: its number, reciprocals, and the registers of its sums."""

from ..text.instructions import ONE


class Order:
    """One order: its number as an LLVM value, its reciprocals, the registers of its sums.

    `first` is true for order 1.  `grows` is true if the coefficients of the order take a new lane.
    `next` and `after` are 1 / (k + 1) and 1 / ((k + 1)(k + 2)), or the divisors if the order is
    `exact`.  In low orders, the rounding error of a reciprocal has one sign in all steps and adds
    up; the sum is visible if the truncation error is below rounding.
    """

    def __init__(self, text, k, here, grows, width, tables, exact):
        self.k, self.here, self.grows, self.first = k, here, grows, k == 1
        self.text, self.width, self.last_lane = text, width, (here - 1) * width
        self.numbers, self.inverses = tables
        self.exact, self._known = exact and grows, {}
        later, latest = (text.new(f"add i64 {k}, {ahead}") for ahead in (1, 2))
        self.number, self.inverse = (text.load(text.at(table, k)) for table in tables)
        table = self.numbers if self.exact else self.inverses
        self.next, after = (text.load(text.at(table, i)) for i in (later, latest))
        self.after = text.mul(self.next, after)
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

    def memo(self, emit, a, b):
        """``emit(a, b)``, emitted once in this order."""
        if (a, b) not in self._known:
            self._known[a, b] = emit(a, b)
        return self._known[a, b]
