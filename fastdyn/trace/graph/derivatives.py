"""Exact partial derivatives of a graph, as nodes of the same graph.

Forward accumulation: each node gets its derivatives with respect to the inputs that it depends on.
At a kink, the derivatives are one-sided.
"""

from typing import Any, NamedTuple

import numpy as np

from ..operations import OPERATIONS
from ..operations.delays import WEIGHT
from ..operations.domains import LARGEST
from ..operations.linear import EQUATIONS
from ..operations.value import Value, by_rule
from .equations import slopes
from .expressions import MAX_NODES, is_zero, live
from .refusal import Untraceable, refused_as
from .values import ranges_of

SUMS = frozenset(("add", "sub", "neg"))


def _too_many(reason):
    return Untraceable(f"its derivatives: {reason}", final=True)


class Entries(NamedTuple):
    """The derivatives other than the constant zero, sorted by column, then by row."""

    rows: np.ndarray
    columns: np.ndarray
    nodes: list


@refused_as(_too_many)
def jacobian(graph, outputs, n):
    """The Entries of d outputs / dy, with that of the past within the step of an implicit method.

    Raises
    ------
    Untraceable
        If an operation has no rule, or the derivatives need too many operations.
    """
    inputs = [graph.make("y", (), i) for i in range(n)]
    known = {node.key: {i: graph.const(1.0)} for i, node in enumerate(inputs)}

    def of_past(node):
        return {node.data: _weight(graph, node)}

    return entries(along_directions(graph, outputs, known, inputs, of_past))


@refused_as(_too_many)
def time_derivative(graph, outputs):
    """The nodes of d outputs / dt."""
    found = partials(graph, outputs, [graph.make("t")])
    return [row.get(0, graph.const(0.0)) for row in found]


@refused_as(_too_many)
def along(graph, outputs, velocities):
    """The nodes of the derivatives of the outputs along a motion of the inputs.

    Parameters
    ----------
    velocities : list of (Node, Node)
        Each input that moves, and the rate of the input.
    """
    graph.most = len(graph.nodes) + 2 * MAX_NODES
    known = {node.key: {0: rate} for node, rate in velocities if not is_zero(rate)}
    found = _Sweep(graph, outputs, known, [node for node, _ in velocities]).found(outputs)
    return [row.get(0, graph.const(0.0)) for row in found]


def entries(found):
    """Convert the rows that `partials` returns to Entries."""
    places = sorted((j, i) for i, row in enumerate(found) for j in row)
    at = np.array(places, dtype=np.int64).reshape(-1, 2)
    return Entries(at[:, 1], at[:, 0], [found[i][j] for j, i in places])


def along_directions(graph, outputs, known, inputs, of_past):
    """The derivatives of each output along several directions, as dicts {direction: node}.

    Parameters
    ----------
    known : dict of str to dict
        By the keys of the `inputs` that move, their derivatives by direction.
    of_past : callable
        ``of_past(node)``, the derivatives {direction: node} of a component of a past state at a
        fixed time.
    """
    graph.most = len(graph.nodes) + 2 * MAX_NODES
    sweep = _Sweep(graph, outputs, known, inputs)
    sweep.of_past = of_past
    return sweep.found(outputs)


def partials(graph, outputs, inputs):
    """The derivatives of each output, as a dict {index of the input: node} without zeros.

    Parameters
    ----------
    graph : Graph
    outputs : list of Node
    inputs : list of Node
        Nodes "t", "y" or "par".
    """
    graph.most = len(graph.nodes) + 2 * MAX_NODES
    known = {node.key: {i: graph.const(1.0)} for i, node in enumerate(inputs)}
    return _Sweep(graph, outputs, known, inputs).found(outputs)


def factors(g, node, depends):
    """Yield the terms (factor, operand) of the differential of a node, without zeros.

    ``depends(operand)`` tells whether an operand varies.  Both directions use these terms.
    """
    for factor, source in _of_product(g, node, depends):
        if not is_zero(factor):
            yield factor, source


def read_entries(g, node, slots):
    """Yield (range of slots, entries) of the tables with parameters among `slots` in a node.

    The entries that the node reads are pairs of an index, a Value, and a derivative.
    """
    inside = OPERATIONS[node.op].inside
    if inside and any(not slots.keys().isdisjoint(r) for r in ranges_of(node, g.tables)):
        for name, entries in inside(*[Value(g, a) for a in (node, *node.args)]):
            table = g.tables[name]
            if isinstance(table, range) and not slots.keys().isdisjoint(table):
                yield table, entries


def inside_tables(g, table, read, slots):
    """Yield (slot, derivative) of the parameters among `slots` in a table: see `read_entries`."""
    for slot in slots:
        if slot in table:  # 1 there, 0 elsewhere, at the entries that are read
            unit = g.table(np.arange(len(table)) == table.index(slot))
            first, *others = [at.read("table", unit) * d for at, d in read]
            yield slot, sum(others, first).of


def is_point(condition):
    """Whether a condition may hold at a single point; ``x == x`` asks for NaN.

    It holds at more points where both sides have the same derivatives, as ``x == clip(x, 0, 1)``.
    """
    return condition.op == "eq" and condition.args[0] is not condition.args[1]


def _of_product(g, node, depends):
    if node.op != "mul":
        return _by_rules(g, node, depends)
    a, b = node.args
    if a is b:
        return [(g.mul(g.const(2.0), a), a)]
    for root, other in ((a, b), (b, a)):
        rest = _without(g, other, root) if root.op == "sqrt" else None
        if rest is not None:  # at u = 0, u sqrt(u) has a derivative, sqrt(u) none
            u = root.args[0]
            if other is u:
                return [(g.mul(g.const(1.5), root), u)]
            return [(root, other), (g.mul(g.const(0.5), rest), u)]
    return _by_rules(g, node, depends)


