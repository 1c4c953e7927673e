"""Groups single nodes by formula.

Two nodes have one formula if they apply equal operations to elements of equal arrays.
"""

import numpy as np

from ...graph.clock import EVERY, look

COMMUTE = frozenset(("add", "mul", "eq", "and", "or"))
ALONE = frozenset(("t", "par", "island"))
FEWEST = 8  # from so many nodes on, a formula becomes a batch, even if no batch reads the nodes


class Formulas:
    """The formulas of the single nodes that results need.

    Parameters
    ----------
    needed : Needed
    array_of : callable
        See `Settled`.

    Attributes
    ----------
    nodes : list of Node
        Nodes are numbered by their places in this list.
    at : dict
        The numbers of nodes, by their keys.
    args : list of list of int
        The operands of each node.
    leaf : list
        (array, place in the array) of each leaf; None for the result of an operation.
    depth : list of int
        The length of the longest chain of operations that ends at a node.
    formula : list of int
        The number of the formula of each node.
    groups : list of list of int
        The nodes of each formula, in the order in which they are read.
    are_batches : list of bool
        Whether the nodes of a formula become a batch.
    ordered : set of int
        The formulas whose nodes are stored in the order of their group.
    rank : dict
        The depths of the batches of the table, by their numbers.
    """

    def __init__(self, needed, array_of):
        self.needed, self.nodes, self.table = needed, needed.nodes, needed.table
        self._array_of = array_of
        self.at = {node.key: i for i, node in enumerate(self.nodes)}
        self._label()
        self._order([self.at[node.key] for node in needed.sides])

    def _label(self):
        """Number the formulas, and list the nodes of each formula in `groups`."""
        n, formulas = len(self.nodes), {}
        self.groups: list[list[int]] = []
        self.args: list = [()] * n
        self.leaf: list = [None] * n  # (array, place)
        self.depth, self.formula = [0] * n, [0] * n
        self.rank: dict = {}  # depths by batch
        steps = [(b.at, 0, b.number) for b in self.needed.batches]
        steps += [(node.key, 1, i) for i, node in enumerate(self.nodes)]
        for count, (_, single, i) in enumerate(sorted(steps)):  # in the order of creation
            if count % EVERY == 0:
                look()
            if not single:
                self.rank[i] = self._rank_of(self.table.batches[i])
                continue
            node = self.nodes[i]
            args = [self.at[a.key] for a in node.args]
            if node.op in COMMUTE and self.formula[args[1]] < self.formula[args[0]]:
                args.reverse()
            self.leaf[i] = leaf = self._leaf_of(node)
            label = (node.op, repr(node.data), *[self.formula[a] for a in args])
            if leaf is not None:
                label = ("leaf", leaf[0])
            number = formulas.setdefault(label, len(self.groups))
            if number == len(self.groups):
                self.groups.append([])
            self.groups[number].append(i)
            self.formula[i], self.args[i] = number, args
            below = [self.depth[a] for a in args]
            if node.op == "item":
                below = [self.rank[self.table.batch_of(node.data).number]]
            self.depth[i] = 1 + max(below, default=-1)

    def _rank_of(self, batch):
        if batch.op == "one":
            return self.depth[self.at[batch.data.key]]
        return 1 + max([self.rank[b.number] for b in self.needed.read_by(batch)], default=-1)

    def _leaf_of(self, node):
        """(array, place in the array) of a leaf; None for the result of an operation."""
        if node.op == "item":
            batch = self.table.batch_of(node.data)
            return ("batch", batch), node.data - batch.first
        if node.op == "par":
            return self._array_of(node.data)
        if node.op == "entry":
            return ("island", node.args[0].key), node.data
        if node.op == "const":
            return ("const", isinstance(node.data, bool)), node.data
        return (("y", None), node.data) if node.op == "y" else None

    def _order(self, sides):
        """Mark the formulas that become batches, and sort their nodes in the order of reading.

        A formula becomes a batch if it has many nodes, or if a batch reads several of its nodes.
        """
        self.are_batches = [
            len(m) >= FEWEST and self.nodes[m[0]].op not in ALONE for m in self.groups
        ]
        ones = {b.first: self.at[b.data.key] for b in self.needed.batches if b.op == "one"}
        outputs = self.needed.outputs
        ends = [self.at[node.key] for node in outputs] if self.needed.single else []
        order: list = [{} for _ in self.groups]  # dicts serve as ordered sets
        read = [] if self.needed.single else [outputs]
        read += [o for b in self.needed.batches for o in b.operands if not isinstance(o, int)]
        for ids in read if ones else ():
            found = ids.ravel()[np.isin(ids.ravel(), list(ones))]
            members = [ones[i] for i in found.tolist()]
            self._mark(members)
            ends += members
        self._read(ends, order)
        self.ordered = {number for number, members in enumerate(order) if members}
        self._read(sides, order)
        self.groups = [list(members) for members in order]

    def _read(self, ends, order):
        """Append the nodes that `ends` depend on to the order of their formulas, deepest first."""
        for i in ends:
            order[self.formula[i]][i] = None
        depths = [self.depth[members[0]] for members in self.groups]
        for number in sorted(range(len(depths)), key=lambda number: -depths[number]):
            rows = np.array([self.args[i] for i in order[number]])
            for column in rows.T:
                if self.are_batches[number]:
                    self._mark(column)
                for i in column.tolist():
                    order[self.formula[i]][i] = None

    def _mark(self, members):
        """Mark each formula with several nodes among `members`, which one operand reads."""
        first: dict = {}
        for i in members:
            if first.setdefault(self.formula[i], i) != i:
                self.are_batches[self.formula[i]] = True
