"""The coefficients of order 0: values at the start of a step, and values kept for higher orders."""

from ..recurrences.operations import Integral
from ..text.instructions import ONE, ZERO, hexadecimal

MAX_ROOT = 6.0  # up to this exponent, a half-integer power is products and a square root
TINY = 1e-300  # size that replaces a zero argument of atan2; its sign is from `sides`
SIGNS = {"lt": "olt", "le": "ole", "eq": "oeq"}


class Start:
    """Emits order 0 of a plan.

    Parameters
    ----------
    plan : Plan
    text : Text
    invariant : callable
        ``invariant(node)`` returns the value of an invariant.
    known : dict
        Values by the keys of nodes: at first of state and time; `emit` adds the other values.
    sides : dict
        By the key of a watched node that is zero, its sign just behind the start of the step.

    Attributes
    ----------
    kept : dict
        By the key of a step, the values that its higher orders need.
    """

    def __init__(self, plan, text, invariant, known, sides):
        self.plan = plan
        self.text = text
        self.invariant = invariant
        self.value = known
        self.sides = sides
        self.kept = {}
        self._truth = {}

    def emit(self):
        """Emit the values of all steps."""
        for step in self.plan.steps:
            self.value[step.node.key] = self.take(step)
        for step in self.plan.steps:
            if isinstance(step, Integral):
                self.kept[step.node.key] = self.slopes(step)

    def take(self, step):
        """The value of a step."""
        return getattr(self, f"_{type(step).__name__.lower()}")(step)

    def slopes(self, step):
        """The derivatives of a function by its arguments."""
        return [
            self.text.mul(self.invariant(f), ONE if g is None else self.of(g))
            for f, _, g in step.parts
        ]

    def of(self, node):
        return self.value[node.key] if node.key in self.value else self.invariant(node)

    def _sum(self, step):
        t = self.text
        total = step.constant and self.invariant(step.constant)
        for f, a in step.terms:
            total = t.fma(self.invariant(f), self.of(a), total)
        kept = []
        for f, a, b in step.products:
            fa = t.mul(self.invariant(f), self.of(a))
            total = t.fma(fa, self.of(b), total)
            kept += [t.add(fa, fa)] if a is b else [fa, t.mul(self.invariant(f), self.of(b))]
        self.kept[step.node.key] = kept
        return total

    def _quotient(self, step):
        t = self.text
        b = self.of(step.b)
        inverse = t.div(ONE, b)
        top = self.invariant(step.factor)
        c = t.div(top if step.a is None else t.mul(top, self.of(step.a)), b)
        self.kept[step.node.key] = t.mul(top, inverse), t.neg(t.mul(c, inverse)), t.neg(inverse)
        return c

    def _power(self, step):
        t = self.text
        a = self.of(step.a)
        inverse = t.div(ONE, a)
        c = t.mul(self.invariant(step.factor), self._powered(a, step.exponent))
        slope = t.mul(hexadecimal(step.exponent), inverse)
        self.kept[step.node.key] = inverse, t.mul(c, slope)
        return c

    def _powered(self, a, exponent):
        t = self.text
        if 2 * exponent != int(2 * exponent) or abs(exponent) > MAX_ROOT:
            if exponent == 1.0 / 3.0:
                return t.elementary("cbrt", a)
            return t.elementary("pow", a, hexadecimal(exponent))
        if exponent < 0:
            return t.div(ONE, self._powered(a, -exponent))
        result = None
        for _ in range(int(exponent)):
            result = a if result is None else t.mul(result, a)
        if exponent != int(exponent):
            root = t.intrinsic("sqrt", a)
            result = root if result is None else t.mul(result, root)
        return result

    def _root(self, step):
        t = self.text
        c = t.intrinsic("sqrt", self.of(step.a))
        half = t.div(hexadecimal(0.5), c)
        self.kept[step.node.key] = half, t.neg(half)
        return c

    def _integral(self, step):
        t = self.text
        args = [self.of(a) for a in step.arguments]
        if step.name == "atan2" and step.arguments[0].key in self.sides:
            side = t.mul(self.sides[step.arguments[0].key], hexadecimal(TINY))
            args[0] = t.select(t.compare("oeq", args[0], ZERO), side, args[0])
        return t.elementary(step.name, *args)

    def _choice(self, step):
        truth = self.truth(step.condition)
        self.kept[step.node.key] = truth
        a, b = (self.of(x) or ZERO for x in (step.a, step.b))
        return self.text.select(truth, a, b)

    def truth(self, node):
        """The truth of a condition at the start of the step."""
        if node.key not in self._truth:
            self._truth[node.key] = self._decided(node)
        return self._truth[node.key]

    def _decided(self, node):
        t = self.text
        if self.plan.rewrite.is_invariant(node):
            if node.op == "const":
                return "true" if node.data else "false"
            return t.compare("une", self.invariant(node), ZERO)
        if node.op in SIGNS:
            f, core = self.plan.switch[node.key]
            difference = self.invariant(f) if core is None else self.difference(f, core)
            return t.compare(SIGNS[node.op], difference, ZERO)
        args = [self.truth(a) for a in node.args]
        if node.op == "not":
            return t.truths("xor", args[0], "true")
        return t.truths(node.op, *args)

    def difference(self, f, core):
        """The difference of a comparison's sides; if zero, the sign just behind the start."""
        t = self.text
        f = self.invariant(f)
        value = t.mul(f, self.of(core))
        after = t.mul(f, self.sides[core.key])
        return t.select(t.compare("oeq", value, ZERO), after, value)


def shallow_first(plan, parts):
    """The parts, pairs (factor, node), in the order in which their nodes become known."""
    return sorted(parts, key=lambda part: plan.level.get(part[1].key, 0))
