"""The series of an event, a function of t and y, from the series of y along a step.

The kernel is ``int64 series(t_old, h, work, block address, out)``.
`kernels/output/series_roots/all_roots.py` calls the kernel.
"""

from fastdyn.kernels.state.record import K
from fastdyn.kernels.state.series import SCALE

from ..recurrences import deceptive
from ..text.instructions import ONE, Text, hexadecimal
from .online import Online

WORDS = {"t": (0, "double"), "h": (1, "double"), "work": (2, "ptr"), "n": (4, "i64"),
         "block": (5, "ptr"), "out": (6, "ptr")}  # fmt: skip


class _Terms:
    """Stores the coefficients of the event; replaces `Watched` in an `Online`.

    The series of a root continues beyond a zero of the radicand, and that of atan2 beyond its jump.
    Therefore the numbers that decide must not reach zero: the sum of the sizes of their terms from
    order 1 on must be smaller than their values at the start.
    """

    def __init__(self, plan, text, x, invariant):
        self.plan = plan
        self.text = text
        self.x = x
        self.invariant = invariant
        self._power = text.slot("double")
        self._guards = [guard for guard in map(self._guard, plan.steps) if guard]
        numbers = {a.key for guard in self._guards for a in guard}
        self._sizes = {key: (text.slot("double"), text.slot("double")) for key in numbers}

    def _guard(self, step):
        """The numbers of a step of which one must keep its sign; the second must be positive."""
        if step.node.op == "atan2":
            return [a for a in step.arguments if not self.plan.rewrite.is_invariant(a)]
        return [step.a] if deceptive.root(step) else []

    def sides(self):
        return {}

    def begin(self, start):
        self.text.store(ONE, self._power)

    def store(self, k, values):
        """Store c[k] x^k."""
        text = self.text
        ((f, core),) = self.plan.outputs
        power = text.load(self._power)
        term = text.mul(text.mul(self.invariant(f), values[core.key]), power)
        text.store(term, text.at("%out", k))
        for key, (first, sum_) in self._sizes.items():
            value = text.mul(values[key], power)
            if k == 0:
                text.store(value, first)
                text.store(None, sum_)
            elif value is not None:
                size = text.intrinsic("fabs", value)
                text.store(text.add(text.load(sum_), size), sum_)
        text.store(text.mul(power, self.x), self._power)

    def n_terms(self, n):
        """n, or -1 if the event may differ from its series."""
        text = self.text
        sound = "true"
        for numbers in self._guards:
            one = "false"
            for i, a in enumerate(numbers):
                first, sum_ = map(text.load, self._sizes[a.key])
                size = text.intrinsic("fabs", first) if i == 0 else first
                one = text.truths("or", one, text.compare("olt", sum_, size))
            sound = text.truths("and", sound, one)
        return text.new(f"select i1 {sound}, i64 {n}, i64 -1")


class Composed(Online):
    """The series of a plan's only output, from the stored series of the state."""

    @property
    def used(self):
        """The components that the function uses."""
        return sorted(a.data for a in self.plan.leaves().values() if a.op == "y")

    def _first(self):
        return self._coefficients(1)

    def store(self, k):
        """Store nothing: `_Terms` stores the coefficients."""

    def _next(self, v, order):
        later = 2 if order.first else self.text.new(f"add i64 {order.k}, 1")
        return self._coefficients(later)

    def _coefficients(self, k):
        """The coefficients of order k of the components that the function uses."""
        text = self.text
        begin = text.at(self.rows, text.new(f"mul i64 {k}, {self.row}"))
        return {i: text.load(text.at(begin, i)) for i in self.used}


def emit(plan, order, symbol, declared, fused, width=4):
    """LLVM's text of the kernel, which calls ``fastdyn_invariants(block, out)``."""
    text = Text(fused)
    text.read_words(WORDS)
    room = text.slot("double", max(len(plan.invariants), 1))
    text.put(f"call void @fastdyn_invariants(ptr %block, ptr {room})")
    known = {key: text.load(text.at(room, i)) for i, key in enumerate(plan.invariants)}

    def invariant(node):
        return hexadecimal(node.data) if node.op == "const" else known[node.key]

    scale = text.load(text.at("%work", text.new(f"mul i64 %n, {SCALE}")))
    rows = text.at("%work", text.new(f"mul i64 %n, {K}"))
    terms = _Terms(plan, text, text.div("%h", scale), invariant)
    series = Composed(plan, order + 1, text, width, invariant, rows, "%n", scale, terms)
    y = {i: text.load(text.at(rows, i)) for i in series.used}
    series.begin("%t", y)
    series.emit()
    text.put(f"ret i64 {terms.n_terms(order + 1)}")
    return text.listing(declared, text.function(f"i64 @{symbol}(ptr %words)", "%words"))
