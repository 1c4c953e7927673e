"""The sums over earlier orders, sum(w(j) a[j] b[K-j]) over 0 < j < K, four orders K at once.

The orders K = k, ..., k + 3 are a block of orders.  Before the block, only a[j] and b[j] of orders
j < k are known.  A loop adds the terms common to all four orders, j = 4, ..., k - 1; so each
coefficient is loaded once for four products.  The other terms are added one by one, as their
coefficients become known.  A square needs only half of the products, j < K / 2: with k = 4 m + 1,
the loop is over j = 3, ..., 2 m.
"""

from typing import Any, NamedTuple

from ..recurrences.operations import Integral, Power, Quotient, Root, Sum
from ..text.instructions import ZERO, hexadecimal

BLOCK = 4


class Late(NamedTuple):
    """The order k + i of a block of orders that begins with order k."""

    i: int


class Convolution(NamedTuple):
    """The sum over earlier orders of w(j) a[j] b[K-j].

    The weight w(j) is (e + 1) j - K for a number e, j for JUST_J, 1 for None.  `factor` multiplies
    the sum, unless None.
    """

    key: Any
    a: Any
    b: Any
    weight: Any = None
    factor: Any = None

    @property
    def of_square(self):
        return self.a is self.b and self.weight is None

    @property
    def weighted(self):
        """True if the weight depends on K."""
        return self.weight is not None and self.weight != JUST_J

    @property
    def slope(self):
        """The factor of j in the weight."""
        return self.weight + 1.0 if self.weighted else 1.0


JUST_J = "j"


def convolutions(step, timed):
    """The convolutions of a step, with keys (key of the node, number); `timed` as in `Single`."""
    node = step.node
    if isinstance(step, Sum):
        parts = enumerate(step.products)
        return [Convolution((node.key, i), a, b, None, f) for i, (f, a, b) in parts]
    if isinstance(step, Quotient):
        return [Convolution((node.key, 0), step.b, node)]
    if isinstance(step, Power):
        return [Convolution((node.key, 0), step.a, node, step.exponent)]
    if isinstance(step, Root):
        return [Convolution((node.key, 0), node, node)]
    if isinstance(step, Integral) and node.key not in timed:
        parts = enumerate(step.parts)
        return [
            Convolution((node.key, i), a, g, JUST_J, f) for i, (f, a, g) in parts if g is not None
        ]
    return []


def n_partial(step, timed):
    """The number of vectors that a block of orders passes from `block` to `late`."""
    return BLOCK * max([c.key[1] + 1 for c in convolutions(step, timed)], default=0)


