"""The coefficient of each step in rows, from the sums over earlier orders."""

from ..recurrences.operations import Integral
from .convolutions import Late
from .places import n_kept
from .values import Start, shallow_first

SHUFFLED = 4  # up to so many source vectors, shuffles gather the lanes


class Formulas:
    """Emits the coefficients of one order: of `rows.order`, for the vectors of a `rows.Rows`."""

    def __init__(self, rows):
        self.rows, self.text, self._start = rows, rows.text, _Start(rows, self)

    def zeroth(self, step):
        """The value of order 0 of a step; keeps values for the other orders."""
        value = self._start.take(step)
        if n_kept(step) and not isinstance(step, Integral):
            self._keep(step, flat(self._start.kept[step.node.key]))
        return value

    def slopes(self, step):
        """Keep the derivatives of a function by its arguments."""
        self._keep(step, self._start.slopes(step))

    def of(self, step, totals):
        """The coefficient of a step at a higher order.

        `totals` are the sums over earlier orders, by key.
        """
        return getattr(self, f"_{type(step).__name__.lower()}")(step, totals)

    def _keep(self, step, values):
        room = self.rows.pointer(("kept", step.node.key))
        for i, value in enumerate(values):
            self.text.store(value, self.text.at(room, i * self.text.lanes))

    def _kept(self, step):
        if not n_kept(step):
            return []
        room, lanes = self.rows.pointer(("kept", step.node.key)), self.text.lanes
        return [self.text.load(self.text.at(room, i * lanes)) for i in range(n_kept(step))]

    def _gather(self, step, totals=None):
        """A vector gathered from lanes of other vectors."""
        sources = {node.key: node for node, _ in step.lanes}
        if len(sources) > SHUFFLED or step.lanes[0][0].op == "slot":
            return self._one_by_one(step)
        value = None
        for node in sources.values():
            value = self._with_lanes(value, node, step.lanes)
        return value

    def _one_by_one(self, step):
        text, rows, value = self.text, self.rows, "poison"
        for i, (node, lane) in enumerate(step.lanes):
            x = text.load(text.at(rows.address(node, rows.order), lane), "double")
            value = text.new(f"insertelement {text.kind} {value}, double {x}, i64 {i}")
        return value

    def _with_lanes(self, value, node, lanes):
        """A vector in which the lanes that come from `node` are replaced."""
        text, other = self.text, self.rows.of(node)
        shift = 0 if value is None else text.lanes
        places = [shift + lane if node is source else i for i, (source, lane) in enumerate(lanes)]
        mask = f"<{text.lanes} x i32> <{', '.join([f'i32 {i}' for i in places])}>"
        pair = f"{text.kind} {other if value is None else value}, {text.kind} {other}"
        return text.new(f"shufflevector {pair}, {mask}")

    def _sum(self, step, totals):
        text, rows, total, kept = self.text, self.rows, None, iter(self._kept(step))
        for i, (f, _, _) in enumerate(step.products):
            total = text.fma(rows.factor(f), totals[step.node.key, i], total)
        parts = [(rows.factor(f), a) for f, a in step.terms]
        for _, a, b in step.products:
            parts += [(next(kept), x) for x in ((a,) if a is b else (b, a))]
        for f, a in shallow_first(rows.plan, parts):
            total = text.fma(f, rows.of(a), total)
        return total

    def _quotient(self, step, totals):
        rows = self.rows
        top, slope, minus = self._kept(step)
        total = self.text.mul(totals[step.node.key, 0], minus)
        if step.a is not None:
            total = self.text.fma(top, rows.of(step.a), total)
        return self.text.fma(slope, rows.of(step.b), total)

    def _power(self, step, totals):
        rows = self.rows
        inverse, slope = self._kept(step)
        total = rows.over(totals[step.node.key, 0], rows.order)
        return self.text.fma(rows.of(step.a), slope, self.text.mul(total, inverse))

    def _root(self, step, totals):
        rows = self.rows
        half, minus = self._kept(step)
        return self.text.fma(rows.of(step.a), half, self.text.mul(totals[step.node.key, 0], minus))

    def _integral(self, step, totals):
        text, rows, total = self.text, self.rows, None
        if step.node.key in rows.places.timed:
            return self._of_time(*step.parts[0])
        for i, (f, _, _) in enumerate(step.parts):
            part = totals.get((step.node.key, i))
            total = text.fma(rows.factor(f), part, total)
        total = rows.over(total, rows.order)
        for slope, (_, a, _) in zip(self._kept(step), step.parts, strict=True):
            total = text.fma(rows.of(a), slope, total)
        return total

    def _of_time(self, f, a, g):
        """The coefficient of a function whose argument is linear in time."""
        text, rows, order = self.text, self.rows, self.rows.order
        before = Late(order.i - 1) if isinstance(order, Late) else order - 1
        slope = text.mul(rows.factor(f), rows.row(a, 1))
        return rows.over(text.mul(slope, rows.row(g, before)), order)


def flat(values):
    """The numbers in a list of numbers and tuples, without None."""
    each = [v if isinstance(v, tuple) else (v,) for v in values]
    return [x for v in each for x in v if x is not None]


class _Start(Start):
    """Order 0 of rows."""

    def __init__(self, rows, formulas):
        super().__init__(None, rows.text, rows.factor, {}, {})
        self._rows, self._gather = rows, formulas._gather

    def of(self, node):
        rows = self._rows
        known = node.key in rows.base or node.key in rows.places.at
        return rows.of(node) if known else rows.factor(node)
