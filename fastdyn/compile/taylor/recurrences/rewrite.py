"""A graph rewritten in operations with a recurrence: sums, products, quotients, powers, integrals.

Functions become integrals, c = integral of g da, where the derivative g is a node of the same
graph: sin and cos need each other, exp needs itself (A. Griewank and A. Walther, "Evaluating
Derivatives", second edition, SIAM 2008, section 13.2; A. Jorba and M. Zou, "A software package for
the numerical integration of ODEs by means of high-order Taylor methods", Experimental Mathematics
14 (2005), section 3).
"""

from fastdyn.trace.operations import OPERATIONS
from fastdyn.trace.operations.domains import LARGEST
from fastdyn.trace.operations.value import by_rule

from .distances import without_root

MAX_WHOLE = 64


class NotSmooth(ValueError):
    """No Taylor series of the function was found."""

    def __init__(self, what):
        super().__init__(f"{what} has no Taylor series")


class Rewriter:
    """Rewrites nodes of a graph as nodes that have recurrences.

    The result has the operation "power" (`data`: the exponent) and the operations "const", "par",
    "t", "y", "add", "sub", "neg", "mul", "div", "sqrt", "select", conditions, and functions with
    `slopes`.  Invariants, which depend on neither state nor time, are not changed.
    If f is even or odd, f(x) and f(-x) share a recurrence: in a network of oscillators, sin(a - b)
    and sin(b - a).
    """

    def __init__(self, graph):
        self.graph = graph
        self.const = graph.const
        self._invariant = {}
        self._done = {}

    def is_invariant(self, node):
        """True if a node depends on neither the state nor the time."""
        known = self._invariant
        if node.key not in known:
            for each in _with_args(node, known):
                known[each.key] = each.op not in ("t", "y") and all(known[a.key] for a in each.args)
        return known[node.key]

    def __call__(self, node):
        done = self._done
        if node.key not in done:
            for each in _with_args(node, done):
                done[each.key] = self._of(each, [done[a.key] for a in each.args])
        return done[node.key]

    def _of(self, node, args):
        g = self.graph
        op = node.op
        operation = OPERATIONS[node.op]
        if not args or self.is_invariant(node):
            return node
        if op == "sub" and args[0].key > args[1].key:
            return g.neg(g.sub(args[1], args[0]))  # x[i] - x[j] and x[j] - x[i] share a recurrence
        if op in ("add", "sub", "neg", "select", "and", "or", "not"):
            return g.call(op, *args)
        if op == "mul":
            return self.mul(*args)
        if op == "div":
            return self._quotient(*args)
        if op == "sqrt" and args[0].op == "mul" and args[0].args[0] is args[0].args[1]:
            return self._size(args[0].args[0])
        if op in ("sqrt", "power"):
            return self.power(args[0], 0.5 if op == "sqrt" else node.data)
        if op == "abs":
            return self._size(args[0])
        if operation.sign and operation.truth:
            return self._comparison(op, *zip(node.args, args, strict=True))
        if operation.elementary:
            return self.call(op, *args)
        raise NotSmooth(operation.words or f"`{node.data or op}`")

    def _size(self, x):
        g = self.graph
        return g.select(g.compare(x, g.const(0.0), "lt"), g.neg(x), x)

    def _comparison(self, op, left, right):
        """A comparison of finite numbers; two comparisons if |x| is compared with a constant.

        `left` and `right` are (original node, rewritten node).
        """
        g = self.graph
        a, b = (left[1], right[1])
        if a is b:
            return g.const(op != "lt")
        for one, below in ((a, False), (b, True)):
            if one.op == "const" and abs(one.data) >= LARGEST:
                return g.const(op != "eq" and (one.data > 0) == below)
        if right[0].op == "abs" and a.op == "const" and a.data >= 0 and op != "eq":
            x = self._done[right[0].args[0].key]
            return g.both(g.compare(a, x, op), g.compare(x, g.neg(a), op), "or")
        if left[0].op == "abs" and b.op == "const" and b.data >= 0 and op != "eq":
            x = self._done[left[0].args[0].key]
            return g.both(g.compare(x, b, op), g.compare(g.neg(b), x, op))
        found = without_root(self, op, a, b)
        return g.compare(a, b, op) if found is None else found

    # -- powers

    def power_of(self, node):
        """(base, exponent) of a product of powers of one base."""
        if node.op == "sqrt":
            return node.args[0], 0.5
        if node.op == "power":
            return node.args[0], node.data
        if node.op == "mul":
            (a, m), (b, n) = map(self.power_of, node.args)
            if a is b:
                return a, m + n
        return node, 1.0

    def power(self, base, exponent):
        """A power of a node; a fractional power of a choice becomes a choice of powers."""
        parts = _known_side(self, base) if exponent % 1.0 else None
        if parts is not None:
            condition, *sides = parts
            return self.graph.select(condition, *[self.power(side, exponent) for side in sides])
        if exponent == 0.5:
            return self.graph.make("sqrt", (base,))
        if exponent == int(exponent) and 0.0 < exponent <= MAX_WHOLE:
            return self.graph.whole_power(base, int(exponent))  # also where the base is zero
        if self.is_invariant(base):
            return self.graph.call("pow", base, self.graph.const(float(exponent)))
        return self.graph.make("power", (base,), float(exponent))

    def mul(self, a, b):
        node = self.graph.mul(a, b)
        if node.op != "mul" or any(map(self.is_invariant, node.args)):
            return node
        base, exponent = self.power_of(node)
        return node if exponent == int(exponent) else self.power(base, exponent)

    def _quotient(self, a, b):
        g = self.graph
        if self.is_invariant(b):
            return g.div(a, b)
        base, exponent = self.power_of(b)
        if exponent == 1.0:
            return g.div(a, b)
        inverse = self.power(base, -exponent)
        return inverse if a.op == "const" and a.data == 1.0 else g.mul(a, inverse)

    # -- functions

    def call(self, name, *args, data=None):
        """A product or a function of rewritten nodes."""
        g = self.graph
        operation = OPERATIONS[name]
        if name == "pow" and self.is_invariant(args[1]):
            base, exponent = args
            if exponent.op == "const":
                return self.power(base, exponent.data)
            return g.call(name, *args)
        if name == "mul":
            return self.mul(*args)
        if operation.series:
            return by_rule(self, operation.series, *args)
        if not operation.recurrence:
            raise NotSmooth(operation.words or f"`{name}`")
        if args[0].op == "neg" and operation.parity:
            found = g.call(name, *args[0].args)
            return g.neg(found) if operation.parity == "odd" else found
        return g.call(name, *args)

    def slopes(self, node):
        """The derivatives of a function by its varying arguments, [(argument, node)]."""
        rules = OPERATIONS[node.op].slopes or OPERATIONS[node.op].factors
        return [
            (a, self(by_rule(self.graph, rule, node, *node.args)))
            for a, rule in zip(node.args, rules, strict=True) if not self.is_invariant(a)
        ]  # fmt: skip


def _with_args(node, known):
    """A node and all nodes below, arguments first, without the known nodes."""
    order = []
    todo = [(node, False)]
    seen = set()
    while todo:
        each, ready = todo.pop()
        if ready:
            order.append(each)
        elif each.key not in known and each.key not in seen:
            seen.add(each.key)
            todo.append((each, True))
            todo += [(a, False) for a in each.args]
    return order


def _known_side(rewrite, x):
    """(condition, side, side) of a choice with an invariant side, as max(y, 0); else None.

    The choice may be scaled and shifted by invariants.
    """
    if x.op == "select" and any(map(rewrite.is_invariant, x.args[1:])):
        return x.args
    if x.op not in ("add", "sub", "neg", "mul", "div"):
        return None
    varying = [i for i, arg in enumerate(x.args) if not rewrite.is_invariant(arg)]
    parts = _known_side(rewrite, x.args[varying[0]]) if len(varying) == 1 else None
    if parts is None:
        return None
    at = varying[0]
    combine = getattr(rewrite.graph, x.op)
    return parts[0], *[combine(*x.args[:at], side, *x.args[at + 1 :]) for side in parts[1:]]
