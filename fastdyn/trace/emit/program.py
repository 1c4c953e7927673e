"""The rows and single nodes that results need; many nodes of one form become the numbers of rows.

A function that loops over components makes single nodes.  Two nodes have one form if they apply
equal operations to numbers of equal arrays.
"""

import functools
from bisect import bisect_right

import numpy as np

from ..graph.clock import EVERY, look
from ..graph.expressions import Node, alternatives
from ..graph.refusal import Refusal
from ..graph.rows import ID, Owners, Row
from ..operations import OPERATIONS
from ..operations.delays import PASTS
from ..operations.linear import EQUATIONS

FEWEST_CALLS, FEWEST_NODES = 64, 400  # more are faster in loops than as straight-line code
MOST_SINGLY = 2000  # numbers of a copy that are computed one by one
FEWEST = 8  # nodes of one form become a row, and so many nodes that one operand reads are packed
ALONE = EQUATIONS | PASTS | {"t", "par"}  # nodes that stay what they are
COMMUTE = frozenset(("add", "mul", "eq", "and", "or"))


def worth_loops(nodes):
    """Whether loops are faster than straight-line code for so many nodes."""
    return len(nodes) > FEWEST_NODES or calls_of(nodes) > FEWEST_CALLS


def calls_of(nodes):
    """The number of elementary functions, which are calls in straight-line code."""
    return sum([OPERATIONS[n.op].elementary for n in nodes])


def cost_of(nodes):
    """The processor time of nodes as straight-line code, in additions."""
    return sum([OPERATIONS[n.op].cost for n in nodes if n.args])


class Program(Owners):
    """The numbers that results depend on.

    Parameters
    ----------
    g : Rows
    outputs : array of int
        The ids of the results.
    raising : Node
        A further result: the truth value that tells whether the function raises.
    array_of : callable
        ``array_of(slot)`` is (array, place in the array) of a parameter, where the array is
        ("array", slots) or ("block", words); None if the parameter lies in no array of doubles.

    Attributes
    ----------
    order : list of Row
        The rows, operands first.
    nodes : list of Node
        The single nodes, operands first.
    """

    def __init__(self, g, outputs, raising, array_of, settles=False):
        self.g = g
        self.outputs = outputs
        self.raising = raising
        self.rows = list(g.rows)
        self._ones = {}
        self._own = self._next = g.next + 2**20  # the graph may still make nodes
        self._singly()
        self._find(sides := alternatives(raising))
        if settles or worth_loops(self.nodes):
            _Settled(self, sides, array_of)
            self._find([self.raising])
        for row in self.order:
            if row.op in ("dense", "csr", "running"):
                self._replace(row, [self._in_memory(row.args[0])])
            else:
                self._replace(row, [self._packed(a) for a in row.args])
        self._find([self.raising])

    # -- ids

    def _singly(self):
        """Let components of past states be single nodes."""
        pasts = [k for k, row in enumerate(self.rows) if row.op in PASTS]
        if not pasts:
            return

        def singly(ids):
            owners = self.owners(np.asarray(ids))
            if not np.isin(owners, pasts).any():
                return ids
            if not isinstance(ids, np.ndarray):
                return self.g.node(ids).key
            found = ids.copy()
            found[np.isin(owners, pasts)] = [
                self.g.node(i).key for i in ids[np.isin(owners, pasts)].tolist()
            ]
            return found

        self.outputs = singly(self.outputs)
        for row in self.rows[:]:
            self._replace(row, [singly(a) for a in row.args])

    def node(self, i) -> Node:
        """The node of an id."""
        if i not in self._ones:
            own = i >= self._own  # operands have smaller keys than the nodes that use them
            self._ones[i] = Node("item", (), i, -1 - i) if own else self.g.node(i)
        return self._ones[i]

    # -- what is needed

    def _find(self, ends):
        self.below: dict = {}  # the operands of rows, by first ids
        nodes = {}
        order = []
        todo = [(end, False) for end in (*ends, *self._of_ids(self.outputs))]
        while todo:
            each, done = todo.pop()
            if done:
                order.append(each)
            elif isinstance(each, Row):
                if each.first not in self.below:
                    look()
                    found = {id(x): x for a in each.args for x in self._of_ids(a)}
                    self.below[each.first] = list(found.values())
                    todo += [(each, True), *[(x, False) for x in found.values()]]
            elif each.key not in nodes:
                nodes[each.key] = each
                todo += [(x, False) for x in each.args]
                if each.op == "item":
                    todo.append((self.row_at(each.data), False))
        self.order, self.nodes = order, [nodes[key] for key in sorted(nodes)]

    def is_truth(self, node):
        """Whether the value of a node is a truth value."""
        while node.op == "select":
            node = node.args[1]
        if node.op == "item":
            return self.row_at(node.data).truth
        return OPERATIONS[node.op].truth or (node.op == "const" and isinstance(node.data, bool))

    def _of_ids(self, ids):
        if not isinstance(ids, np.ndarray):
            return [self.node(ids)]
        rows, singles = self.parts(ids)
        return [*rows, *map(self.node, singles)]

    # -- new rows

    def new(self, op, args, data, size, truth=False):
        """A row that only this program has."""
        row = Row(op, args, data, (size,), self._next, truth, True)
        self._next += size + 1
        self.rows.append(row)
        return row

    def ids(self, row):
        return np.arange(row.first, row.first + row.size, dtype=ID)

    def _replace(self, row, args, op=""):
        if op or any(new is not old for new, old in zip(args, row.args, strict=True)):
            k = bisect_right(self.rows, row.first, key=lambda row: row.first) - 1
            self.rows[k] = Row(
                op or row.op, tuple(args), row.data, row.shape, row.first, row.truth, row.varies
            )

    def _in_memory(self, ids):
        """Ids of a row that lies in memory, in order."""
        row = self.row_at(int(ids[0]))
        if row is not None and row.op in ("y", "par", "block", "const") and not row.truth:
            if np.array_equal(ids, np.arange(ids[0], ids[0] + ids.size)):
                return ids
        return self.ids(self.new("copy", (self._packed(ids),), None, ids.size))

    def gather(self, first, ids):
        """Copy the numbers that an operand of a row reads into one new row, which has an order.

        Without a row, the results become a row.  A copy of a few numbers of many rows stays without
        order: it takes the numbers one by one.
        """
        truth = self.is_truth(self.node(int(ids[0])))
        if first is None:
            self.outputs = self.ids(self.new("copy", (ids,), None, ids.size, truth))
        else:
            row = self.row_at(first)
            every, place = np.unique(ids, return_inverse=True)
            packed = self._packed(every)
            if row.op == "copy" and packed is every and np.array_equal(every, ids):
                if ids.size > MOST_SINGLY:
                    raise Refusal("its arrays have too many edges", said=False)
                self._replace(row, [ids], "pack")
            else:
                found = self.ids(self.new("copy", (packed,), None, every.size, truth))[place]
                self._replace(row, [found if a is ids else a for a in row.args])
        self._find([self.raising])

    def _packed(self, ids):
        """Ids of an operand in which more than FEWEST single nodes are the numbers of a new row."""
        if not isinstance(ids, np.ndarray) or len(self.parts(ids)[1]) <= FEWEST:
            return ids
        single = self.owners(ids) < 0
        nodes, first, place = np.unique(ids[single], return_index=True, return_inverse=True)
        order = np.argsort(first)  # the nodes in the order in which they are read
        rank = np.empty_like(order)
        rank[order] = np.arange(order.size)
        truth = self.is_truth(self.node(int(nodes[0])))
        row = self.new("pack", (nodes[order].astype(ID),), None, nodes.size, truth)
        ids = ids.copy()
        ids[single] = row.first + rank[place]
        return ids


