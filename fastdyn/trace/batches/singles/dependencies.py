"""The single nodes and the batches that results of a trace depend on."""

import numpy as np

from ..table import Batch


class Needed:
    """The single nodes and the batches that results depend on.

    Parameters
    ----------
    table : Table
    outputs : list of Node, or array of int
        Single nodes, or node numbers.
    condition : Node
        A truth value that is also needed, most often the disjunction of many conditions.
    """

    def __init__(self, table, outputs, condition):
        self.table, self.outputs = table, outputs
        self.sides = alternatives(condition)
        self._firsts = np.array([b.first for b in table.batches])
        self.single = isinstance(outputs, list)
        nodes, batches = {}, {}
        todo: list = list(self.sides)
        todo += outputs if self.single else self.batches_of(outputs)
        while todo:
            each = todo.pop()
            if isinstance(each, Batch):
                if each.number not in batches:
                    batches[each.number] = each
                    todo += [each.data] if each.op == "one" else self.read_by(each)
            elif each.key not in nodes:
                nodes[each.key] = each
                todo += each.args
                if each.op == "item":
                    todo.append(table.batch_of(each.data))
        self.nodes = [nodes[key] for key in sorted(nodes)]
        self.batches = [batches[number] for number in sorted(batches)]

    def batches_of(self, ids):
        """The batches that hold node numbers."""
        numbers = np.unique(np.searchsorted(self._firsts, ids, "right")) - 1
        return [self.table.batches[number] for number in numbers]

    def read_by(self, batch):
        """The batches that hold the operands of a batch."""
        found = []
        for operand in batch.operands:
            is_number = isinstance(operand, int)
            found += [self.table.batches[operand]] if is_number else self.batches_of(operand)
        return found


def alternatives(node):
    """The conditions of a disjunction; the node itself if the node is no disjunction."""
    found, todo = {}, [node]
    while todo:
        each = todo.pop()
        if each.op == "or":
            todo += each.args
        else:
            found[each.key] = each
    return list(found.values())
