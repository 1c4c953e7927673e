"""A trace as a compiled function: its parameters in a block, its code on disk.

The key of the code is a digest of the graph: kept code is valid for all functions with this graph.
"""

import functools
import hashlib
import math
import sys

import numpy as np

from fastdyn import code_store
from fastdyn.trace.graph.clock import EVERY, look
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Refusal, refused_as
from fastdyn.trace.graph.rows import digest as label
from fastdyn.trace.operations import OPERATIONS
from fastdyn.trace.switching.switches import held_components, switches

from ..functions import Function
from ..parameters import FLOAT, n_words

# Beyond, "auto" takes a pair instead of Taylor.  Processor time of a first call by Taylor on a busy
# core: 20 oscillators, each coupled to each, 0.8 s (1600 operations); 1000 masses on springs 1.0 s
# (6000); 40 oscillators 1.6 s (6400); 20 bodies 1.8 s (7140); 60 oscillators 2.3 s (14 400).
MANY_OPERATIONS = 8000
OPERANDS = frozenset(("const", "par", "t", "y"))


class Traced:
    """A trace in a mode: the numbers that it stores, and the places of its parameters.

    The pointer form is the compiled function ``function(t, y, n, block, out)``.  Of long arrays,
    which are traced in batches, it is the only form: kernels do not inline them, and there are no
    nodes `stored`, no form on vectors and no Taylor series.

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
        Whether long arrays were traced in batches.
    entries : list of Entry
        What the pointer form of a mode that adds also adds, each at an index that it computes.
    """

    @refused_as(Refusal.untraceable)
    def __init__(self, trace, mode, n, in_batches=False, entries=()):
        self.trace = trace
        self.mode = mode
        self.n = n
        self.in_batches = in_batches
        self.entries = entries
        self.kinds = [kind_of_group(group) for group in trace.reads.groups]
        self.at = trace.reads.of_arguments()
        if in_batches:
            self._find_rows()
        else:
            self._find_results()

    def _find_rows(self):
        from .pointer_form import LoopPlan, program_of

        self.n_stored, self.program = len(self.trace.outputs), program_of(self, self.trace.outputs)
        self.plan = LoopPlan(self.program)
        self.kinds = list(map(kind_of_group, self.trace.reads.groups))  # the plan reads more
        found = [*self.plan.decisions, *self.plan.single_decisions]
        self.decisions = found if self.mode.notes_sides else []

    def _find_results(self):
        trace = self.trace
        mode = self.mode
        n = self.n
        g = self.trace.graph
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
        added = [node for _, *nodes in self.entries for node in nodes]
        return live([*self.stored, self.trace.raising, *added])

    @functools.cached_property
    def switches(self):
        """The Switches of the function; None if it does not switch with the time alone."""
        return self.switches_by(())

    @functools.cached_property
    def held(self):
        """The components of the state that do not change, if the results are its derivatives."""
        return () if self.in_batches else held_components(self.trace.graph, self.stored)

    def switches_by(self, slots, held=()):
        """The Switches of the function and of its derivatives by the parameters at slots.

        `held` are components of the state that do not change.
        """
        if not self.in_batches:
            return switches(self.trace.graph, self.stored, slots, held)
        from fastdyn.trace.emit.pattern import timed_nodes

        return switches(self.trace.graph, timed_nodes(self.program), slots)

    @functools.cached_property
    def pattern(self):
        """(rows, columns) of the possible nonzeros of a Jacobian, by columns; None if unknown."""
        if not self.in_batches:
            return None
        from fastdyn.trace.emit.pattern import Dense, Sparsity

        try:
            return Sparsity(self.program, self.n).of_results()
        except Dense:
            return None

    @functools.cached_property
    def in_loops(self):
        """Whether loops compute single numbers, with formulas as elementary functions."""
        if self.in_batches:
            return False
        from .pointer_form import loops_of

        return loops_of(self) is not None

    @functools.cached_property
    def n_operations(self):
        """The number of operations in which the results are computed, one for each element."""
        return sum(node.op not in OPERANDS for node in live(self.stored))

    @functools.cached_property
    def is_algebraic(self):
        """Whether the results have neither elementary functions nor conditions."""
        found = {node.op for node in live(self.stored)}
        return "select" not in found and not any(OPERATIONS[op].elementary for op in found)

    def key(self):
        """A digest of everything that the code depends on."""
        g = self.trace.graph
        groups = self.trace.reads.groups
        lines, ends = self._rows() if self.in_batches else self._nodes()
        tables = sorted((name, t) for name, t in g.tables.items() if isinstance(t, range))
        places = [(group.first, group.shape) for group in groups]
        text = repr((self.mode, self.n, lines, ends, str(tables), places, self.kinds))
        return f"traced {hashlib.sha256(text.encode()).hexdigest()}"

    def _nodes(self):
        """The nodes of the pointer form as data, and which are results."""
        names = {}
        lines = []
        for i, node in enumerate(self._live()):
            if i % EVERY == 0:
                look()
            names[node.key] = i
            lines.append((node.op, [names[a.key] for a in node.args], node.data))
        ends = [names[node.key] for node in (*self.stored, self.trace.raising)]
        added = [(p, names[at.key], names[d.key]) for p, at, d in self.entries]
        return lines, [*ends, *added]

    def _rows(self):
        """The rows and single nodes of the pointer form as data, and which are results."""
        program, own = self.program, self.trace.graph.next  # from here on: rows of the program
        lines: list = []
        for row in program.order:
            data = row.data
            if row.op == "const":
                own_data = row.data.tobytes() if row.first >= own else b""
                data = hashlib.sha256(own_data).digest()
            args = [label(a) if isinstance(a, np.ndarray) else a for a in row.args]
            lines.append((row.op, data, row.shape, row.first, row.truth, args))
        lines += [(node.key, node.op, [a.key for a in node.args], node.data)
                  for node in program.nodes]  # fmt: skip
        return lines, (program.raising.key, label(program.outputs))

    def with_outputs(self, outputs, mode, n, raising=None, entries=()):
        """Other outputs of the same graph as a Traced; without `raising`, they raise as these."""
        raising = self.trace.raising if raising is None else raising
        trace = self.trace._replace(outputs=outputs, raising=raising)
        return Traced(trace, mode, n, entries=entries)

    # -- machine code, by modules that are imported only when code is to be made

    def compiled(self, seconds=math.inf):
        """The compiled Function, from disk or made now."""
        key = self.key()
        code = code_store.assembled(key, self.text)
        forms = (None, None) if self.in_batches else (self.dispatcher, self.series)
        build, series = [each and code_store.first_kept(each) for each in forms]
        size = sum(map(n_words, self.kinds))
        return Function(key, code.address, size, build, code, self.mode, seconds, series, self)

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
        from .series import text, text_of_event

        key = f"series {order} {fine} {self.key()}"
        given = (order, fine)
        if self.mode.one_number:
            text = text_of_event
            given = (order,)

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
        from .lanes import text

        key = f"series in lanes {order} {width} {kinds} {self.key()}"
        return code_store.assembled(
            key, lambda symbol: text(self, symbol, order, kinds, width), True
        )

    def dispatcher(self):
        """The pointer form as a Numba dispatcher that kernels inline."""
        from .inlined import dispatcher

        return dispatcher(self)

    def vector_text(self, symbol, n, width, exact, kinds=None, skip=0):
        """The text of an LLVM module with the form on n vectors of `width` lanes.

        The function ``(t, y, words)`` returns vectors, or a single vector for an event.  `kinds`
        are the types of the parameters, with "lanes" for parameters that vary between trajectories;
        they begin behind `skip` words.  For `exact` see `state.layout.Form`.
        """
        from .inlined import vector_text

        return vector_text(self, symbol, n, width, exact, kinds, skip)


def kind_of_group(group):
    """The parameter type of a group; arrays are passed in place, or copied.

    A whole number becomes a float once for each solve, not in each evaluation.
    """
    if group.shape is not None:
        return ("array", group.dtype, len(group.shape))
    return FLOAT
