"""The coefficient of each step, from its sum over earlier orders."""

from typing import Any

from ..recurrences.operations import Integral
from .convolutions import Late
from .places import n_kept
from .values import Start, shallow_first

SHUFFLED = 4  # most source vectors from which shuffles gather lanes


class Formulas:
    """Emits the coefficients of one order.

    A subclass has `text` and `plan`, and these methods.  ``factor(f)`` is the value of an
    invariant, ``of(node)`` the coefficient of a node.  ``kept(step)`` is the list of values that
    order 0 keeps for a step.  ``by_order(total)`` divides a sum by the order.  `timed` has the keys
    of functions whose argument is linear in time; ``of_time(step)`` is their coefficient.
    """

    text: Any
    plan: Any
    timed: Any
    factor: Any
    of: Any
    kept: Any
    by_order: Any
    of_time: Any

    def coefficient(self, step, total):
        """The coefficient of a step; `total` is the sum of its products of earlier orders."""
        return getattr(self, f"_{type(step).__name__.lower()}")(step, total)

    def _sum(self, step, total):
        kept = iter(self.kept(step))
        parts = [(self.factor(f), a) for f, a in step.terms]
        for _, a, b in step.products:
            parts += [(next(kept), x) for x in ((a,) if a is b else (b, a))]
        for f, a in shallow_first(self.plan, parts):
            total = self.text.fma(f, self.of(a), total)
        return total

    def _quotient(self, step, total):
        top, slope, minus = self.kept(step)
        total = self.text.mul(total, minus)
        parts = [(slope, step.b)] + ([(top, step.a)] if step.a is not None else [])
        for f, a in self.in_turn(parts):
            total = self.text.fma(f, self.of(a), total)
        return total

    def in_turn(self, parts):
        """The parts of a quotient, in the order of their addition."""
        return shallow_first(self.plan, parts)

    def _power(self, step, total):
        return self.text.fma(self.of(step.a), self.kept(step)[1], total)

    def _root(self, step, total):
        half, minus = self.kept(step)
        return self.text.fma(self.of(step.a), half, self.text.mul(total, minus))

    def _integral(self, step, total):
        if step.node.key in self.timed:
            return self.of_time(step)
        total = self.by_order(total)
        for slope, (_, a, _) in zip(self.kept(step), step.parts, strict=True):
            total = self.text.fma(self.of(a), slope, total)
        return total


class FormulasOfRows(Formulas):
    """Emits the coefficients of the order `rows.order`, for the vectors of a `rows.Rows`."""

    def __init__(self, rows):
        self.rows = rows
        self.text = rows.text
        self.plan = rows.plan
        self.factor = rows.factor
        self.of = rows.of
        self.timed = rows.places.timed
        self._start = _Start(rows, self)

    def zeroth(self, step):
        """The value of order 0 of a step; keeps values for the other orders."""
        value = self._start.take(step)
        if n_kept(step) and not isinstance(step, Integral):
            self._keep(step, self._start.kept[step.node.key])
        return value

    def slopes(self, step):
        """Keep the derivatives of a function by its arguments."""
        self._keep(step, self._start.slopes(step))

    def _keep(self, step, values):
        room = self.rows.pointer(("kept", step.node.key))
        for i, value in enumerate(values):
            self.text.store(value, self.text.at(room, i * self.text.lanes))

    def kept(self, step):
        if not n_kept(step):
            return []
        room = self.rows.pointer(("kept", step.node.key))
        lanes = self.text.lanes
        return [self.text.load(self.text.at(room, i * lanes)) for i in range(n_kept(step))]

    def together(self, totals):
        """The sum of the products of a step, from pairs (Convolution, sum)."""
        total = None
        for c, part in totals:
            total = part if c.factor is None else self.text.fma(self.factor(c.factor), part, total)
        return total

    def by_order(self, total):
        return self.rows.over(total, self.rows.order)

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
        text = self.text
        rows = self.rows
        value = "poison"
        for i, (node, lane) in enumerate(step.lanes):
            x = text.load(text.at(rows.address(node, rows.order), lane), "double")
            value = text.new(f"insertelement {text.kind} {value}, double {x}, i64 {i}")
        return value

    def _with_lanes(self, value, node, lanes):
        """A vector in which the lanes that come from `node` are replaced."""
        text = self.text
        other = self.rows.of(node)
        shift = 0 if value is None else text.lanes
        places = [shift + lane if node is source else i for i, (source, lane) in enumerate(lanes)]
        mask = f"<{text.lanes} x i32> <{', '.join([f'i32 {i}' for i in places])}>"
        pair = f"{text.kind} {other if value is None else value}, {text.kind} {other}"
        return text.new(f"shufflevector {pair}, {mask}")

    def in_turn(self, parts):
        return parts[::-1]

    def _power(self, step, total):
        inverse, slope = self.kept(step)
        total = self.text.mul(self.by_order(total), inverse)
        return self.text.fma(self.of(step.a), slope, total)

    def of_time(self, step):
        rows = self.rows
        order = self.rows.order
        ((f, a, g),) = step.parts
        before = Late(order.i - 1) if isinstance(order, Late) else order - 1
        slope = self.text.mul(rows.factor(f), rows.row(a, 1))
        return rows.over(self.text.mul(slope, rows.row(g, before)), order)


class _Start(Start):
    """Order 0 of rows."""

    def __init__(self, rows, formulas):
        super().__init__(None, rows.text, rows.factor, {}, {})
        self._rows = rows
        self._gather = formulas._gather

    def of(self, node):
        rows = self._rows
        known = node.key in rows.base or node.key in rows.places.at
        return rows.of(node) if known else rows.factor(node)
