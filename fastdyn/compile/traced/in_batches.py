"""A trace in batches as a compiled function."""

import functools
import hashlib
from typing import Any

import numpy as np
from llvmlite import ir

from fastdyn.trace.batches.pieces import Irregular
from fastdyn.trace.batches.plan import Plan
from fastdyn.trace.batches.singles.dependencies import Needed
from fastdyn.trace.batches.singles.timed import timed_nodes
from fastdyn.trace.batches.sparsity import Dense, Sparsity
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Refusal, Untraceable, refused_as
from fastdyn.trace.switching.switches import switches

from .. import function_convention
from .code import Traced
from .pointer_form import in_loops, plan_of, worth_loops


class TracedInBatches(Traced):
    """A trace in batches in a mode, without a list `stored`.

    A trace in batches has no form that kernels inline, no form on vectors, and no Taylor series.
    """

    in_batches = True
    dispatcher: Any = None
    vector_text = series = lane_series = dispatcher

    def _find_results(self):
        trace = self.trace
        self.table, self.n_stored = trace.graph.batches, len(trace.outputs)
        try:
            self.plan, self.nodes = self._planned(trace.outputs, trace.raising)
        except Irregular:
            raise Untraceable("its arrays are indexed without order", said=False) from None
        decisions = [*self.plan.decisions, *self.plan.single_decisions(self.nodes)]
        self.decisions = decisions if self.mode.notes_sides else []

    def _planned(self, outputs, raising):
        """The Plan, and the nodes behind its loops: single outputs, and the truth of `raising`."""
        needed = Needed(self.table, outputs, raising)
        if worth_loops(needed.nodes):
            return plan_of(self, needed)
        nodes = [*outputs, raising] if needed.single else [raising]
        result = np.empty(0, np.int32) if needed.single else outputs
        return Plan(self.table, result, nodes), nodes

    @functools.cached_property
    def pattern(self):
        """(rows, columns) of possible nonzeros of the Jacobian, sorted by column; None if dense."""
        try:
            return Sparsity(self.plan, self.n, self.nodes[:-1]).of_results()
        except Dense:
            return None

    @functools.cached_property
    def switches(self):
        """As of `Traced`."""
        results = timed_nodes(self.table, self.plan, self.nodes[:-1])
        return switches(self.trace.graph, results)

    def key(self):
        """A digest of everything that the code depends on."""
        g, table = self.trace.graph, self.table
        digest = hashlib.sha256()
        singles = []
        for b in table.batches:
            data = b.data
            if b.op == "one":
                singles.append(b.data)
                data = b.data.key
            digest.update(repr((b.op, data, b.shape, b.first)).encode())
            for operand in b.operands:
                digest.update(b"%d" % operand if isinstance(operand, int) else operand.tobytes())
        nodes = live([*singles, *self.nodes])
        lines = [(node.key, node.op, [a.key for a in node.args], node.data) for node in nodes]
        tables = sorted((name, t) for name, t in g.tables.items() if isinstance(t, range))
        places = [(group.first, group.shape) for group in self.trace.reads.groups]
        ends = [node.key for node in self.nodes]
        text = repr((self.mode, self.n, lines, ends, str(tables), places, self.kinds))
        digest.update(text.encode())
        digest.update(self.plan.result.tobytes())
        return f"traced in batches {digest.hexdigest()}"

    @refused_as(Refusal.untraceable)
    def text(self, symbol):
        """The text of an LLVM module with the pointer form."""
        module = ir.Module()
        body = functools.partial(in_loops, self, self.plan, self.nodes)
        function_convention.define(module, symbol, body)
        return str(module)
