"""Loops over the orders of a series.

For each number of registers, one loop has orders that take new lanes, one loop has orders that take
none.
"""


class Loops:
    """Emits the orders from 2 on of an `Online`."""

    def __init__(self, series):
        self.series = series
        self.text = series.text

    def _phases(self):
        """Yield (first order, last order, whether lanes are added, registers) for each loop."""
        one = self.series
        width = one.width
        lanes = one.lanes
        for r in range(1, one.registers + 1):
            yield max(2, (r - 1) * width + 1), min(r * width, lanes), True, r
        first = lanes + 1
        for r in range(one.registers, 0, -1):
            last = one.last if r == 1 else one.last - (r - 1) * width
            yield first, last, False, r
            first = max(first, last + 1)

    def emit(self):
        text = self.text
        one = self.series
        self._rooms = {name: text.slot(kind) for name, _, _, kind in self._passed(one.registers)}
        self._keep(one.registers)
        for first, last, grows, here in self._phases():
            if first > last:
                continue
            if not grows:
                self._restore(here)
                one.updates.double()
            with text.each(last + 1, first) as k:
                self._restore(here)
                one.add_order(one.order(k, here, grows))
                one.store(text.new(f"add i64 {k}, 1"))
                self._keep(here)

    def _passed(self, here):
        """Yield (name, values, key, type) for each value that one order passes to the next order.

        The value is ``values[key]``.  Of each list of registers, the first `here` are passed.
        """
        one = self.series
        for part in ("leaf", "previous"):
            values = getattr(one, part)
            for key in values:
                yield (part, key), values, key, "double"
        for name, registers in one.updates.state.items():
            for r in range(here):
                yield (name, r), registers, r, f"<{one.width} x double>"

    def _keep(self, here):
        for name, values, key, kind in self._passed(here):
            self.text.store(values[key], self._rooms[name], kind)

    def _restore(self, here):
        for name, values, key, kind in self._passed(here):
            values[key] = self.text.load(self._rooms[name], kind)
        for registers in self.series.updates.state.values():
            registers[here:] = [None] * (len(registers) - here)
