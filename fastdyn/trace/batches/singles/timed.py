"""Elements of long arrays that depend on the time and on parameters alone, as nodes of the graph.

The search for switching times knows nodes of the graph.
"""

import numpy as np

from ....operations import OPERATIONS
from ...graph.expressions import live
from ...graph.refusal import Refusal
from ...switching.switches import OF_STATE

MOST = 1024  # elements; the search takes some 0.1 ms for each
TIMED, MIXED = "timed", "mixed"


def timed_nodes(table, plan, nodes):
    """The nodes of numbers that meet the state, single ones and elements of long arrays.

    `nodes` are the single results.  Beyond MOST elements, there are none for the arrays.
    """
    batches = [b for b in table.batches if b.number in plan.live]
    below = {b.number: _below(table, b) for b in batches}
    kinds: dict = {}
    for b in batches:
        kinds[b.number] = _kind(b, [kinds[i] for i in below[b.number]])
    singles = [b.data for b in batches if b.op == "one"]
    wanted = {p.batch.number for p in plan.out_pieces}
    wanted.update(i for b in batches if kinds[b.number] == MIXED for i in below[b.number])
    found = [
        b for b in batches if b.number in wanted and kinds[b.number] == TIMED and b.op != "one"
    ]
    elements: list = []
    if sum(b.size for b in found) <= MOST:
        known: dict = {}
        try:
            elements = [_node(table, b, i, known) for b in found for i in range(b.size)]
        except Refusal:  # the graph is too large
            elements = []
    return [*nodes, *singles, *elements]


def _below(table, batch):
    """The numbers of the batches of a batch's operands."""
    found = set()
    for operand in batch.operands:
        if isinstance(operand, int):
            found.add(operand)
        else:
            firsts = np.array([b.first for b in table.batches])
            found.update((np.searchsorted(firsts, np.unique(operand), "right") - 1).tolist())
    return found


def _kind(batch, below):
    if batch.op == "one":
        ops = {node.op for node in live([batch.data])}
        return MIXED if ops & OF_STATE else TIMED if "t" in ops else None
    if MIXED in below or batch.op in OF_STATE or (TIMED in below and batch.op not in OPERATIONS):
        return MIXED
    return TIMED if TIMED in below else None


def _node(table, batch, i, known):
    """The node of element i of a batch of known operations."""
    place = batch.number, i
    if place not in known:
        g = table.g
        if batch.op == "one":
            return batch.data
        if batch.op == "par":
            return g.make("par", (), batch.data.start + i)
        below = []
        for operand in batch.operands:
            if isinstance(operand, int):
                below.append((table.batches[operand], i))
            else:
                number = int(operand if operand.ndim == 0 else operand[i])
                one = table.batch_of(number)
                below.append((one, number - one.first))
        args = [_node(table, one, at, known) for one, at in below]
        known[place] = g.make(batch.op, args, batch.data)
    return known[place]
