"""What the coefficients of one order need to know of it."""

from .text import ONE, hexadecimal


class Order:
    """What an order is: its number as a value, its reciprocals, the registers of its sums.

    `first` is the order 1; `grows` tells whether its coefficients take a new lane.  `next` and
    `after` are 1 / (k + 1) and 1 / (k + 1)(k + 2), or where it is `exact` what to divide by: the
    rounding of a reciprocal has the same sign in each step, and adds up.
    """

    def __init__(self, text, k, here, grows, width, tables):
        self.k, self.here, self.grows, self.first = k, here, grows, k == 1
        self.text, self.width, self.last_lane = text, width, (here - 1) * width
        if self.first:
            self.number, self.inverse, self.exact = ONE, ONE, True
            self.next, self.after = hexadecimal(2.0), hexadecimal(6.0)
            return
        numbers, self.inverses = tables
        later = text.new(f"add i64 {k}, 1")
        latest = text.new(f"add i64 {k}, 2")
        self.number = text.load(text.at(numbers, k))
        self.inverse = text.load(text.at(self.inverses, k))
        self.exact = grows and here == 1
        table = numbers if self.exact else self.inverses
        self.next, after = (text.load(text.at(table, i)) for i in (later, latest))
        self.after = text.mul(self.next, after)
        if grows:
            kind = f"<{width} x i64>"
            one = text.new(f"insertelement {kind} poison, i64 {k}, i64 0")
            zeros = f"<{width} x i32> zeroinitializer"
            all_k = text.new(f"shufflevector {kind} {one}, {kind} poison, {zeros}")
            lanes = ", ".join(f"i64 {self.last_lane + j + 1}" for j in range(width))
            self.mask = text.new(f"icmp eq {kind} {all_k}, <{lanes}>")
