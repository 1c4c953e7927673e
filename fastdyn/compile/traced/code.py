"""A trace as a compiled function: its parameters in a block, its code on disk.

The key of the code is a digest of the graph: kept code is valid for all functions with this graph.
"""

import functools
import hashlib
import math
import sys

from fastdyn import code_store
from fastdyn.trace.graph.clock import EVERY, look
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Refusal, refused_as
from fastdyn.trace.switching.switches import switches

from ..functions import Function
from ..parameters import FLOAT, n_words

# Beyond, "auto" takes a pair instead of Taylor.  Processor time of a first call by Taylor on a busy
# core: 20 oscillators, each coupled to each, 0.8 s (1600 operations); 1000 masses on springs 1.0 s
# (6000); 40 oscillators 1.6 s (6400); 20 bodies 1.8 s (7140); 60 oscillators 2.3 s (14 400).
MANY_OPERATIONS = 8000
OPERANDS = frozenset(("const", "par", "t", "y"))


class Traced:
    """A trace in a mode: the nodes that it stores, and the places of its parameters.

    The pointer form is the compiled function ``function(t, y, n, block, out)``.

    Attributes
    ----------
    kinds : list
        The types of the groups of parameters, in the order of the block.
    stored : list of Node
        The results of the pointer form.
    decisions : list of Node
        The conditions whose sides the pointer form notes in its block.
    at : tuple of int or None
        The group of each argument.
    n_stored : int
    in_batches : bool
        Whether long arrays were traced in batches: see `TracedInBatches`.
    """

    in_batches = False

    @refused_as(Refusal.untraceable)
    def __init__(self, trace, mode, n):
        self.trace, self.mode, self.n = trace, mode, n
        self.kinds = [kind_of_group(group) for group in trace.reads.groups]
        self.at = trace.reads.of_arguments()
        self._find_results()

    def _find_results(self):
        trace, mode, n, g = self.trace, self.mode, self.n, self.trace.graph
        self.stored = trace.outputs
        if mode.second_order:
            self.stored = trace.outputs[n:]
        if mode.moments:
            own = [g.make("y", (), i) for i in range(len(trace.outputs))]
            rates = {"mean": own, "rms": [g.mul(y, y) for y in own]}
            self.stored = [*trace.outputs, *(r for moment in mode.moments for r in rates[moment])]
        self.n_stored = len(self.stored)
        selects = [node for node in self._live() if node.op == "select"] if mode.notes_sides else []
        self.decisions = list({node.args[0].key: node.args[0] for node in selects}.values())

    def _live(self):
        """The nodes of the pointer form."""
        return live([*self.stored, self.trace.raising])

    @functools.cached_property
    def switches(self):
        """The Switches of the function; None if it does not switch with the time alone."""
        return switches(self.trace.graph, self.stored)

    @functools.cached_property
    def n_operations(self):
        """The number of operations in which the results are computed, one for each element."""
        return sum(node.op not in OPERANDS for node in live(self.stored))

    def key(self):
        """A digest of everything that the code depends on."""
        g, nodes = self.trace.graph, self._live()
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
        return f"traced {hashlib.sha256(text.encode()).hexdigest()}"

    def with_outputs(self, outputs, mode, n, raising=None):
        """Other outputs of the same graph as a Traced; without `raising`, they raise as these."""
        raising = self.trace.raising if raising is None else raising
        return Traced(self.trace._replace(outputs=outputs, raising=raising), mode, n)

    # -- machine code, by modules that are imported only when code is to be made

    def compiled(self, seconds=math.inf):
        """The compiled Function, from disk or made now."""
        key = self.key()
        code = code_store.assembled(key, self.text)
        return Function(
            key, code.address, sum(map(n_words, self.kinds)),
            self.dispatcher and functools.cache(self.dispatcher), code, self.mode, seconds,
            self.series and code_store.first_kept(self.series), self,
        )  # fmt: skip

    def text(self, symbol):
        """The text of an LLVM module with the pointer form."""
        from .pointer_form import text

        return text(self, symbol)

    def series(self, order, fine=False):
        """The Taylor kernel of an order; of an event, the kernel of its series along a step.

        `fine` asks for the kernel for tolerances near rounding.

        Raises
        ------
        NotSmooth
            If the function has no Taylor series.
        """
        from ..taylor.recurrences.rewrite import NotSmooth
        from .series import text, text_of_event

        if self.trace.graph.islands:
            raise NotSmooth("a call of a library")
        key, given = f"series {order} {fine} {self.key()}", (order, fine)
        if self.mode.one_number:
            text, given = text_of_event, (order,)

        def made(symbol):
            self.tell_if_long()
            return text(self, symbol, *given)

        return code_store.assembled(key, made, True)

    def tell_if_long(self):
        """Tell the user, on stderr, that the series of a large function takes long to compile."""
        if self.n_operations > MANY_OPERATIONS:
            said = f"fastdyn: Taylor compiles a series of {self.n_operations} operations"
            print(f"{said}, which takes seconds or more.", file=sys.stderr, flush=True)

    def lane_series(self, order, kinds, width):
        """The Taylor kernel with a trajectory in each lane of a vector."""
        from ..taylor.recurrences.rewrite import NotSmooth
        from .lanes import text

        if self.trace.graph.islands:
            raise NotSmooth("a call of a library")
        key = f"series in lanes {order} {width} {kinds} {self.key()}"
        return code_store.assembled(
            key, lambda symbol: text(self, symbol, order, kinds, width), True
        )

    def dispatcher(self):
        """The pointer form as a Numba dispatcher that kernels inline."""
        from .inlined import dispatcher

        return dispatcher(self)

    def vector_text(self, symbol, n, width, exact, kinds=None):
        """The text of an LLVM module with the form on n vectors of `width` lanes.

        The function ``(t, y, words)`` returns vectors, or a single vector for an event.  `kinds`
        are the types of the parameters, with "lanes" for parameters that vary between trajectories;
        for `exact` see `state.layout.Form`.
        """
        from .inlined import vector_text

        return vector_text(self, symbol, n, width, exact, kinds)


def kind_of_group(group):
    """The parameter type of a group; arrays are passed in place, or copied.

    A whole number becomes a float once for each solve, not in each evaluation.
    """
    if group.shape is not None:
        return ("array", group.dtype, len(group.shape))
    return FLOAT
