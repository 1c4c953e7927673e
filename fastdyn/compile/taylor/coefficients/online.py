"""The coefficients of orders 1 to p for one trajectory, with vectors over the orders.

When a[k] and b[k] become known, their products with all earlier coefficients are added to the sums
of the later orders, several orders at once::

    lane i of a sum holds the part of c[k+i] that is known after order k
    c[k] = lane 1 of the sum, shifted, + a[k] b[0] + a[0] b[k]       numbers, a short chain
    sum  = shift(sum, 1) + splat(a[k]) B + splat(b[k]) A             vectors, in parallel

with A = (a[1], ..., a[k]) and B = (b[1], ..., b[k]).  No vector is reduced to its sum, and no load
follows a store of its value.  Lanes exist up to p / 2 only, because i <= k and k + i <= p.

The loop over k is not unrolled.  It is split into phases by the number of registers of the lanes.
"""

from ..recurrences.listing import timed
from ..text.instructions import ZERO
from ..text.loops import Loops
from .formulas import Formulas
from .order import Order, Tables
from .updates import Updates
from .values import Start


class Watched:
    """Stores the series of the numbers that a plan watches, for `kernels/methods/taylor/kinks.py`.

    Parameters
    ----------
    plan : Plan
    text : Text
    rows, row : str, int
        The address of the coefficients, as in `Online`.
    sides : str
        The address of the signs, just behind the start, of differences that are zero at the start.
    """

    def __init__(self, plan, text, rows, row, sides):
        self.plan = plan
        self.text = text
        self._rows = rows
        self._row = row
        self._sides = sides
        self.raising = "false"

    def sides(self):
        """The signs by key."""
        text = self.text
        signed = self.plan.signed
        return {
            key: text.load(text.at(self._sides, i))
            for i, key in enumerate(self.plan.watched) if key in signed
        }  # fmt: skip

    def begin(self, start):
        """Take the truth of `raising` from order 0."""
        if self.plan.raises():
            self.raising = start.truth(self.plan.raising)

    def store(self, k, values):
        """Store the coefficients of order k."""
        text = self.text
        if self.plan.watched:
            at = k * self._row if isinstance(k, int) else text.new(f"mul i64 {k}, {self._row}")
            row = text.at(self._rows, at)
            for i, key in enumerate(self.plan.watched):
                text.store(values[key], text.at(row, i))


class Online(Formulas):
    """Emits the series of one trajectory.

    Parameters
    ----------
    plan : Plan
        The recurrences of y'.
    order : int
        The order p of the states.
    text : Text
    width : int
        Lanes of a vector register.
    factor : callable
        ``factor(node)`` returns the value of an invariant.
    rows : str
        The address of the coefficients; order k has `row` numbers, from number k row on.  Order 0
        is already stored.
    scale : str
        The value of the unit of time s: the series are in powers of t / s.
    watched : Watched

    Attributes
    ----------
    exact : bool
        See `Order`.
    """

    exact = False

    def __init__(self, plan, order, text, width, factor, rows, row, scale, watched):
        self.watched = watched
        self._paced = {}
        self.plan = plan
        self.text = text
        self.width = width
        self.factor = factor
        self.rows = rows
        self.row = row
        self.scale = scale
        self.last = order - 1
        self.lanes = max((order - 1) // 2, 1)
        self.registers = -(-self.lanes // width)
        self.timed = timed(plan)
        self.previous = {}
        self.slope = {}
        self.updates = Updates(self)

    def begin(self, t, y):
        """Compute order 0 from the values of time and state."""
        plan = self.plan
        known = {a.key: t if a.op == "t" else y[a.data] for a in self.plan.leaves().values()}
        start = Start(plan, self.text, self.factor, known, self.watched.sides())
        start.emit()
        self.kept_values = start.kept
        self.watched.begin(start)
        self.watched.store(0, known | start.value)
        self._zeroth = {step.node.key: start.of(step.node) for step in plan.steps} | known

    def _slopes(self):
        """The derivatives of the states, from order 0."""
        return [
            self.factor(f)
            if core is None
            else self.text.mul(self.factor(f), self._zeroth[core.key])
            for f, core in self.plan.outputs
        ]

    def emit(self):
        """Compute the orders from 1 on, and store them in rows 1 to p."""
        self.previous = {
            g.key: self._zeroth[g.key]
            for step in self.plan.steps if step.node.key in self.timed
            for _, _, g in step.parts
        }  # fmt: skip
        self._tables = Tables(self.text, self.last + 1)
        self.leaf = self._first()
        self.store(1)
        self.add_order(self.order(1, min(1, self.registers), True))
        self.store(2)
        Loops(self).emit()

    def order(self, k, here, grows):
        """The `Order` k of this series."""
        return Order(self.text, k, here, grows, self.width, self._tables, self.exact)

    def _first(self):
        """The coefficients of order 1 of the states, by index."""
        for f, core in self.plan.outputs:  # scale f, computed before the loops over orders
            if core is not None and f.key not in self._paced:
                self._paced[f.key] = self.text.mul(self.scale, self.factor(f))
        return {i: self.text.mul(self.scale, slope) for i, slope in enumerate(self._slopes())}

    def store(self, k):
        """Store the coefficients of order k of all states; k is a number or an LLVM value."""
        text = self.text
        first = k * self.row if isinstance(k, int) else text.new(f"mul i64 {k}, {self.row}")
        begin = text.at(self.rows, first)
        for i, value in self.leaf.items():
            text.store(value, text.at(begin, i))

    # -- one order

    def add_order(self, order):
        """Compute the coefficients of one order, and add their products to the later sums."""
        plan = self.plan
        v = {}
        self._v = v
        self._order = order
        for a in self.plan.leaves().values():
            v[a.key] = self.leaf[a.data] if a.op == "y" else self.scale if order.first else None
            if a.op == "t":
                self.slope[a.key] = self.scale
        known = self.updates.known()
        for step in plan.steps:
            key = step.node.key
            v[key] = self.coefficient(step, known.get(key))
            if order.first and plan.degree.get(key) == 1:
                self.slope[key] = v[key]
        self.watched.store(order.k, v)
        self.leaf = self._next(v, order)
        if order.here:
            self.updates.add(v, order)
        self.previous = {key: v[key] for key in self.previous}

    def of(self, node):
        return self._v[node.key]

    def kept(self, step):
        return self.kept_values[step.node.key]

    def by_order(self, total):
        return self.text.mul(total, self._order.inverse)

    def _choice(self, step, _):
        a, b = (self._v.get(x.key) or ZERO for x in (step.a, step.b))
        return self.text.select(self.kept(step), a, b)

    def of_time(self, step):
        text = self.text
        ((f, a, g),) = step.parts
        slope = self.slope[a.key]
        if self._order.first:
            return text.mul(slope, self.kept(step)[0])
        factor = text.mul(text.mul(self.factor(f), slope), self._order.inverse)
        return text.mul(self.previous[g.key], factor)

    def _next(self, v, order):
        """The next coefficients of the states, by index."""
        return {
            i: None if core is None else order.next(v[core.key], self._paced[f.key])
            for i, (f, core) in enumerate(self.plan.outputs)
        }
