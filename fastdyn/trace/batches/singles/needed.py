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
        A further truth value that is needed, most often whether one of many conditions holds.
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
        """The batches that the operands of a batch are in."""
        found = []
        for operand in batch.operands:
            is_number = isinstance(operand, int)
            found += [self.table.batches[operand]] if is_number else self.batches_of(operand)
        return found


def alternatives(node):
    """The nodes whose disjunction a truth value is."""
    found, todo = {}, [node]
    while todo:
        each = todo.pop()
        if each.op == "or":
            todo += each.args
        else:
            found[each.key] = each
    return list(found.values())
