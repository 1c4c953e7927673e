"""Reverse mode: the product of a row vector and the Jacobian, as nodes of the same graph.

The cotangent of a node is the sum, over the users of the node, of the user's cotangent times a
factor.  The factors are those of forward mode: each operation has one rule for both directions.
"""

from collections import defaultdict
from typing import Any, NamedTuple

from ..operations import OPERATIONS
from ..operations.domains import LARGEST
from ..operations.value import by_rule
from .derivatives import factors, inside_tables, is_point, read_entries
from .equations import shares
from .expressions import MAX_NODES, is_zero, live
from .refusal import Untraceable, refused_as


class Entry(NamedTuple):
    """The cotangent of the entry of a table at an index, which one read gives.

    `places` are the places of all entries of the table among the inputs.
    """

    places: range
    index: Any
    cotangent: Any


@refused_as(lambda reason: Untraceable(f"the product with its Jacobian: {reason}", final=True))
def pullback(graph, outputs, cotangents, inputs, entries=None):
    """For each input, the node of the sum of cotangents[i] d outputs[i] / d input.

    Below a selection a cotangent may be 0 because its branch is not taken; such a zero times an
    infinite factor is 0.  Below a root a cotangent may be infinite; times a factor of 0 it is 0, as
    in forward mode, so that |v| has derivative 0 at v = 0.

    Parameters
    ----------
    graph : Graph
    outputs, cotangents : list of Node
    inputs : list of Node
        Nodes "t", "y" or "par".
    entries : list, optional
        Gets the Entry of each read of a table of inputs, a part of the product that the sums then
        lack: a read has one or two; sums for all 2000 entries of a table took 50 times as long.

    Raises
    ------
    Untraceable
        If an operation has no rule, or the product needs too many operations.
    """
    graph.most = len(graph.nodes) + 4 * MAX_NODES
    return _Pull(graph, outputs, inputs, entries).of(outputs, cotangents)


class _Pull:
    """The pullback to some inputs.

    `wanted` has the keys of the nodes that depend on the inputs, `masked` those of the nodes below
    a selection, `steep` those below a root.
    """

    def __init__(self, graph, outputs, inputs, entries=None):
        self.graph, self.nodes, self.inputs = graph, live(outputs), inputs
        self.entries = entries
        self.leaves = {node.key for node in inputs}
        self.slots = {node.data: node for node in inputs if node.op == "par"}
        self.places = {node.data: k for k, node in enumerate(inputs) if node.op == "par"}
        self.wanted, self.masked, self.steep = set(self.leaves), set(), set()
        self._ends: Any = defaultdict(dict)  # of the numbers of solutions of equations
        for node in self.nodes:
            rules = OPERATIONS[node.op].factors
            varies = rules is None or any(rules)  # not all of them 0, as for a rounding
            inside = any(read_entries(graph, node, self.slots))
            if inside or (varies and any(a.key in self.wanted for a in node.args)):
                self.wanted.add(node.key)

    def of(self, outputs, cotangents):
        """The nodes of the product, for each input."""
        g = self.graph
        terms = defaultdict(list)
        for node, cotangent in zip(outputs, cotangents, strict=True):
            terms[node.key].append(cotangent)
        for node in reversed(self.nodes):
            if node.key not in self.wanted or node.key in self.leaves or node.key not in terms:
                continue
            own = g.sum(terms.pop(node.key))
            if is_zero(own):
                continue
            for operand, share in self._shares(node, own):
                if operand.key in self.wanted and not is_zero(share):
                    terms[operand.key].append(share)
                    self._pass_on(node, operand)
        return [g.sum(terms[each.key]) for each in self.inputs]

    def _pass_on(self, node, operand):
        """Note what a cotangent that goes from a node to an operand may be."""
        if node.key in self.masked or node.op == "select":
            self.masked.add(operand.key)
        if node.key in self.steep or OPERATIONS[node.op].root:
            self.steep.add(operand.key)

    def _shares(self, node, own):
        """Yield (operand, cotangent) of a node whose cotangent is `own`."""
        g = self.graph
        if node.op == "select":
            yield from self._of_select(node, own)
            return
        if node.op == "entry":  # the cotangents of a solution meet at the solution
            self._ends[node.args[0].key][node.data] = own
            yield node.args[0], g.const(1.0)
            return
        if node.op == "solution":
            yield from shares(g, node, self._ends[node.key], lambda a: a.key in self.wanted)
            return
        for factor, operand in factors(g, node, lambda a: a.key in self.wanted):
            yield operand, self._times(node, factor, own)
        for table, read in read_entries(g, node, self.slots):
            places = self._places(table)
            if self.entries is None or places is None:
                for slot, factor in inside_tables(g, table, read, self.slots):
                    yield self.slots[slot], self._times(node, factor, own)
                continue
            for at, d in read:
                share = self._times(node, by_rule(g, d), own)
                self.entries.append(Entry(places, at.of, share))

    def _places(self, table):
        """The places of a table's slots among the inputs as a range; None if they are no range."""
        if any(slot not in self.places for slot in table):
            return None
        found = [self.places[slot] for slot in table]
        step = found[-1] - found[-2] if len(found) > 1 else 1
        places = range(found[0], found[0] + step * len(found), step)
        return places if found == [*places] else None

    def _times(self, node, factor, own):
        """The product of a factor and a cotangent, 0 where one of them is a 0 that counts."""
        g = self.graph
        none = self.graph.false
        if node.key in self.masked and factor.op != "const":
            none = g.compare(own, g.const(0.0), "eq")
        if node.key in self.steep and factor.op != "const":
            none = g.both(none, g.compare(factor, g.const(0.0), "eq"), "or")
        return g.select(none, g.const(0.0), g.mul(factor, own))

    def _of_select(self, node, own):
        g = self.graph
        condition, yes, no = node.args
        zero = self.graph.const(0.0)
        chosen = condition
        at_a_point = is_point(condition) and any(a.key in self.wanted for a in condition.args)
        if at_a_point and {yes.key, no.key} & self.wanted:  # such as sin(x) / x, and 1 at x = 0
            more = g.both(self._infinite(no), self._stays(condition), "or")
            chosen = g.both(condition, more)
        yield yes, g.select(chosen, own, zero)
        yield no, g.select(chosen, zero, own)

    def _stays(self, condition):
        """Whether the sides of an equation have the same derivatives."""
        g = self.graph
        found = g.true
        a, b = condition.args
        for d in _Pull(g, [g.sub(a, b)], self.inputs).of([g.sub(a, b)], [g.const(1.0)]):
            found = g.both(found, g.compare(d, g.const(0.0), "eq"))
        return found

    def _infinite(self, node):
        """The condition that the derivative of a node by one of the inputs is not finite."""
        g = self.graph
        found = self.graph.false
        read = []
        sums = _Pull(g, [node], self.inputs, read).of([node], [g.const(1.0)])
        for d in [*sums, *(each.cotangent for each in read)]:
            finite = g.compare(g.make("abs", (d,)), g.const(LARGEST), "le")
            if not is_zero(d):
                found = g.both(found, g.negation(finite), "or")
        return found
