"""The sums over earlier orders, updated after each order: see `online.py`."""

from ..recurrences.operations import Integral, Power, Quotient, Root, Sum
from ..text.instructions import ONE, hexadecimal


class Updates:
    """The sums, and the vectors of coefficients that are added to them.

    Attributes
    ----------
    state : dict of list of str or None
        Registers of the lanes 1, 2, ...: by ("sum", key) sums; by ("c", key) coefficients c[j]; by
        ("j c", key) the products j c[j]; by ("c / c0", key) quotients.  None stands for zero.
    """

    def __init__(self, online):
        self.online, self.text, self.width = online, online.text, online.width
        wanted = set()
        for step in online.plan.steps:
            wanted |= set(self._wanted(step))
        self._squared, self.doubled = self._squares(), {}
        self.state = {name: [None] * online.registers for name in sorted(wanted)}

    def _squares(self):
        """The keys of nodes whose square, or own square root, is a recurrence."""
        steps = self.online.plan.steps
        sums = [step for step in steps if isinstance(step, Sum)]
        found = [a.key for step in sums for _, a, b in step.products if a is b]
        return found + [step.node.key for step in steps if isinstance(step, Root)]

    def _wanted(self, step):
        key = step.node.key
        if isinstance(step, Sum):
            yield from (("c", x.key) for _, a, b in step.products for x in (a, b))
            if step.products:
                yield "sum", key
        elif isinstance(step, Quotient):
            yield from (("sum", key), ("c", key), ("c", step.b.key))
        elif isinstance(step, Power):
            yield from (("sum", key), ("c", key), ("c / c0", step.a.key))
        elif isinstance(step, Root):
            yield from (("sum", key), ("c", key))
        elif isinstance(step, Integral) and not self.online.by_time(step):
            for _, a, g in step.parts:
                if g is not None:
                    yield from (("sum", key), ("j c", a.key), ("c", g.key))

    def known(self):
        """The sums for the current order, by key."""
        kind, found = f"<{self.width} x double>", {}
        for (what, key), registers in self.state.items():
            if what == "sum" and registers[0] is not None:
                found[key] = self.text.new(f"extractelement {kind} {registers[0]}, i64 0")
        return found

    def add(self, v, order):
        """Add the products of an order's coefficients v to the sums."""
        self.v, self.order, self._splats, self._weights = v, order, {}, {}
        before = {name: registers for name, registers in self.state.items() if name[0] != "sum"}
        after = {name: self._inserted(name, registers) for name, registers in before.items()}
        self.sums = {
            name[1]: self._shifted(registers)
            for name, registers in self.state.items() if name[0] == "sum"
        }  # fmt: skip
        for step in self.online.plan.steps:
            if step.node.key in self.sums:
                getattr(self, f"_{type(step).__name__.lower()}")(step, before, after)
        self.state |= after | {("sum", key): registers for key, registers in self.sums.items()}

    # -- the products of each recurrence

    def _sum(self, step, before, after):
        key = step.node.key
        for f, a, b in step.products:
            factor = self.online.invariant(f)
            if a is b:
                self._add(key, self._splat(a, factor), self._both(a.key, before, after))
            else:
                self._add(key, self._splat(a, factor), before["c", b.key])
                self._add(key, self._splat(b, factor), after["c", a.key])

    def _quotient(self, step, before, after):
        key, b = step.node.key, step.b.key
        self._add(key, self._splat(step.b), before["c", key])
        self._add(key, self._splat(step.node), after["c", b])

    def _root(self, step, before, after):
        key = step.node.key
        self._add(key, self._splat(step.node), self._both(key, before, after))

    def _integral(self, step, before, after):
        key = step.node.key
        for f, a, g in step.parts:
            if g is not None:
                factor = self.online.invariant(f)
                self._add(key, self._splat(a, factor, self.order.number), before["c", g.key])
                self._add(key, self._splat(g, factor), after["j c", a.key])

    def _power(self, step, before, after):
        """Add (e k - i) / (k + i) c[i] a[k] / a0 and (e i - k) / (k + i) a[i] c[k] / a0."""
        key, (inverse, _) = step.node.key, self.online.kept[step.node.key]
        of_c, of_a = self._weighted(step.exponent)
        c, a = before["c", key], after["c / c0", step.a.key]
        self._add(key, self._splat(step.a, inverse), self._weigh(c, of_c))
        self._add(key, self._splat(step.node), self._weigh(a, of_a))

    # -- vectors

    def _shifted(self, registers):
        """The sums, shifted by one lane."""
        kind, found = f"<{self.width} x double>", []
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
        """The coefficients, together with this order's coefficient if the order has a lane."""
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
        kind, old = f"<{self.width} x double>", registers[r] or "zeroinitializer"
        if self.order.first:
            lanes = ", ".join(f"i1 {'true' if j == 0 else 'false'}" for j in range(self.width))
            mask = f"<{lanes}>"
        else:
            mask = self.order.mask
        bits = f"<{self.width} x i1>"
        chosen = self.text.new(f"select {bits} {mask}, {kind} {new}, {kind} {old}")
        return [*registers[:r], chosen, *registers[r + 1 :]]

    def _inverse_of(self, key):
        for step in self.online.plan.steps:
            if isinstance(step, Power) and step.a.key == key:
                return self.online.kept[step.node.key][0]
        raise KeyError(key)

    def _splat(self, node, *factors):
        """A register with c[k] times factors in all lanes; None stands for zero."""
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
        kind = f"<{self.width} x double>"
        return [
            b if a is None else b and self.text.new(f"fadd {kind} {a}, {b}")
            for a, b in zip(before, after, strict=True)
        ]

    def _weigh(self, registers, weights):
        """Registers times weights, divided by the divisor if there is one."""
        kind, found = f"<{self.width} x double>", []
        for x, (weight, divisor) in zip(registers, weights, strict=False):
            if x is not None:
                x = self.text.new(f"fmul {kind} {weight}, {x}")
                x = x if divisor is None else self.text.new(f"fdiv {kind} {x}, {divisor}")
            found.append(x)
        return found

    def _add(self, key, factor, registers):
        """Add factor * registers to a sum."""
        if factor is None:
            return
        sums = self.sums[key]
        for r, x in enumerate(registers[: self.order.here]):
            if x is not None:
                sums[r] = self.text.vector_fma(factor, x, sums[r], self.width)

    def _weighted(self, exponent):
        """The weights of `_power`, register by register, and the divisors."""
        if exponent not in self._weights:
            self._weights[exponent] = list(
                zip(*[self._weights_of(exponent, r) for r in range(self.order.here)], strict=True)
            )
        return self._weights[exponent]

    def _weights_of(self, exponent, r):
        text, order, width = self.text, self.order, self.width
        kind, lanes = f"<{width} x double>", range(r * width + 1, (r + 1) * width + 1)
        i, e_i = (
            "<" + ", ".join(f"double {hexadecimal(f * j)}" for j in lanes) + ">"
            for f in (1.0, exponent)
        )
        k = text.splat(order.number, width)
        e_k = text.splat(text.mul(hexadecimal(exponent), order.number), width)
        weights = [text.new(f"fsub {kind} {a}, {b}") for a, b in ((e_k, i), (e_i, k))]
        place = text.new(f"add i64 {order.k}, {r * width + 1}")
        below = text.load(text.at(order.numbers if order.exact else order.inverses, place), kind)
        if order.exact:
            return [(weight, below) for weight in weights]
        return [(text.new(f"fmul {kind} {weight}, {below}"), None) for weight in weights]
