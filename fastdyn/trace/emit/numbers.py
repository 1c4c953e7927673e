"""Emits a graph as LLVM instructions: on numbers, or on vectors with a trajectory in each lane.

Each node becomes an operation of LLVM or a call.  LLVM never reorders operations, and fuses them
only if `flags` allow fusion.  Therefore the bits of a result do not depend on the surrounding code.
"""

import collections
from typing import Any

import numpy as np
from llvmlite import ir

from ..graph.clock import EVERY, look
from ..graph.expressions import live
from ..operations import OPERATIONS
from ..operations.delays import PASTS
from ..operations.special import IN_C

# The code of operations that call kernels, ``emit(emitter, node, args)``: this folder knows none.
BY_KERNELS: dict[str, Any] = {}
REAL = ir.DoubleType()
WORD = ir.IntType(64)
BIT = ir.IntType(1)
INDEX = ir.IntType(32)


class Emitter:
    """Emits nodes through an LLVM builder.

    Parameters
    ----------
    builder : ir.IRBuilder
    graph : Graph
    kind : ir.Type
        The type of numbers: double, or a vector of doubles.
    source : object, optional
        Gives the values `t`, ``y(i)`` and ``parameter(slot)``, and the address ``table(slot)``.
    function : callable, optional
        ``function(name, values)`` emits an elementary function; by default a call of the C library.
    flags : tuple of str
        LLVM's fast-math flags for arithmetic.
    """

    def __init__(self, builder, graph, kind, source=None, function=None, flags=()):
        self.builder = builder
        self.graph = graph
        self.kind = kind
        self.flags = flags
        self.source: Any = source
        self.width = kind.count if isinstance(kind, ir.VectorType) else None
        self.function = function or self.in_c
        self._values = {}
        self.reads = collections.Counter()  # of components of each past state

    def nodes(self, outputs):
        """Emit nodes and their operands; return the nodes' values."""
        found = live(outputs)
        reads = [node.args[0].key for node in found if node.op in PASTS and node.op != "past"]
        self.reads = collections.Counter(reads)
        for node in found:
            if node.key not in self._values:
                if len(self._values) % EVERY == 0:
                    look()
                args = [self._values[a.key] for a in node.args]
                self._values[node.key] = self.emit(node, args)
        return [self._values[node.key] for node in outputs]

    def value(self, node):
        """The value of a node that was emitted."""
        return self._values[node.key]

    def constant(self, value):
        if isinstance(value, bool):
            kind = BIT if self.width is None else ir.VectorType(BIT, self.width)
        else:
            kind = self.kind
        return ir.Constant(kind, value if self.width is None else [value] * self.width)

    def emit(self, node, args):
        """Emit one node, given the values of its operands."""
        b = self.builder
        op = node.op
        if op == "const":
            return self.constant(node.data)
        if op == "t":
            return self.source.t
        if op == "y":
            return self.source.y(node.data)
        if op == "par":
            return self.source.parameter(node.data)
        if op == "item":  # one element of a batch
            return self.source.item(node.data)
        operation = OPERATIONS[op]
        if op in BY_KERNELS:
            return BY_KERNELS[op](self, node, args)
        if operation.elementary:
            return self.function(op, args)
        if operation.sign and operation.truth:
            return b.fcmp_ordered(operation.sign, *args)
        if operation.sign:
            return getattr(b, operation.llvm)(*args, flags=self.flags)
        if operation.llvm.startswith("llvm."):
            return self._intrinsic(operation.llvm, args)
        if operation.llvm:
            return getattr(b, operation.llvm)(*args)
        return self._by_lanes(getattr(self, f"_{op}"), node.data, args[0])

    def _intrinsic(self, name, args):
        kind = args[0].type
        lanes = f"v{kind.count}" if isinstance(kind, ir.VectorType) else ""
        function = declared(self.builder.module, f"{name}.{lanes}f64", [kind] * len(args), kind)
        return self.builder.call(function, args)

    def in_c(self, name, args):
        """Call a function of the C library; on vectors, lane by lane."""
        if self.width is None:
            if OPERATIONS[name].llvm:
                return self._intrinsic(OPERATIONS[name].llvm, args)
            if name.startswith(IN_C):  # Cython's functions take an unused number, too
                args = [*args, INDEX(0)]
            function = declared(self.builder.module, name, [a.type for a in args], REAL)
            return self.builder.call(function, args)
        one = Emitter(self.builder, self.graph, REAL)
        return self._by_lanes(lambda _, *values: one.in_c(name, values), None, *args)

    # -- tables

    def _by_lanes(self, one, data, *args):
        if self.width is None:
            return one(data, *args)
        result = ir.Constant(self.kind, ir.Undefined)
        for i in range(self.width):
            value = one(data, *[self.builder.extract_element(x, INDEX(i)) for x in args])
            result = self.builder.insert_element(result, value, INDEX(i))
        return result

    def _row(self, name):
        """The (address, length, stride) of a table."""
        table = self.graph.tables[name]
        if isinstance(table, range):
            return self.source.table(table.start), len(table), table.step
        module = self.builder.module
        label = f"fastdyn_table_{name}"
        known: Any = module.globals.get(label)
        if known is None:
            known = constant_bytes(module, label, np.ascontiguousarray(table, dtype=float))
        return self.builder.bitcast(known, REAL.as_pointer()), len(table), 1

    def _entry_at(self, row, i):
        address, _, step = row
        return number_at(self.builder, address, i, step)

    def _between(self, i, low, high):
        b = self.builder
        low = WORD(low)
        high = WORD(high)
        i = b.select(b.icmp_signed("<", i, low), low, i)
        return b.select(b.icmp_signed(">", i, high), high, i)

    def _table(self, name, x):
        return number_at(self.builder, self.place(self._row(name), x), INDEX(0))

    def place(self, row, x):
        """The address of the entry at index x of a row, (address, length, stride)."""
        b = self.builder
        address, n, step = row
        number = b.fcmp_ordered("<", self._intrinsic(OPERATIONS["abs"].llvm, [x]), REAL(2.0**62))
        i = b.fptosi(b.select(number, x, REAL(0.0)), WORD)
        i = b.select(b.icmp_signed("<", i, WORD(0)), b.add(i, WORD(n)), i)
        i = self._between(i, 0, n - 1)
        return b.gep(address, [b.mul(i, WORD(step)) if step != 1 else i])

    def _search(self, data, x):
        name, side = data
        return self.builder.sitofp(self._whereabouts(self._row(name), side, x), REAL)

    def _whereabouts(self, row, side, x):
        address, n, step = row
        function = _search_function(self.builder.module, side, address.type, step)
        return self.builder.call(function, [address, WORD(n), x])

    def _piece(self, row, x):
        """The index of the piece that contains x."""
        i = self.builder.sub(self._whereabouts(row, "right", x), WORD(1))
        return self._between(i, 0, row[1] - 2)

    def _piecewise(self, data, x):
        b = self.builder
        knots, *coefficients = map(self._row, data)
        i = self._piece(knots, x)
        at = b.fsub(x, self._entry_at(knots, i))
        result = None
        for row in coefficients:
            c = self._entry_at(row, i)
            result = c if result is None else b.fadd(b.fmul(result, at), c)
        return result

    def _interpolate(self, data, x):
        """np.interp by the left knot; if that is NaN, by the right; if NaN, an equal height."""
        b = self.builder
        knots, heights = map(self._row, data)
        i = self._piece(knots, x)
        after = b.add(i, WORD(1))
        left = self._entry_at(knots, i)
        right = self._entry_at(knots, after)
        low = self._entry_at(heights, i)
        high = self._entry_at(heights, after)
        slope = b.fdiv(b.fsub(high, low), b.fsub(right, left))
        near = b.fadd(b.fmul(slope, b.fsub(x, left)), low)
        far = b.fadd(b.fmul(slope, b.fsub(x, right)), high)
        level = b.and_(b.fcmp_unordered("uno", far, far), b.fcmp_ordered("==", low, high))
        far = b.select(level, low, far)
        result = b.select(b.fcmp_unordered("uno", near, near), far, near)
        result = b.select(b.fcmp_ordered("==", x, left), low, result)
        return b.select(b.fcmp_unordered("uno", x, x), x, result)


