"""Loops over the orders of a series, one loop for each number of registers."""


class Loops:
    """Emits the orders from 2 on of an `Online`."""

    def __init__(self, series):
        self.series, self.text = series, series.text

    def _phases(self):
        """Yield (first order, last order, whether lanes are added, registers) for each loop."""
        one = self.series
        width, lanes = one.width, one.lanes
        for r in range(1, one.registers + 1):
            yield max(2, (r - 1) * width + 1), min(r * width, lanes), True, r
        first = lanes + 1
        for r in range(one.registers, 0, -1):
            last = one.last if r == 1 else one.last - (r - 1) * width
            yield first, last, False, r
            first = max(first, last + 1)

    def emit(self):
        text, one = self.text, self.series
        rooms = self._rooms()
        self._keep(rooms)
        for first, last, grows, here in self._phases():
            if first > last:
                continue
            if not grows:
                self._restore(rooms, here)
                one.updates.double()
            with text.each(last + 1, first) as k:
                self._restore(rooms, here)
                one.add_order(one.order(k, here, grows))
                one.store(text.new(f"add i64 {k}, 1"))
                self._keep(rooms, here)

    def _numbers(self):
        """The dictionaries of numbers that one order passes to the next, besides the vectors."""
        one = self.series
        return one.leaf, one.ahead, one.previous

    def _rooms(self):
        """Reserve stack memory for the values that one order passes to the next."""
        vector = f"<{self.series.width} x double>"
        numbers = [{key: self.text.slot("double") for key in part} for part in self._numbers()]
        vectors = {
            name: [self.text.slot(vector) for _ in registers]
            for name, registers in self.series.updates.state.items()
        }
        return numbers, vectors

    def _keep(self, rooms, here=None):
        numbers, vectors = rooms
        for part, places in zip(self._numbers(), numbers, strict=True):
            for key, place in places.items():
                self.text.store(part[key], place)
        for name, registers in self.series.updates.state.items():
            for value, place in list(zip(registers, vectors[name], strict=True))[:here]:
                self.text.store(value, place, f"<{self.series.width} x double>")

    def _restore(self, rooms, here):
        one, (numbers, vectors) = self.series, rooms
        one.leaf, one.ahead, one.previous = (
            {key: self.text.load(place) for key, place in places.items()} for places in numbers
        )
        kind, none = f"<{one.width} x double>", [None] * (one.registers - here)
        one.updates.state = {
            name: [self.text.load(place, kind) for place in places[:here]] + none
            for name, places in vectors.items()
        }
