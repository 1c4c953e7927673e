"""Emits a plan of batches as machine code: vector loops over boxes, loops over tables of edges."""

from llvmlite import ir

from ..batches.boxes import MOST_BOXES, boxes_of, name_of
from ..batches.table import PRODUCTS
from ..graph.clock import look
from ..graph.refusal import Refusal
from .batch_loops import BatchLoops
from .islands import call_island
from .memory import VECTOR, WIDTH
from .numbers import REAL, WORD

ON_STACK = 4096  # up to so many numbers in all, the kept batches lie on the stack
BYTES, VOID = ir.IntType(8).as_pointer(), ir.VoidType()


class TooManyEdges(Refusal):
    """The refusal of a plan whose loops have more than MOST_BOXES boxes."""


class BatchEmitter(BatchLoops):
    """Emits a plan through an LLVM builder, at the start of a function.

    Parameters
    ----------
    builder : ir.IRBuilder
    graph : Graph
    plan : Plan
    source : object
        The source of an `Emitter`, which also has ``array(name)``, the address of an array.
    vector_function : callable
        ``function(name, values)`` emits an elementary function of vectors.
    sides : Sides, optional
        Emits the code that notes the outcomes of decisions.
    """

    def store(self, out, nodes):
        """Emit all loops, which store the outputs at `out`; return the values of `nodes`."""
        self._out, self._at = out, {}
        heap = self._reserve()
        for group in self.plan.groups:
            look()
            if group[0].reduction in PRODUCTS:
                for root in group:
                    self._product(root)
                continue
            for root in group:
                if root.reduction:
                    self._fill(root)
            alone, alike = boxes_of(self.plan, group)
            if len(alone) + len(alike) > MOST_BOXES:
                raise TooManyEdges("its arrays have too many edges", said=False)
            for formula in alone:
                self._box(formula)
            for formulas in alike:
                self._edges(formulas)
        values = self._one.nodes(nodes)
        if self.sides is not None:
            for i, node in enumerate(self.plan.single_decisions(nodes), len(self.plan.decisions)):
                self.sides.note(i, *self._one.nodes([node]))
        if heap is not None:
            self.builder.call(self._one._declared("free", [BYTES], VOID), [heap])
        return values

    def _reserve(self):
        """Allocate the kept batches; return the address on the heap, None if on the stack."""
        b, sizes, total = self.builder, {}, 0
        for number, batch in self.plan.kept.items():
            sizes[number], total = total, total + -(-batch.size // WIDTH) * WIDTH
        heap = None
        if total <= ON_STACK:
            room = b.alloca(ir.ArrayType(REAL, max(total, 1)))
            room.align = 64
            room = b.bitcast(room, REAL.as_pointer())
        else:
            malloc = self._one._declared("malloc", [WORD], BYTES)
            malloc.return_value.add_attribute("noalias")
            heap = b.call(malloc, [WORD(8 * total)])
            room = b.bitcast(heap, REAL.as_pointer())
        for number, offset in sizes.items():
            self._at[number] = b.gep(room, [WORD(offset)])
        return heap

    # -- products

    def _product(self, root):
        batch = root.batch
        x = self.table_of.batches[batch.operands[0]]
        name = name_of(x)
        op, *data = batch.data
        if op == "island":
            call_island(self.builder, self.source, data, self._array(name), self._at[batch.number])
            return
        make = {"dense": self._dense, "csr": self._sparse, "running": self._running}[op]
        make(self._at[batch.number], self._array(name), *(data or [batch.size]))

    def _running(self, target, x, size):
        b = self.builder
        with b.goto_entry_block():
            total = b.alloca(REAL)
        b.store(REAL(0.0), total)
        with self.each(WORD(size), 1) as k:
            b.store(b.fadd(b.load(total), b.load(b.gep(x, [k]))), total)
            self.put(b.load(total), target, k)

    def _dense(self, target, x, rows, columns, slots, at, by_row, by_column):
        b, matrix = self.builder, self.source.table(slots.start)
        begin = b.gep(matrix, [WORD(at)])
        if by_column == 1 and columns >= WIDTH and matrix.type.pointee == REAL:
            with self.each(WORD(rows), 1) as r:
                row, total = b.gep(begin, [b.mul(r, WORD(by_row))]), self._row_total()
                whole = columns - columns % WIDTH
                with self.each(WORD(whole), WIDTH) as k:
                    term = b.fmul(self.vector(row, k), self.vector(x, k))
                    b.store(b.fadd(b.load(total), term), total)
                value = self._across("sum", total)
                for k in range(whole, columns):
                    left = b.load(b.gep(row, [WORD(k)]))
                    value = b.fadd(value, b.fmul(left, b.load(b.gep(x, [WORD(k)]))))
                self.put(value, target, r)
            return
        with self.each(WORD(rows), 1) as r:
            self.put(REAL(0.0), target, r)
        wide = by_row == 1 and rows >= WIDTH and matrix.type.pointee == REAL
        with self.each(WORD(columns), 1) as c:
            factor, column = b.load(b.gep(x, [c])), b.gep(begin, [b.mul(c, WORD(by_column))])
            whole = rows - rows % WIDTH if wide else 0
            if whole:
                with self.each(WORD(whole), WIDTH) as k:
                    term = b.fmul(self.vector(column, k), self.splat(factor))
                    self.put(b.fadd(self.vector(target, k), term), target, k)
            if whole < rows:
                with self.each(WORD(rows - whole), 1) as left:
                    r = b.add(left, WORD(whole))
                    entry = b.load(b.gep(column, [b.mul(r, WORD(by_row))]))
                    if entry.type != REAL:
                        entry = b.sitofp(entry, REAL)
                    place = b.gep(target, [r])
                    b.store(b.fadd(b.load(place), b.fmul(entry, factor)), place)

    def _row_total(self):
        with self.builder.goto_entry_block():
            total = self.builder.alloca(VECTOR)
        self.builder.store(ir.Constant(VECTOR, [0.0] * WIDTH), total)
        return total

    def _sparse(self, target, x, rows, begins, places, values):
        b = self.builder
        begins, places, values = (self.source.table(s.start) for s in (begins, places, values))
        with b.goto_entry_block():
            total = b.alloca(REAL)
        with self.each(WORD(rows), 1) as r:
            b.store(REAL(0.0), total)
            first = b.fptosi(b.load(b.gep(begins, [r])), WORD)
            last = b.fptosi(b.load(b.gep(begins, [b.add(r, WORD(1))])), WORD)
            with (
                b.if_then(b.icmp_signed("<", first, last)),
                self.each(b.sub(last, first), 1) as k,
            ):
                at = b.add(first, k)
                place = b.fptosi(b.load(b.gep(places, [at])), WORD)
                term = b.fmul(b.load(b.gep(values, [at])), b.load(b.gep(x, [place])))
                b.store(b.fadd(b.load(total), term), total)
            self.put(b.load(total), target, r)
