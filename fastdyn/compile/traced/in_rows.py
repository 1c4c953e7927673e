"""A trace of long arrays in rows as a compiled function."""

import functools
import hashlib
from typing import Any

import numpy as np

from fastdyn.trace.emit.pattern import Dense, Sparsity, timed_nodes
from fastdyn.trace.emit.plan import Plan
from fastdyn.trace.graph.refusal import Refusal, refused_as
from fastdyn.trace.graph.rows import digest as label
from fastdyn.trace.switching.switches import switches

from .code import Traced, kind_of_group
from .pointer_form import program_of, text_in_rows


class TracedInRows(Traced):
    """A trace in rows in a mode, without a list `stored`.

    A trace in rows has no form that kernels inline, no form on vectors, and no Taylor series.
    """

    in_batches = True
    dispatcher: Any = None
    vector_text = series = lane_series = dispatcher

    def _find_results(self):
        self.n_stored = len(self.trace.outputs)
        self.program = program_of(self, self.trace.outputs)
        self.plan, self.n_rows = Plan(self.program), len(self.program.order)
        self.kinds = [kind_of_group(group) for group in self.trace.reads.groups]
        decisions = [*self.plan.decisions, *self.plan.single_decisions]
        self.decisions = decisions if self.mode.notes_sides else []

    @functools.cached_property
    def pattern(self):
        """(rows, columns) of possible nonzeros of the Jacobian, sorted by column; None if dense."""
        try:
            return Sparsity(self.program, self.n).of_results()
        except Dense:
            return None

    @functools.cached_property
    def switches(self):
        """As of `Traced`."""
        return switches(self.trace.graph, timed_nodes(self.program))

    def key(self):
        """A digest of everything that the code depends on."""
        g, program, digest = self.trace.graph, self.program, hashlib.sha256()
        for row in program.order:
            own = row.op == "const" and row.first >= g.next
            data = row.data if row.op != "const" else row.data.tobytes() if own else None
            digest.update(repr((row.op, data, row.shape, row.first, row.truth)).encode())
            for a in row.args:
                digest.update(repr(label(a) if isinstance(a, np.ndarray) else a).encode())
        lines = [(node.key, node.op, [a.key for a in node.args], node.data)
                 for node in program.nodes]  # fmt: skip
        tables = sorted((name, t) for name, t in g.tables.items() if isinstance(t, range))
        places = [(group.first, group.shape) for group in self.trace.reads.groups]
        text = repr(
            (self.mode, self.n, lines, program.raising.key, str(tables), places, self.kinds)
        )
        digest.update(text.encode())
        digest.update(repr(label(program.outputs)).encode())
        return f"traced in rows {digest.hexdigest()}"

    @refused_as(Refusal.untraceable)
    def text(self, symbol):
        """The text of an LLVM module with the pointer form."""
        return text_in_rows(self, self.plan, symbol)
