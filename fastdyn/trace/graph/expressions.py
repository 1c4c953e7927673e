"""Expressions of real numbers as a graph without common subexpressions.

Operations keep their order and IEEE meaning.  A rewrite keeps the bits, except that powers become
products and square roots.
"""

import hashlib
from typing import Any

import numpy as np

from ..operations import OPERATIONS
from ..operations.value import by_rule
from .clock import EVERY, look
from .refusal import Refusal
from .values import Values, contents, ranges_of

MAX_NODES = 60000
LARGEST_WHOLE = 2**20  # largest whole number that is a parameter
MAX_EXPONENT = 16  # largest exponent of a power that becomes a product


class Node:
    """One operation on the nodes `args`; `data` holds constants of the operation.

    `varies` is False if parameters alone determine the node; `value` is then its value.
    """

    __slots__ = ("args", "data", "key", "op", "value", "varies")

    def __init__(self, op, args, data, key):
        self.op = op
        self.args = args
        self.data = data
        self.key = key
        self.varies = True
        self.value = None


class Graph:
    """All nodes of one trace.

    Leaves are "t", "y" (`data`: index), "par" (slot), "const" (value); with batches, "item", "arg".
    """

    def __init__(self):
        self._known, self.nodes, self.next = {}, {}, 0  # nodes by key; the next free key
        self.values = Values()
        self.tables = {}
        self.batches: Any = None  # the graph itself if its long arrays are rows
        self.kept = {}  # values kept for later runs
        self.most = MAX_NODES
        self.varying: set[int] = set()  # slots whose values differ between trajectories
        self.true, self.false = self.make("const", (), True), self.make("const", (), False)

    def make(self, op, args=(), data=None):
        """The node of an operation; if all operands are constants, the constant result."""
        label = (type(data), repr(data)) if op == "const" else data  # -0.0 == 0.0, True == 1.0
        place = (op, tuple([a.key for a in args]), label)
        node = self._known.get(place)
        if node is None:
            if len(self.nodes) >= self.most:
                raise Refusal("it takes too many operations", said=False)
            node = self._known[place] = Node(op, tuple(args), data, self.key_of(op, data))
            self.nodes[node.key] = node
            if len(self.nodes) % EVERY == 0:
                look()
            self._evaluate(node)
        known = not node.varies and args and all(a.op == "const" for a in args)
        if known and not OPERATIONS[op].inner:
            if not ranges_of(node, self.tables):
                return self.const(node.value)
        return node

    def key_of(self, op, data):
        """The key of a new node."""
        self.next += 1
        return self.next - 1

    def _evaluate(self, node):
        if node.op == "const":
            node.varies, node.value = False, node.data
        elif node.op == "par":
            node.varies = node.data in self.varying
            node.value = self.values[node.data]
        elif node.args and not any(a.varies for a in node.args):
            tables = ranges_of(node, self.tables)
            if any(slot in table for table in tables for slot in self.varying):
                return
            with np.errstate(all="ignore"):
                value = self.compute(node, [np.asarray(a.value)[()] for a in node.args])
            node.varies = False
            if not OPERATIONS[node.op].inner:
                value = bool(value) if isinstance(value, bool | np.bool_) else float(value)
            node.value = value

    def compute(self, node, args, values=None):
        """Compute a node from the values of the operands, which are numbers or arrays."""
        data = node.data
        operation = OPERATIONS[node.op]
        if operation.tables:
            data = contents(node, self.tables, self.values if values is None else values)
        return operation.value(*args) if data is None else operation.value(data, *args)

    def const(self, value):
        if isinstance(value, bool | np.bool_):
            return self.true if value else self.false
        return self.make("const", (), float(value))

    def table(self, numbers):
        """Store a table of constants; return the table's name."""
        content = np.ascontiguousarray(numbers, dtype=float)
        name = hashlib.sha256(content.tobytes()).hexdigest()[:24]
        self.tables[name] = content
        return name

    def call(self, name, *args, data=None):
        """An operation of `OPERATIONS`, simplified."""
        if name in SIMPLIFIED:
            return SIMPLIFIED[name](self, *args)
        formula = OPERATIONS[name].formula
        return by_rule(self, formula, *args) if formula else self.make(name, args, data)

    # -- arithmetic

    def neg(self, a):
        return a.args[0] if a.op == "neg" else self.make("neg", (a,))

    def add(self, a, b):
        for one, other in ((a, b), (b, a)):
            if is_zero(one) and not _maybe_negative_zero(other):
                return other
        if b.op == "neg":
            return self.sub(a, b.args[0])
        if a.op == "neg":
            return self.sub(b, a.args[0])
        return self.make("add", _sorted(a, b))

    def sub(self, a, b):
        if b.op == "neg":
            return self.add(a, b.args[0])
        return self.make("sub", (a, b))

    def mul(self, a, b):
        for one, other in ((a, b), (b, a)):
            if one.op == "const" and one.data in (1.0, -1.0):
                return other if one.data == 1.0 else self.neg(other)
        if a.op == "neg":
            return self.neg(self.mul(a.args[0], b))
        if b.op == "neg":
            return self.neg(self.mul(a, b.args[0]))
        for one, other in ((a, b), (b, a)):  # r r r = u r if r = sqrt(u)
            if one.op == "mul" and other.op == "sqrt" and one.args == (other, other):
                return self.mul(other.args[0], other)
        return self.make("mul", _sorted(a, b))

    def div(self, a, b):
        if b.op == "const" and b.data in (1.0, -1.0):
            return a if b.data == 1.0 else self.neg(a)
        if a.op == "neg":
            return self.neg(self.div(a.args[0], b))
        if b.op == "neg":
            return self.neg(self.div(a, b.args[0]))
        return self.make("div", (a, b))

    def power(self, a, e):
        """a ** e; small constant half-integer exponents become products and roots."""
        if isinstance(e, Node) and e.op != "const":
            return self.make("pow", (a, e))
        e = float(e.data if isinstance(e, Node) else e)
        if e != e or abs(e) > MAX_EXPONENT or 2 * e != int(2 * e):
            return self.make("pow", (a, self.const(e)))
        if e < 0:
            return self.div(self.const(1.0), self.power(a, -e))
        whole = int(e)
        result = self.whole_power(a, whole)
        if whole != e:
            root = self.make("sqrt", (a,))
            result = root if whole == 0 else self.mul(result, root)
        return result

    def whole_power(self, a, k):
        """a ** k by repeated squaring, for a whole number k >= 0."""
        if a.op == "sqrt" and k > 1 and k % 2:  # sqrt(u) stays a factor: NaN for u < 0
            return self.mul(self.whole_power(a.args[0], k // 2), a)
        result = None
        square = a
        while k:
            if k & 1:
                result = square if result is None else self.mul(result, square)
            k >>= 1
            if k:
                square = self.mul(square, square)
        return self.const(1.0) if result is None else result

    def sum(self, terms):
        """Add up to 8 terms in order; add more terms in pairs first, which shortens the chain.

        Constant zeros are left out, because a zero could change only the sign of a zero sum.
        """
        terms = [term for term in terms if not is_zero(term)]
        while len(terms) > 8:
            pairs = zip(terms[::2], terms[1::2], strict=False)
            left = terms[-1:] if len(terms) % 2 else []
            terms = [self.add(a, b) for a, b in pairs] + left
        result = terms[0] if terms else self.const(0.0)
        for term in terms[1:]:
            result = self.add(result, term)
        return result

    # -- conditions

    def compare(self, a, b, sign):
        if sign in ("gt", "ge"):
            a, b, sign = b, a, {"gt": "lt", "ge": "le"}[sign]
        if sign == "ne":
            return self.negation(self.make("eq", _sorted(a, b)))
        return self.make(sign, _sorted(a, b) if sign == "eq" else (a, b))

    def negation(self, a):
        return a.args[0] if a.op == "not" else self.make("not", (a,))

    def both(self, a, b, op="and"):
        """The conjunction of two conditions; with ``op="or"``, the disjunction."""
        neutral, final = (self.true, self.false) if op == "and" else (self.false, self.true)
        for one, other in ((a, b), (b, a)):
            if one is final or one is other:
                return one
            if one is neutral:
                return other
        return self.make(op, _sorted(a, b))

    def select(self, condition, a, b):
        if condition is self.true or condition is self.false or a is b:
            return b if condition is self.false else a
        if condition.op == "not":
            condition, a, b = condition.args[0], b, a
        return self.make("select", (condition, a, b))


SIMPLIFIED: dict[str, Any] = {
    "neg": lambda g, a: g.neg(a), "select": lambda g, c, a, b: g.select(c, a, b),
    "add": lambda g, a, b: g.add(a, b), "sub": lambda g, a, b: g.sub(a, b),
    "mul": lambda g, a, b: g.mul(a, b), "div": lambda g, a, b: g.div(a, b),
    **{op: lambda g, a, b, op=op: g.compare(a, b, op) for op in ("lt", "le", "eq")},
    **{op: lambda g, a, b, op=op: g.both(a, b, op) for op in ("and", "or")},
    "not": Graph.negation, "pow": Graph.power,
}  # fmt: skip


def is_zero(node):
    return node.op == "const" and node.data == 0.0 and node.data is not False


def _maybe_negative_zero(node):
    """Whether a number may be -0.0, in which case 0.0 + x differs from x."""
    if node.op == "add":
        return all(map(_maybe_negative_zero, node.args))
    square = node.op == "mul" and node.args[0] is node.args[1]
    return not (square or node.op == "abs" or (node.op == "const" and node.data))


def _sorted(a, b):
    return (a, b) if a.key <= b.key else (b, a)


def live(outputs, known=()):
    """The nodes that the outputs depend on, in topological order, up to those of `known` keys."""
    found = {}
    todo = list(outputs)
    while todo:
        node = todo.pop()
        if node.key not in found and node.key not in known:
            found[node.key] = node
            todo += node.args
    return [found[key] for key in sorted(found)]


def alternatives(condition):
    """The conditions of a disjunction; the condition itself if it is no disjunction."""
    found = {}
    todo = [condition]
    while todo:
        each = todo.pop()
        if each.op == "or":
            todo += each.args
        else:
            found[each.key] = each
    return list(found.values())
