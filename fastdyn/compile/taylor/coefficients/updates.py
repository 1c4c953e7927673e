"""The sums over earlier orders, updated after each order: see `online.py`.

`convolutions` in `convolutions.py` lists the sums.
"""

from ..text.instructions import ONE, hexadecimal
from .convolutions import JUST_J, convolutions


class Updates:
    """The sums, and the vectors of coefficients that are added to them.

    Attributes
    ----------
    state : dict of list of str or None
        Registers of the lanes 1, 2, ...: by ("sum", key) sums; by ("c", key) coefficients c[j]; by
        ("j c", key) the products j c[j]; by ("c / c0", key) quotients.  None stands for zero.
    """

    def __init__(self, online):
        self.online = online
        self.text = online.text
        self.width = online.width
        self.wide = self.text.of(self.width)
        timed = online.timed
        self._all = [c for step in online.plan.steps for c in convolutions(step, timed)]
        self._squared = [c.a.key for c in self._all if c.of_square]
        self.doubled = {}
        wanted = {("sum", c.key[0]) for c in self._all} | {x for c in self._all for x in _names(c)}
        self.state = {name: [None] * online.registers for name in sorted(wanted)}

    def known(self):
        """The sums for the current order, by key."""
        kind = self.wide.kind
        found = {}
        for (what, key), registers in self.state.items():
            if what == "sum" and registers[0] is not None:
                found[key] = self.text.new(f"extractelement {kind} {registers[0]}, i64 0")
        return found

    def add(self, v, order):
        """Add the products of an order's coefficients v to the sums."""
        self.v = v
        self.order = order
        self._splats = {}
        self._weights = {}
        before = {name: registers for name, registers in self.state.items() if name[0] != "sum"}
        after = {name: self._inserted(name, registers) for name, registers in before.items()}
        self.sums = {
            name[1]: self._shifted(registers)
            for name, registers in self.state.items() if name[0] == "sum"
        }  # fmt: skip
        for c in self._all:
            self._add_products(c, before, after)
        self.state |= after | {("sum", key): registers for key, registers in self.sums.items()}

    def _add_products(self, c, before, after):
        """Add the products of a Convolution that contain a coefficient of the present order.

        The present order is k.  The sum of order k + i gets the products w(k) a[k] b[i] and
        w(i) a[i] b[k].  For a Power with the exponent e, the products are (e k - i) a[k] c[i] and
        (e i - k) a[i] c[k], divided by (k + i) a0.
        """
        key = c.key[0]
        a, b = _names(c)
        of_a = []
        factors = [] if c.factor is None else [self.online.factor(c.factor)]
        weights_of_b = weights_of_a = None
        if c.of_square:
            self._add(key, self._splat(c.a, *factors), self._both(c.a.key, before, after))
            return
        if c.weight == JUST_J:
            of_a = [self.order.number]
        elif c.weighted:
            of_a = [self.online.kept_values[key][0]]
            weights_of_b, weights_of_a = self._weighted(c.weight)
        first = self._splat(c.a, *factors, *of_a)
        self._add(key, first, self._weigh(before[b], weights_of_b))
        self._add(key, self._splat(c.b, *factors), self._weigh(after[a], weights_of_a))

    # -- vectors

    def _shifted(self, registers):
        """The sums, shifted by one lane."""
        kind = self.wide.kind
        found = []
        lanes = ", ".join(f"i32 {i + 1}" for i in range(self.width))
        for r in range(len(registers)):
            above = registers[r + 1] if r + 1 < len(registers) else None
            if r >= self.order.here or (registers[r] is None and above is None):
                found.append(None)
                continue
            a, b = (x or "zeroinitializer" for x in (registers[r], above))
            mask = f"<{self.width} x i32> <{lanes}>"
            found.append(self.text.new(f"shufflevector {kind} {a}, {kind} {b}, {mask}"))
        return found

    def _inserted(self, name, registers):
        """The coefficients, with the present order's coefficient if the order takes a lane."""
        what, key = name
        if not self.order.grows or self.v.get(key) is None:
            return registers
        node = self.online.plan.graph.nodes[key]
        if what == "c":
            new = self._splat(node)
        elif what == "j c":
            new = self._splat(node, self.order.number)
        else:
            new = self._splat(node, self._inverse_of(key))
        r = self.order.here - 1
        if self.order.first:
            lanes = ", ".join(f"i1 {'true' if j == 0 else 'false'}" for j in range(self.width))
            mask = f"<{lanes}>"
        else:
            mask = self.order.mask
        chosen = self.wide.select(mask, new, registers[r] or "zeroinitializer")
        return [*registers[:r], chosen, *registers[r + 1 :]]

    def _inverse_of(self, key):
        """1 / a0 of the base a of a Power."""
        power = next(c.key[0] for c in self._all if c.weighted and c.a.key == key)
        return self.online.kept_values[power][0]

    def _splat(self, node, *factors):
        """A register with c[k], times `factors`, in each lane; None stands for zero."""
        place = (node.key, *[f for f in factors if f != ONE])
        if place not in self._splats:
            value = self.v.get(node.key)
            for factor in factors:
                value = self.text.mul(value, factor)
            self._splats[place] = value and self.text.splat(value, self.width)
        return self._splats[place]

    def double(self):
        """Double the coefficients of squares, before a loop whose orders take no lanes."""
        for key in self._squared:
            self.doubled[key] = self._sums(self.state["c", key], self.state["c", key])

    def _both(self, key, before, after):
        """Registers that count earlier lanes twice, and the new lane once."""
        if not self.order.grows:
            return self.doubled[key]
        return self._sums(before["c", key], after["c", key])

    def _sums(self, before, after):
        return [self.wide.add(a, b) for a, b in zip(before, after, strict=True)]

    def _weigh(self, registers, weights):
        """Registers times weights, divided by divisors; `weights` None stands for 1."""
        if weights is None:
            return registers
        found = []
        for x, (weight, divisor) in zip(registers, weights, strict=False):
            x = self.wide.mul(weight, x)
            found.append(x if divisor is None else self.wide.div(x, divisor))
        return found

    def _add(self, key, factor, registers):
        """Add factor * registers to a sum."""
        if factor is None:
            return
        sums = self.sums[key]
        for r, x in enumerate(registers[: self.order.here]):
            if x is not None:
                sums[r] = self.wide.fma(factor, x, sums[r])

    def _weighted(self, exponent):
        """The weights of a Power's two products, register by register, with their divisors."""
        if exponent not in self._weights:
            self._weights[exponent] = list(
                zip(*[self._weights_of(exponent, r) for r in range(self.order.here)], strict=True)
            )
        return self._weights[exponent]

    def _weights_of(self, exponent, r):
        text = self.text
        wide = self.wide
        order = self.order
        width = self.width
        lanes = range(r * width + 1, (r + 1) * width + 1)
        i, e_i = (text.constant([f * j for j in lanes]) for f in (1.0, exponent))
        k = text.splat(order.number, width)
        e_k = text.splat(text.mul(hexadecimal(exponent), order.number), width)
        weights = [wide.sub(a, b) for a, b in ((e_k, i), (e_i, k))]
        place = text.new(f"add i64 {order.k}, {r * width + 1}")
        below = wide.load(text.at(order.numbers if order.exact else order.inverses, place))
        if order.exact:
            return [(weight, below) for weight in weights]
        return [(wide.mul(weight, below), None) for weight in weights]


def _names(c):
    """The names of the coefficients of a and of b of a Convolution, in `Updates.state`."""
    of_a = "j c" if c.weight == JUST_J else "c / c0" if c.weighted else "c"
    return (of_a, c.a.key), ("c", c.b.key)
