"""A trace as a function of the pointer form: its parameters in the block, its code on disk.

The key of the code is the graph itself, so that kept code is right for whatever has this graph.
"""

import hashlib

from fastdyn import code_store
from fastdyn.kernels.calls.block import MOST_DECISIONS
from fastdyn.trace.graph.clock import EVERY, look
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Refusal, refused_as
from fastdyn.trace.islands.island import calls_libraries

from ..parameters import FLOAT, INT, packer
from .python_form import PythonForm


class Traced(PythonForm):
    """A trace in a mode: what it stores, and where its parameters lie.

    Attributes
    ----------
    kinds : list
        Of the groups of parameters, in the order in which they lie in a block.
    stored : list of Node
        The numbers of the pointer form.
    decisions : list of Node
        Those of which the pointer form notes in its block what sides they take.
    at : tuple of int or None
        The group that an argument is.
    n_stored : int
    in_batches : bool
        Whether it is one of long arrays, a `TracedInBatches`.
    pack : callable
        ``pack(values, block, keepalive)`` writes the values of the groups into a block.
    """

    in_batches = False

    @refused_as(Refusal.untraceable)
    def __init__(self, trace, mode, n):
        g, self.trace, self.mode, self.n = trace.graph, trace, mode, n
        self.stored = trace.outputs
        if mode.second_order:
            self.stored = trace.outputs[n:]
        if mode.moments:
            own = [g.make("y", (), i) for i in range(len(trace.outputs))]
            rates = {"mean": own, "rms": [g.mul(y, y) for y in own]}
            self.stored = [*trace.outputs, *(r for moment in mode.moments for r in rates[moment])]
        self.n_stored = len(self.stored)
        self.decisions = _decisions(self) if mode.notes_sides else []
        self.kinds = [kind_of_group(group) for group in trace.reads.groups]
        self.at = trace.reads.of_arguments()
        self.pack = packer(self.kinds)

    def key(self):
        """Everything that the code depends on."""
        g, nodes = self.trace.graph, live([*self.stored, self.trace.raising])
        names = {node.key: i for i, node in enumerate(nodes)}
        lines = []
        for i, node in enumerate(nodes):
            if i % EVERY == 0:
                look()
            lines.append((node.op, [names[a.key] for a in node.args], node.data))
        ends = [names[node.key] for node in (*self.stored, self.trace.raising)]
        tables = sorted(name for name, table in g.tables.items() if isinstance(table, range))
        places = [(group.first, group.shape) for group in self.trace.reads.groups]
        text = repr((self.mode, self.n, lines, ends, tables, places, self.kinds))
        stores = " with stores" if g.stores else ""
        return f"traced {hashlib.sha256(text.encode()).hexdigest()}{stores}"

    # -- machine code, by modules that are imported when there is code to write

    def text(self, symbol):
        """LLVM's text of a module with the pointer form."""
        from .pointer_form import text

        return text(self, symbol)

    def series(self, order):
        """The kernel of the Taylor method of an order, or of the series of an event along a step.

        NotSmooth if there is none.
        """
        from ..taylor.recurrences.rewrite import NotSmooth
        from .series import text, text_of_event

        if calls_libraries(self.trace.graph):
            raise NotSmooth("a call of a library")
        text = text_of_event if self.mode.one_number else text
        key = f"series {order} {self.key()}"
        return code_store.assembled(key, lambda symbol: text(self, symbol, order), True)

    def lane_series(self, order, kinds, width):
        """The same kernel with a trajectory in each lane of a vector."""
        from ..taylor.recurrences.rewrite import NotSmooth
        from .lanes import text

        if calls_libraries(self.trace.graph):
            raise NotSmooth("a call of a library")
        key = f"series in lanes {order} {width} {kinds} {self.key()}"
        return code_store.assembled(
            key, lambda symbol: text(self, symbol, order, kinds, width), True
        )

    def dispatcher(self):
        """The pointer form for Numba, to be inlined into kernels."""
        from .inlined import dispatcher

        return dispatcher(self)

    def build_vector(self, kinds=None):
        """The function ``(t, y, words)`` on vectors: of numbers a tuple, of an event one.

        `kinds` are those of the parameters, where some differ from one trajectory to the next.
        """
        from .inlined import build_vector

        return build_vector(self, kinds)


def _decisions(traced):
    nodes = live([*traced.stored, traced.trace.raising])
    found = {node.args[0].key: node.args[0] for node in nodes if node.op == "select"}
    return list(found.values())[:MOST_DECISIONS]


def kind_of_group(group):
    """The kind of a group of parameters: arrays are passed in place, or copied."""
    if group.shape is not None:
        return ("array", group.dtype, len(group.shape))
    return INT if group.whole else FLOAT