class Convolutions:
    """Emits sums for `rows.Rows`."""

    def __init__(self, rows):
        self.rows = rows
        self.text = rows.text

    def of(self, steps):
        """All convolutions of some steps."""
        return [c for step in steps for c in convolutions(step, self.rows.places.timed)]

    # -- of one order that is a number

    def early(self, c, order):
        """The sum of an order that is known when the code is emitted."""
        total = None
        for j in range(1, order):
            total = self._product(c, j, order - j, order, total)
        return total

    def _product(self, c, j, other, order, total):
        """Add w(j) a[j] b[other] to a sum of an order; orders are numbers or Late."""
        weight = self._weight(c, j, order)
        a = self.rows.row(c.a, j)
        a = a if weight is None else self.text.mul(weight, a)
        return self.text.fma(a, self.rows.row(c.b, other), total)

    def _weight(self, c, j, order):
        """w(j), a constant or a vector; None stands for 1."""
        if c.weight is None:
            return None
        slope = c.slope
        whole = 1.0 if c.weighted else 0.0
        j_late, j = (1.0, j.i) if isinstance(j, Late) else (0.0, j)
        k_late, k = (1.0, order.i) if isinstance(order, Late) else (0.0, order)
        rest = slope * j - whole * k
        times = slope * j_late - whole * k_late
        if times == 0.0:
            return hexadecimal(rest)
        text = self.text
        number = self.rows.number
        value = text.new(f"fmul double {number}, {hexadecimal(times)}")
        value = text.new(f"fadd double {value}, {hexadecimal(rest)}")
        return text.splat(value, text.lanes)

    # -- of a block

    def block(self, steps):
        """The parts of the sums known before a block of orders: {key: [part for each order]}."""
        wanted = self.of(steps)
        found = {}
        for squares in (True, False):
            some = [c for c in wanted if c.of_square == squares]
            together = self.rows.places.together
            for first in range(0, len(some), together):
                part = some[first : first + together]
                totals = self._loop(part, squares)
                found |= {c.key: totals[i] for i, c in enumerate(part)}
        for c in wanted:
            found[c.key] = [self._known(c, i, total) for i, total in enumerate(found[c.key])]
        return found

    def late(self, c, i, total):
        """Complete the sum of the order k + i; `total` is the part from `block`."""
        for m in range(i):  # the product that becomes known last is added last
            total = self._product(c, i - m, Late(m), Late(i), total)
            if not c.of_square:
                total = self._product(c, Late(m), i - m, Late(i), total)
        if not c.of_square:
            return total
        total = self.text.add(total, total)
        if i % 2 == 0:
            return total
        middle = self.rows.row_in_the_middle(c.a, i // 2)
        return self.text.fma(middle, middle, total)

    def _known(self, c, i, total):
        """Add the terms of small j to the loop's sum for the order k + i."""
        last = 3 if not c.of_square or i >= 2 else 2
        for j in range(i + 1, last + 1):
            total = self._product(c, j, Late(i - j), Late(i), total)
        return total

    def _loop(self, some, squares):
        """The sums of the loop over j, a list of BLOCK sums for each Convolution."""
        text = self.text
        rows = self.rows
        sums = [[text.slot(text.kind) for _ in range(BLOCK)] for _ in some]
        for place in (place for places in sums for place in places):
            text.store(ZERO, place)
        first, end = (3, rows.half) if squares else (4, rows.shift)
        number = text.slot("double")
        text.store(hexadecimal(float(first)), number, "double")
        with text.each(end, first * text.lanes, text.lanes, always=False) as j:
            self._terms(some, sums, j, number)
        return [[text.load(place) for place in places] for places in sums]

    def _terms(self, some, sums, j, number):
        """Add the products of one j to the sums of four orders."""
        text = self.text
        rows = self.rows
        known = {}
        back = text.new(f"sub i64 {rows.shift}, {j}")
        x = None
        if any(c.weight is not None for c in some):
            x = text.load(number, "double")
            text.store(text.new(f"fadd double {x}, {hexadecimal(1.0)}"), number, "double")

        def row(node, shift, i):
            place = node.key, shift, i
            if place not in known:
                at = text.at(text.at(rows.pointer(node.key), shift), i * text.lanes)
                known[place] = text.load(at)
            return known[place]

        def factors(c):
            if (c.a.key, c.weight) not in known:
                known[c.a.key, c.weight] = self._factors(c, row(c.a, j, 0), x)
            return known[c.a.key, c.weight]

        for c, places in zip(some, sums, strict=True):
            for i, place in enumerate(places):
                if c.of_square:
                    a = row(c.a, j, i // 2)
                    b = row(c.a, back, i - i // 2)
                else:
                    a = factors(c)[i]
                    b = row(c.b, back, i)
                text.store(text.fma(a, b, text.load(place)), place)

    def _factors(self, c, a, j):
        """w(j) a[j] for each of the four orders."""
        text = self.text
        if c.weight is None:
            return [a] * BLOCK
        if not c.weighted:
            return [text.mul(a, text.splat(j, text.lanes))] * BLOCK
        weight = text.new(f"fmul double {j}, {hexadecimal(c.slope)}")
        weight = text.new(f"fsub double {weight}, {self.rows.number}")
        found = [text.mul(a, text.splat(weight, text.lanes))]
        for _ in range(1, BLOCK):
            found.append(text.sub(found[-1], a))
        return found