def declared(module, name, args, result):
    """The function of this name in a module, declared if it is not there."""
    return module.globals.get(name) or ir.Function(module, ir.FunctionType(result, args), name)


def number_at(builder, address, i, step=1):
    """Load an element of an array; whole numbers and truth values become floats."""
    if step != 1:
        i = builder.mul(i, i.type(step))
    value = builder.load(builder.gep(address, [i]))
    if value.type == REAL:
        return value
    return (builder.sitofp if value.type == WORD else builder.uitofp)(value, REAL)


def constant_bytes(module, label, content):
    """A constant array as bytes, which are shorter than numbers in LLVM's text."""
    data = bytearray(content.tobytes())
    kind = ir.ArrayType(ir.IntType(8), len(data))
    found: Any = ir.GlobalVariable(module, kind, label)
    found.linkage = "internal"
    found.global_constant = True
    found.align = 64
    found.initializer = ir.Constant(kind, data)
    return found


def _search_function(module, side, pointer, step):
    """The function ``i64 search(double *a, i64 n, double x)``: np.searchsorted, with NaN last."""
    name = f"fastdyn_search_{side}_{pointer.pointee}_{step}"
    if name in module.globals:
        return module.globals[name]
    kind = ir.FunctionType(WORD, [pointer, WORD, REAL])
    function = ir.Function(module, kind, name)
    function.linkage = "internal"
    blocks = [function.append_basic_block(part) for part in ("entry", "loop", "half", "done")]
    entry, loop, half, done = blocks
    ir.IRBuilder(entry).branch(loop)
    b = ir.IRBuilder(loop)
    low = b.phi(WORD)
    high = b.phi(WORD)
    b.cbranch(b.icmp_signed("<", low, high), half, done)
    b = ir.IRBuilder(half)
    middle = b.lshr(b.add(low, high), WORD(1))
    value = number_at(b, function.args[0], middle, step)
    before = b.fcmp_unordered("<" if side == "left" else "<=", value, function.args[2])
    above = b.add(middle, WORD(1))
    low.add_incoming(WORD(0), entry)
    low.add_incoming(b.select(before, above, low), half)
    high.add_incoming(function.args[1], entry)
    high.add_incoming(b.select(before, high, middle), half)
    b.branch(loop)
    ir.IRBuilder(done).ret(low)
    return function
