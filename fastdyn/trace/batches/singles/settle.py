"""Rebuilds a table such that the single nodes of one formula are the nodes of one batch.

A function that loops over components, or reads single components, makes single nodes.
"""

import functools
from collections import defaultdict

import numpy as np

from ....operations import OPERATIONS
from ...graph.clock import look
from ...graph.expressions import Node
from ..table import ID, Batch, Table
from .formulas import FEWEST, Formulas

NONE = -1  # stands for the node number of a node in no batch


class Settled:
    """A table in which single nodes of one formula are batches.

    Parameters
    ----------
    graph : Graph
    needed : Needed
    array_of : callable
        ``array_of(slot)`` is (array, place in the array) of a parameter, where the array is
        ("array", slots) or ("block", words); None if the parameter lies in no array of doubles.

    Attributes
    ----------
    table : Table
    condition : Node
        The truth value of `needed`, read from batches.
    """

    def __init__(self, graph, needed, array_of):
        self._needed, self._nodes, self._before = needed, needed.nodes, needed.table
        self._formulas = formulas = Formulas(needed, array_of)
        self._at, self._args, self._leaf = formulas.at, formulas.args, formulas.leaf
        self._formula = formulas.formula
        self.table = Table(graph, needed.table.state.size)
        self._ids = np.full(len(self._nodes), NONE, ID)
        self._alone: dict = {}  # nodes in no batch; they read operands from batches
        self._moved = np.full(needed.table.next, NONE, ID)  # new node numbers, by old numbers
        self._next = len(graph.nodes)
        steps = [(formulas.depth[members[0]], members) for members in formulas.groups]
        steps += [(formulas.rank[b.number], b) for b in needed.batches if b.op != "one"]
        for _, step in sorted(steps, key=lambda step: step[0]):
            look()
            self._move(step) if isinstance(step, Batch) else self._settle(step)
        self.condition = self._any([self._at[node.key] for node in needed.sides])

    def numbers(self):
        """The node numbers of the outputs."""
        if self._needed.single:
            ids = [self._number(self._at[node.key]) for node in self._needed.outputs]
            return np.array(ids, ID)
        return self._renumbered(self._needed.outputs)

    def alone(self):
        """The outputs as single nodes."""
        return [self._one(self._at[node.key]) for node in self._needed.outputs]

    # -- from nodes to batches

    def _settle(self, members):
        """Assign node numbers to the nodes of one formula, whose operands are settled."""
        i = members[0]
        first, leaf, formula = self._nodes[i], self._leaf[i], self._formula[i]
        if leaf is not None:
            if leaf[0][0] != "const":
                places = [self._leaf[i][1] for i in members]
                self._ids[members] = self._first_of(*leaf[0]) + np.array(places)
        elif first.op == "island":
            for i in members:
                self._ids[i] = self._call(self._nodes[i], self._args[i])
        elif self._formulas.are_batches[formula]:
            if formula not in self._formulas.ordered:
                members.sort(key=lambda i: self._ids[self._args[i]].tolist())
            rows = np.array([self._args[i] for i in members])
            operands = [self._operand(column) for column in rows.T]
            batch = self.table.make(
                first.op, first.data, (len(members),), operands, is_truth(first)
            )
            self._ids[members] = np.arange(batch.first, batch.first + batch.size)

    def _call(self, node, args):
        """Make the batch of a call of a library; return the node number of the first result."""
        given = np.array([self._number(a) for a in args], ID)
        copy = self.table.make("copy", None, given.shape, [given])
        shape = (node.data[2] + 1,)
        return self.table.make("island", ("island", *node.data), shape, [copy.number]).first

    def _first_of(self, kind, data):
        """The node number of the first element of an array."""
        if kind == "y":
            return 0
        if kind == "batch":
            return self._moved[data.first]
        if kind == "island":
            return self._ids[self._at[data]]
        if kind == "array":
            return self.table.of_slots(data).first
        return self.table.make("block", None, (data,), ()).first

    def _operand(self, column):
        """An operand of a batch: one node for all elements, or an array of node numbers."""
        node = self._nodes[column[0]]
        if (column == column[0]).all():
            return np.array(self._number(column[0]), ID)
        if node.op != "const":
            return self._ids[column]
        values = np.array([self._nodes[i].data for i in column], float)
        truth = isinstance(node.data, bool)
        constants = self.table.make("const", values.tobytes(), values.shape, (), truth)
        return np.arange(constants.first, constants.first + constants.size, dtype=ID)

    def _any(self, sides):
        """The disjunction of `sides`; conditions in batches are reduced to their maximum."""
        groups, found = defaultdict(list), []
        for i in sides:
            groups[self._formula[i] if self._ids[i] != NONE else ("alone", i)].append(i)
        for group in groups.values():
            if len(group) < FEWEST:
                found += [self._one(i) for i in group]
                continue
            most = self.table.make("top", len(group), (), [np.sort(self._ids[group])])
            none = self._new("const", (), 0.0)
            found.append(self._new("lt", (none, self._new("item", (), most.first)), None))
        return functools.reduce(lambda a, b: self._new("or", (a, b), None), found)

    def _move(self, batch):
        """Make the batch in the new table, from settled operands."""
        operands = []
        for operand in batch.operands:
            if isinstance(operand, int):
                first = self._moved[self._before.batches[operand].first]
                operands.append(self.table.batch_of(first).number)
            else:
                operands.append(self._renumbered(operand))
        made = self.table.make(batch.op, batch.data, batch.shape, operands, batch.truth)
        self._moved[batch.first : batch.first + batch.size] = np.arange(
            made.first, made.first + made.size
        )

    def _renumbered(self, ids):
        """The new node numbers for an array of old node numbers."""
        found = self._moved[ids]
        for i in np.unique(ids[found == NONE]).tolist():
            self._moved[i] = self._number(self._at[self._before.batch_of(i).data.key])
        return self._moved[ids]

    # -- nodes in no batch

    def _number(self, i):
        """The node number of a node, alone or in a batch."""
        return self.table.one(self._one(i)) if self._ids[i] == NONE else self._ids[i]

    def _one(self, i):
        """A single node equal to node i of the graph, with the operands read from batches.

        The method uses no recursion, because a chain of nodes may be longer than Python's stack.
        """
        todo = [i]
        while todo:
            each = todo[-1]
            args = self._nodes[each].args if self._ids[each] == NONE else ()
            missing = [a for a in [self._at[a.key] for a in args] if a not in self._alone]
            todo += missing
            if not missing:
                self._alone[todo.pop()] = self._made(each)
        return self._alone[i]

    def _made(self, i):
        node = self._nodes[i]
        if self._ids[i] != NONE:
            return node if node.op == "y" else self._new("item", (), int(self._ids[i]))
        args = tuple(self._alone[self._at[a.key]] for a in node.args)
        same = all(a is b for a, b in zip(args, node.args, strict=True))
        return node if same else self._new(node.op, args, node.data)

    def _new(self, op, args, data):
        self._next += 1
        return Node(op, args, data, self._next)


def is_truth(node):
    """Whether the value of a node is a truth value."""
    while node.op == "select":
        node = node.args[1]
    return OPERATIONS[node.op].truth or (node.op == "const" and isinstance(node.data, bool))
