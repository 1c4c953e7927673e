"""A trace in batches as a compiled function."""

import functools
import hashlib

import numpy as np
from llvmlite import ir

from fastdyn.trace.batches.pieces import Irregular
from fastdyn.trace.batches.plan import Plan
from fastdyn.trace.batches.sparsity import Dense, Sparsity
from fastdyn.trace.emit.batches import BatchEmitter
from fastdyn.trace.emit.numbers import BIT, INDEX, REAL, WORD
from fastdyn.trace.graph.expressions import live
from fastdyn.trace.graph.refusal import Refusal, Untraceable, refused_as

from .. import calling_convention
from ..parameters import packer
from .code import kind_of_group
from .inputs import Source
from .pointer_form import by_formula
from .python_form import PythonForm


class TracedInBatches(PythonForm):
    """A trace in batches in a mode, with the attributes of `Traced`.

    It has no form that kernels inline, no form on vectors, and no Taylor series.
    """

    decisions = ()
    in_batches = True
    dispatcher = build_vector = series = lane_series = None

    @refused_as(Refusal.untraceable)
    def __init__(self, trace, mode, n):
        self.trace, self.mode, self.n = trace, mode, n
        self.table = trace.graph.batches
        outputs = trace.outputs
        self.nodes = [*outputs, trace.raising] if isinstance(outputs, list) else [trace.raising]
        self.result = np.empty(0, np.int32) if isinstance(outputs, list) else outputs
        self.n_stored = len(outputs)
        self.kinds = [kind_of_group(group) for group in trace.reads.groups]
        self.at = trace.reads.of_arguments()
        self.pack = packer(self.kinds)
        try:
            self.plan = Plan(self.table, self.result, self.nodes)
        except Irregular:
            raise Untraceable("its arrays are indexed without order", said=False) from None

    @functools.cached_property
    def pattern(self):
        """(rows, columns) of possible nonzeros of the Jacobian, sorted by column; None if dense."""
        try:
            return Sparsity(self.plan, self.n).of_results()
        except Dense:
            return None

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
        digest.update(self.result.tobytes())
        return f"traced in batches {digest.hexdigest()}"

    @refused_as(Refusal.untraceable)
    def text(self, symbol):
        """The text of an LLVM module with the pointer form."""
        module = ir.Module()
        calling_convention.define(module, symbol, self._body)
        return str(module)

    def _body(self, builder, t, y, n, block, out):
        raises = builder.call(self._loops(builder.module), [t, y, block, out])
        if self.trace.raising is not self.trace.graph.false:
            with builder.if_then(raises, likely=False):
                lengths = WORD(self.n), WORD(self.n_stored)
                calling_convention.note_fault(builder, t, y, block, out, *lengths)

    def _loops(self, module):
        """A separate function that stores the results and returns whether the function raises."""
        kind = ir.FunctionType(BIT, [REAL, REAL.as_pointer(), WORD.as_pointer(), REAL.as_pointer()])
        function = ir.Function(module, kind, "fastdyn_batches")
        function.linkage = "internal"
        function.attributes.add("noinline")
        t, y, block, out = function.args
        for array in (y, block, out):
            array.add_attribute("noalias")
        builder = ir.IRBuilder(function.append_basic_block())
        source = Source(builder, self, t, y, block, self.kinds)
        emitter = BatchEmitter(
            builder, self.trace.graph, self.plan, source, functools.partial(by_formula, builder)
        )
        *values, raises = emitter.store(out, self.nodes)
        for i, value in enumerate(values):
            builder.store(value, builder.gep(out, [INDEX(i)]))
        builder.ret(raises)
        return function
