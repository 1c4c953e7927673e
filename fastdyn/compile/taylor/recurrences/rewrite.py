"""A graph rewritten in operations with a recurrence: sums, products, quotients, powers, integrals.

Functions become integrals, c = integral of g da, where the derivative g is a node of the same
graph: sin and cos need each other, exp needs itself (A. Griewank and A. Walther, "Evaluating
Derivatives", second edition, SIAM 2008, section 13.2; A. Jorba and M. Zou, "A software package for
the numerical integration of ODEs by means of high-order Taylor methods", Experimental Mathematics
14 (2005), section 3).
"""

import math
import sys

from fastdyn.trace.graph.derivative_rules import LOCAL

from .known_sides import known_side

LARGEST = sys.float_info.max
MAX_WHOLE = 64
COMPARISONS = frozenset(("lt", "le", "eq"))


class NotSmooth(ValueError):
    """No Taylor series of the function was found."""

    def __init__(self, what):
        super().__init__(f"{what} has no Taylor series")


class Rewriter:
    """Rewrites nodes of a graph as nodes that have recurrences.

    The result has the operation "power" (`data`: the exponent) and the operations "const", "par",
    "t", "y", "add", "sub", "neg", "mul", "div", "sqrt", "select", conditions, and "call" of
    functions with `slopes`.  Invariants, which depend on neither state nor time, are not changed.
    With `pairs`, f(x) and f(-x) share a recurrence if f is even or odd.
    """

    def __init__(self, graph, pairs=False):
        self.graph, self._pairs = graph, pairs
        self._invariant, self._done = {}, {}

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
        g, op = self.graph, node.op
        if not args or self.is_invariant(node):
            return node
        if op == "sub" and args[0].key > args[1].key:
            return g.neg(g.sub(args[1], args[0]))  # x[i] - x[j] and x[j] - x[i] share a recurrence
        if op in ("add", "sub", "neg", "select"):
            return getattr(g, op)(*args)
        if op == "mul":
            return self._product(*args)
        if op == "div":
            return self._quotient(*args)
        if op == "sqrt" and args[0].op == "mul" and args[0].args[0] is args[0].args[1]:
            return self._size(args[0].args[0])
        if op in ("sqrt", "power"):
            return self.power(args[0], 0.5 if op == "sqrt" else node.data)
        if op == "abs":
            return self._size(args[0])
        if op in COMPARISONS:
            return self._comparison(op, *zip(node.args, args, strict=True))
        if op in ("and", "or"):
            return g.both(*args, op)
        if op == "not":
            return g.negation(args[0])
        if op == "call":
            return self._function(node.data, *args)
        raise NotSmooth(NAMES.get(op, f"`{node.data or op}`"))

    def _size(self, x):
        g = self.graph
        return g.select(g.compare(x, g.const(0.0), "lt"), g.neg(x), x)

    def _comparison(self, op, left, right):
        """A comparison of finite numbers; two comparisons if |x| is compared with a constant.

        `left` and `right` are (original node, rewritten node).
        """
        g, (a, b) = self.graph, (left[1], right[1])
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
        return g.compare(a, b, op)

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
        parts = known_side(self, base) if exponent % 1.0 else None
        if parts is not None:
            condition, *sides = parts
            return self.graph.select(condition, *[self.power(side, exponent) for side in sides])
        if exponent == 0.5:
            return self.graph.make("sqrt", (base,))
        if exponent == int(exponent) and 0.0 < exponent <= MAX_WHOLE:
            return self.graph.whole_power(base, int(exponent))  # also where the base is zero
        if self.is_invariant(base):
            return self.graph.make("call", (base, self.graph.const(float(exponent))), "pow")
        return self.graph.make("power", (base,), float(exponent))

    def _product(self, a, b):
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

    def _function(self, name, *args):
        g, constant = self.graph, self.graph.const
        if name == "pow":
            base, exponent = args
            if self.is_invariant(exponent):
                if exponent.op == "const":
                    return self.power(base, exponent.data)
                return g.make("call", args, "pow")
            return self._function("exp", self._product(exponent, self._logarithm(base)))
        if name == "exp2":
            return self._function("exp", g.mul(constant(math.log(2.0)), args[0]))
        if name in ("log2", "log10"):
            scale = 1.0 / math.log(float(name[3:]))
            return g.mul(constant(scale), self._logarithm(args[0]))
        if name == "cbrt":
            return self.power(args[0], 1.0 / 3.0)
        if name not in SLOPES and name not in BY_RULE and name != "atan2":
            raise NotSmooth(f"`{name}`")
        if self._pairs and args[0].op == "neg" and name in EVEN | ODD:
            found = g.make("call", args[0].args, name)
            return g.neg(found) if name in ODD else found
        return g.make("call", args, name)

    def _logarithm(self, base):
        return self.graph.make("call", (base,), "log")

    def slopes(self, node):
        """The derivatives of a function by its arguments, [(argument, node)]."""
        g = self.graph
        if node.data == "pow":  # the exponent is an invariant
            base, exponent = node.args
            return [(base, self._quotient(g.mul(exponent, node), base))]
        if node.data == "atan2":
            y, x = node.args
            square = g.add(g.mul(x, x), g.mul(y, y))
            return [(y, g.div(x, square)), (x, g.neg(g.div(y, square)))]
        (a,) = node.args
        if node.data in BY_RULE:
            ((slope, _),) = LOCAL[node.data](g, node, None)
        else:
            slope = SLOPES[node.data](g, a, node, g.const(1.0))
        return [(a, self(slope))]


def _root(g, x):
    return g.make("sqrt", (x,))


# Functions of one number; their derivatives are from SLOPES, else from `derivative_rules.py`.
BY_RULE = frozenset((
    "exp", "log", "log1p", "sin", "cos", "tan", "sinh", "cosh", "atan", "asinh", "erf", "erfc",
))  # fmt: skip
EVEN = frozenset(("cos", "cosh"))
ODD = frozenset(("sin", "tan", "sinh", "tanh", "atan", "asin", "asinh", "atanh", "erf"))
SLOPES = {  # shorter derivatives of c = f(a), from the nodes of a, c and 1
    "expm1": lambda g, a, c, one: g.add(c, one),
    "tanh": lambda g, a, c, one: g.sub(one, g.mul(c, c)),
    "asin": lambda g, a, c, one: g.div(one, _root(g, g.sub(one, g.mul(a, a)))),
    "acos": lambda g, a, c, one: g.neg(g.div(one, _root(g, g.sub(one, g.mul(a, a))))),
    "acosh": lambda g, a, c, one: g.div(one, _root(g, g.sub(g.mul(a, a), one))),
    "atanh": lambda g, a, c, one: g.div(one, g.sub(one, g.mul(a, a))),
}
NAMES = {
    "round": "rounding to a whole number",
    "table": "a table that is read at a place that moves",
    "search": "a search in a table",
    "piecewise": "a spline",
    "interpolate": "interpolation in a table",
    "in c": "a special function of SciPy",
}


def _with_args(node, known):
    """A node and all nodes below, arguments first, without the known nodes."""
    order, todo = [], [(node, False)]
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