def _by_rules(g, node, depends):
    rules = OPERATIONS[node.op].factors
    if rules is None:
        raise Untraceable(f"the derivative of {node.op} is not known", final=True)
    for rule, source in zip(rules, node.args, strict=True):
        if depends(source):
            yield by_rule(g, rule, node, *node.args), source


class _Sweep:
    of_past: Any = None  # see `along_directions`

    def __init__(self, graph, outputs, known, inputs):
        self.graph, self.nodes, self.known = graph, live(outputs), known
        self.slots = {node.data: known.get(node.key, {}) for node in inputs if node.op == "par"}
        self._solutions: dict = {}  # the derivatives of solutions of equations
        self._inner = _inner_sums(self.nodes, outputs)

    def found(self, outputs):
        for node in self.nodes:
            if node.key not in self.known and node.key not in self._inner:
                self.known[node.key] = self._of(node)
        return [self.known[node.key] for node in outputs]

    def _of(self, node):
        if node.op in SUMS:
            return self._of_sum(node)
        if node.op == "select":
            return self._of_select(node)
        if node.op in EQUATIONS:
            return self._of_equations(node)
        g = self.graph
        operation = OPERATIONS[node.op]
        terms = {}
        if any(self.known[a.key] for a in node.args):
            if operation.root:
                return self._of_root(node)
            for factor, source in factors(self.graph, node, self._depends):
                for i, d in self.known[source.key].items():
                    terms.setdefault(i, []).append(g.mul(factor, d))
        for table, read in read_entries(g, node, self.slots):
            for slot, d in inside_tables(g, table, read, self.slots):
                for i, rate in self.slots[slot].items():
                    terms.setdefault(i, []).append(g.mul(d, rate))
        if node.op == "of_past" and self.of_past is not None:
            for i, d in self.of_past(node).items():
                terms.setdefault(i, []).append(d)
        return self._added(terms)

    def _depends(self, node):
        return bool(self.known[node.key])

    def _added(self, terms):
        sums = {i: self.graph.sum(each) for i, each in terms.items()}
        return {i: node for i, node in sums.items() if not is_zero(node)}

    def _of_sum(self, node):
        """Differentiate a tree of sums as one sum, so that `Graph.sum` adds the terms in pairs."""
        g = self.graph
        terms = {}
        todo = [(node, False)]
        while todo:
            each, minus = todo.pop()
            if each is node or each.key in self._inner:
                signs = {"add": (0, 0), "sub": (0, 1), "neg": (1,)}[each.op]
                found = [(a, minus != bool(s)) for a, s in zip(each.args, signs, strict=True)]
                todo += reversed(found)
                continue
            for i, d in self.known[each.key].items():
                terms.setdefault(i, []).append(g.neg(d) if minus else d)
        return self._added(terms)

    def _of_select(self, node):
        g = self.graph
        condition, *sides = node.args
        result = {}
        yes, no = (self.known[side.key] for side in sides)
        zero = g.const(0.0)
        largest = g.const(LARGEST)
        a, b = [self.known[a.key] for a in condition.args] if is_point(condition) else ({}, {})
        for i in dict.fromkeys((*yes, *no)):
            one = yes.get(i, zero)
            other = no.get(i, zero)
            chosen = condition
            if i in a or i in b:  # such as sin(x) / x, and 1 at x = 0
                infinite = g.negation(g.compare(g.make("abs", (other,)), largest, "le"))
                stays = g.compare(a.get(i, zero), b.get(i, zero), "eq")  # as x == clip(x, 0, 1)
                chosen = g.both(condition, g.both(infinite, stays, "or"))
            result[i] = g.select(chosen, one, other)
        return result

    def _of_equations(self, node):
        if node.op == "solution":
            self._solutions[node.key] = slopes(self.graph, node, lambda a: self.known[a.key])
        if node.op != "entry":  # no number that has derivatives
            return {}
        found = self._solutions[node.args[0].key]
        return {i: d[node.data] for i, d in found.items() if not is_zero(d[node.data])}

    def _of_root(self, node):
        """The derivatives of a root; 0 where the radicand has derivative 0, as ``|v|`` at v = 0."""
        g = self.graph
        result = {}
        ((factor, source),) = factors(g, node, self._depends)
        for i, d in self.known[source.key].items():
            still = g.compare(d, g.const(0.0), "eq")
            result[i] = g.select(still, g.const(0.0), g.mul(factor, d))
        return result


def _weight(g, node):
    """The weight of the present state in a component of the past, a node."""
    (past,) = node.args
    n, n_words, _ = past.data
    return g.make("of_slope", (g.make("past", past.args, (n, n_words, WEIGHT)),), 0)


def _without(g, product, root):
    """The quotient product / root, if the square of `root` is a factor of `product`; else None."""
    if product is root.args[0]:
        return root
    if product.op == "mul":
        for one, other in (product.args, product.args[::-1]):
            rest = _without(g, one, root)
            if rest is not None:
                return g.mul(rest, other)
    return None


def _inner_sums(nodes, outputs):
    """The sums whose only user is another sum."""
    users: dict = {}
    for node in nodes:
        for a in node.args:
            users.setdefault(a.key, []).append(node)
    ends = {node.key for node in outputs}
    return {
        node.key
        for node in nodes
        if node.op in SUMS and node.key not in ends
        and len(users[node.key]) == 1 and users[node.key][0].op in SUMS
    }  # fmt: skip