class _Settled:
    """Replaces the single nodes of a program by rows, where many nodes have one form."""

    def __init__(self, program, sides, array_of):
        self.program = program
        self.nodes = program.nodes
        self._by_key = {node.key: node for node in self.nodes}
        self._array_of = array_of
        self._arrays = {}
        self._moved = {}
        self._n_inputs = 1 + max([node.data for node in self.nodes if node.op == "y"], default=-1)
        self._label()
        self._choose(sorted(side.key for side in sides))
        for k in sorted(range(len(self.groups)), key=lambda k: self.depth[k]):
            look()
            self._settle(k, list(self.order[k]))
        self._rename()
        program.raising = self._any(sides)

    def _label(self):
        """Number the forms of the nodes."""
        forms: dict = {}
        self.form = {}
        self.args = {}
        self.leaf = {}
        self.depth = []
        self.groups = []
        for count, node in enumerate(self.nodes):
            if count % EVERY == 0:
                look()
            args = [a.key for a in node.args]
            if node.op in COMMUTE and self.form[args[1]] < self.form[args[0]]:
                args.reverse()
            leaf = self._leaf(node)
            label = node.op, repr(node.data), *[self.form[a] for a in args]
            k = forms.setdefault(label if leaf is None else ("leaf", leaf[0]), len(self.groups))
            if k == len(self.groups):
                self.groups.append([])
                self.depth.append(1 + max([self.depth[self.form[a]] for a in args], default=-1))
            self.groups[k].append(node.key)
            self.form[node.key] = k
            self.args[node.key] = args
            self.leaf[node.key] = leaf

    def _leaf(self, node):
        """(array, place in the array) of a leaf; None for the result of an operation."""
        if node.op == "const":
            return ("const", type(node.data)), None
        row = self.program.row_at(node.data if node.op == "item" else node.key)
        if row is not None:
            return ("row", row.first), node.data if node.op == "item" else node.key
        if node.op == "entry":
            return ("entries", node.args[0].key), node.data
        if node.op == "y":  # behind the state of the function that was traced
            return ("y", self._n_inputs), node.data
        return self._array_of(node.data) if node.op == "par" else None

    def _choose(self, sides):
        """Choose the forms that become rows, and sort their nodes in the order of reading.

        These are forms of many nodes, and forms of which an operand of a row reads several nodes.
        """
        program = self.program
        self.in_rows = [
            len(keys) >= FEWEST and self._by_key[keys[0]].op not in ALONE for keys in self.groups
        ]
        ends, self.order = [], [{} for _ in self.groups]  # dicts serve as ordered sets
        for ids in [a for row in program.order for a in row.args] + [program.outputs]:
            if isinstance(ids, np.ndarray) and program.parts(ids)[1]:
                keys = [i for i in ids.tolist() if i in self.form]
                ends += keys
                if ids is not program.outputs:
                    self._mark([i for i in keys if self.leaf[i] is None])
        for key in ends + sides:
            self.order[self.form[key]][key] = None
        for k in sorted(range(len(self.depth)), key=lambda k: -self.depth[k]):
            for column in np.array([self.args[key] for key in self.order[k]]).T.tolist():
                if self.in_rows[k]:
                    self._mark(column)
                for key in column:
                    self.order[self.form[key]][key] = None

    def _mark(self, keys):
        first: dict = {}
        for key in keys:
            known = first.setdefault(self.form[key], key)
            if known != key and self._by_key[key].op not in ALONE:
                self.in_rows[self.form[key]] = True

    def _settle(self, k, keys):
        """Give ids in rows to the nodes of one form, whose operands have ids."""
        if not keys:
            return
        program = self.program
        node = self._by_key[keys[0]]
        leaf = self.leaf[keys[0]]
        if leaf is not None:
            if leaf[0][0] != "const":
                first = self._first_of(*leaf[0])
                self._moved.update({key: first + self.leaf[key][1] for key in keys})
        elif self.in_rows[k]:
            columns = zip(*[self.args[key] for key in keys], strict=True)
            args = tuple([self._operand(column) for column in columns])
            row = program.new(node.op, args, node.data, len(keys), program.is_truth(node))
            self._moved.update(zip(keys, range(row.first, row.first + row.size), strict=True))

    def _first_of(self, kind, data):
        if kind == "row":
            return 0
        if kind == "entries" and (kind, data) not in self._arrays:
            self._arrays[kind, data] = self._entries(self._by_key[data])
        if (kind, data) not in self._arrays:
            size = data if kind in ("block", "y") else len(data)
            op = "par" if kind == "array" else kind
            self._arrays[kind, data] = self.program.new(op, (), data, size)
        return self._arrays[kind, data].first

    def _entries(self, solution):
        """A row with all numbers of a solution."""
        g = self.program.g
        n = len(solution.args) - 1
        ids = np.array([g.make("entry", (solution,), i).key for i in range(n)], ID)
        return self.program.new("pack", (ids,), None, n)

    def _operand(self, column):
        """An operand of a row: the id of one node, or an array of ids."""
        first = self._by_key[column[0]]
        if all(key == column[0] for key in column):
            return column[0]
        if first.op != "const":
            return np.array([self._moved.get(key, key) for key in column], ID)
        values = np.array([self._by_key[key].data for key in column], float)
        truth = isinstance(first.data, bool)
        return self.program.ids(self.program.new("const", (), values, values.size, truth))

    def _rename(self):
        """Put the new ids into the operands of rows, the results and the remaining nodes."""
        program = self.program
        moved = self._moved
        for row in program.order:
            program._replace(row, [self._renamed(a) for a in row.args])
        program.outputs = self._renamed(program.outputs)
        for node in self.nodes:
            if node.key in moved and self.leaf[node.key] is None:
                program._ones[node.key] = program.node(moved[node.key])
            elif node.op == "factors" and len(node.args) > 1:
                program._ones[node.key] = self._in_a_row(node)
            elif node.args:
                args = tuple([program._ones.get(a.key, a) for a in node.args])
                program._ones[node.key] = Node(node.op, args, node.data, node.key)
                program._ones[node.key].varies = node.varies

    def _in_a_row(self, node):
        """A node "factors" whose matrix lies in memory: it has the first element as operand."""
        ids = np.array([self._moved.get(a.key, a.key) for a in node.args], ID)
        row = self.program.new("copy", (ids,), None, ids.size)
        return Node(node.op, (self.program.node(row.first),), node.data, node.key)

    def _renamed(self, ids):
        if not isinstance(ids, np.ndarray) or not self.program.parts(ids)[1]:
            return ids
        ids = ids.copy()
        for k, i in enumerate(ids.tolist()):
            ids[k] = self._moved.get(i, i)
        return ids

    def _any(self, sides):
        """The disjunction of `sides`; of many, it is the maximum of a row."""
        program = self.program
        keys = [self._moved.get(side.key, side.key) for side in sides]
        if len(keys) >= FEWEST:
            most = program.new("top", (np.sort(np.array(keys, ID)),), len(keys), 1)
            return self._node("lt", program.g.const(0.0), program.node(most.first))
        return functools.reduce(lambda a, b: self._node("or", a, b), map(program.node, keys))

    def _node(self, op, *args):
        self.program._next += 2  # a key, and a gap between rows
        return Node(op, args, None, self.program._next - 2)
