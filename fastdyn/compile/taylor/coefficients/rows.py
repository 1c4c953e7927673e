"""The coefficients of orders 1 to p in rows in memory: a vector for each node, sums by loops.

The lanes of a vector are trajectories, or like nodes of one trajectory: see `bundles.py`.  Each
node has a place in the workspace; its coefficient of order k lies k vectors behind the place.
Order 1 is computed first, then the other orders in blocks of four: see `convolutions.py`.
"""

from typing import Any

from ..recurrences.operations import Integral
from ..text.instructions import ONE, ZERO, hexadecimal
from .convolutions import BLOCK, Convolutions, Late
from .formulas import FormulasOfRows
from .order import rest


class Rows:
    """Emits the series of vectors.

    Parameters
    ----------
    plan : Bundles or Single
    order : int
        The order p of the states, 4 m + 1.
    text : Text
        For vectors.
    space : str
        The address of the workspace, of `places.size` numbers.
    places : Places
    """

    def __init__(self, plan, order, text, space, places):
        self.plan = plan
        self.text = text
        self.space = space
        self.places = places
        self.parts, self.rates = plan.parts(places)
        self.last = order - 1
        self.base = {}
        self.in_loop = False
        self.convolutions, self.formulas = Convolutions(self), FormulasOfRows(self)

    # -- addresses and values

    def pointer(self, key):
        """The address of order 0 of a node, of a factor, or of a value that a step keeps."""
        if key not in self.base:
            return self.text.at(self.space, self.places.at[key])
        return self.base[key]

    def address(self, node, order):
        at = self.pointer(node.key)
        if node.key not in self.places.history:
            return at
        if isinstance(order, Late):
            at = self.text.at(at, self.shift)
            order = order.i
        return self.text.at(at, order * self.text.lanes)

    def row(self, node, order):
        """The coefficient of an order; `order` is a number or Late.

        Coefficients of earlier orders are loaded at each use, as operands of instructions.
        """
        if order != self.order:
            return self.text.load(self.address(node, order))
        if (node.key, order) not in self.v:
            self.v[node.key, order] = self.text.load(self.address(node, order))
        return self.v[node.key, order]

    def row_in_the_middle(self, node, i):
        """The coefficient of order (k + 1) / 2 + i."""
        at = self.text.at(self.pointer(node.key), self.half)
        return self.text.load(self.text.at(at, i * self.text.lanes))

    def factor(self, f):
        """The value of an invariant."""
        known = self.places.constant(f)
        return self.text.load(self.pointer(("factor", f.key))) if known is None else known

    def of(self, node):
        """The coefficient of the current order."""
        return self.row(node, self.order)

    def put(self, node, value):
        """Store the coefficient of the current order."""
        self.v[node.key, self.order] = value = self.text.operand(value or ZERO)
        self.text.store(value, self.address(node, self.order))

    # -- all orders

    def begin(self, t, scale):
        """Compute order 1 of the states from the time and from order 0, which is in the rows."""
        text = self.text
        plan = self.plan
        self.scale = scale
        self.v = {}
        self._inverses = {}
        self.order: Any = 0
        if plan.time is not None:
            text.clear(self.pointer(plan.time.key), (self.last + 2) * text.lanes)
            text.store(t, self.pointer(plan.time.key))
            text.store(scale, text.at(self.pointer(plan.time.key), text.lanes))
        for part in self.parts:
            self.each(part, self._zeroth)
        for part in self.parts:
            if any(isinstance(step, Integral) for step in part.steps):
                self.each(part, self._slopes)
        self._rates(1)

    def emit(self):
        """Compute the other orders."""
        for self.order in range(1, BLOCK + 1):
            self._all(self._early)
            self._rates(self.order + 1)
        self._blocks()

    def _blocks(self):
        text = self.text
        with text.each(self.last + 1, BLOCK + 1, BLOCK) as self.k:
            self.v = {}
            self._inverses = {}
            self.shift = text.new(f"mul i64 {self.k}, {text.lanes}")
            self.number = text.new(f"uitofp i64 {self.k} to double")
            half = text.new(f"lshr i64 {text.new(f'add i64 {self.k}, 1')}, 1")
            self.half = text.new(f"mul i64 {half}, {text.lanes}")
            self.order = Late(0)
            self.partial = {}
            in_line = [part.steps for part in self.parts if part.table is None]
            self._block([step for steps in in_line for step in steps])
            for part in self.parts:
                if part.table is not None:
                    self.each(part, self._block)
            for i in range(BLOCK):
                self.order = Late(i)
                self._all(self._late)
                self._rates(Late(i + 1))

    def _all(self, emit):
        for part in self.parts:
            self.each(part, emit)

    def each(self, part, emit):
        """Call ``emit(steps)`` for the steps of a part, within a loop if the part has a table."""
        if part.table is None:
            emit(part.steps)
            return
        text = self.text
        outer = (self.v, self._inverses)
        table = text.indices(f"{part.name}table", part.table)
        with text.each(len(part.table)) as u:
            self.v = {}
            self._inverses = {}
            self.in_loop = True
            first = text.new(f"mul i64 {u}, {part.table.shape[1]}")
            for i, key in enumerate(part.slots):
                place = text.index(table, text.new(f"add i64 {first}, {i}"))
                self.base[key] = text.at(self.space, place)
            emit(part.steps)
        self.v, self._inverses = outer
        self.in_loop = False

    def over(self, value, order, factor=ONE):
        """factor value / order; without bias of rounding in low orders, see `order.rest`."""
        text = self.text
        if value is None:
            return None
        if (order, factor) not in self._inverses:
            found = self._inverse(order)
            self._inverses[order, factor] = [text.mul(x, factor) for x in found]
        inverse, error = self._inverses[order, factor]
        return text.fma(value, inverse, text.mul(value, error))

    def _inverse(self, order):
        """1 / order as a number, and its rounding error."""
        text = self.text
        if not isinstance(order, Late):
            return hexadecimal(1.0 / order), hexadecimal(rest(order)) if rest(order) else None
        table = text.table("inverses", [1.0 / max(k, 1) for k in range(self.last + 2)])
        place = text.at(text.at(table, self.k), order.i)
        return text.splat(text.load(place, "double"), text.lanes), None

    # -- order 0

    def _zeroth(self, steps):
        for step in steps:
            self.put(step.node, self.formulas.zeroth(step))

    def _slopes(self, steps):
        for step in steps:
            if isinstance(step, Integral) and step.node.key not in self.places.timed:
                self.formulas.slopes(step)

    # -- the other orders

    def _early(self, steps):
        """The coefficients of an order that is known when the code is emitted."""
        sums = self.convolutions
        for step in steps:
            self._coefficient(step, [(c, sums.early(c, self.order)) for c in sums.of([step])])

    def _block(self, steps):
        found = self.convolutions.block(steps)
        if not self.in_loop:
            self.partial |= found
            return
        for c in self.convolutions.of(steps):
            for i, value in enumerate(found[c.key]):
                self.text.store(value, self._place_of_partial(c, i))

    def _place_of_partial(self, c, i):
        key, number = c.key
        at = (number * BLOCK + i) * self.text.lanes
        return self.text.at(self.pointer(("partial", key)), at)

    def _late(self, steps):
        sums = self.convolutions
        i = self.order.i
        for step in steps:
            totals = []
            for c in sums.of([step]):
                known = self.in_loop and self.text.load(self._place_of_partial(c, i))
                totals.append((c, sums.late(c, i, known or self.partial[c.key][i])))
            self._coefficient(step, totals)

    def _coefficient(self, step, totals):
        total = self.formulas.together(totals)
        self.put(step.node, self.formulas.coefficient(step, total))

    def _rates(self, following):
        """Store the coefficients of the states' next order."""
        for part in self.rates:
            self.each(part, lambda steps: self._next(steps, following))

    def _next(self, steps, following):
        text = self.text
        for step in steps:
            value = None
            factor = self.scale
            if step.core is not None:
                factor = text.mul(self.factor(step.factor), factor)
                value = self.over(self.of(step.core), following, factor)
            if self.order == 0 and step.constant is not None:
                constant = text.mul(self.factor(step.constant), self.scale)
                value = text.add(value, constant)
            self.v[step.node.key, following] = value = text.operand(value or ZERO)
            text.store(value, self.address(step.node, following))
