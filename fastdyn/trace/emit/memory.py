"""Emits loops over arrays, memory, loads and stores of vectors, and constant tables."""

import contextlib

from llvmlite import ir

from .numbers import BIT, INDEX, REAL, WORD, constant_bytes, declared

WIDTH = 8
VECTOR = ir.VectorType(REAL, WIDTH)
BYTES = ir.IntType(8).as_pointer()
VOID = ir.VoidType()
ON_STACK = 4096  # numbers of a function, up to which they lie on the stack


class Memory:
    """Emits reads, writes and loops through a builder."""

    def __init__(self, builder):
        self.builder = builder

    @contextlib.contextmanager
    def each(self, count, width):
        """Emit a loop over ``range(0, count, width)``.

        If `width` does not divide `count`, the last iteration begins at ``count - width``.
        """
        b = self.builder
        before = b.block
        body = b.append_basic_block()
        after = b.append_basic_block()
        b.branch(body)
        b.position_at_end(body)
        k = b.phi(WORD)
        k.add_incoming(WORD(0), before)
        yield k
        following = b.add(k, WORD(width))
        if width > 1:
            last = b.sub(count, WORD(width))
            step = b.select(b.icmp_signed("<", following, last), following, last)
        else:
            step = following
        more = b.icmp_signed("<", following, count)
        k.add_incoming(step, b.block)
        b.cbranch(more, body, after)
        b.position_at_end(after)

    @contextlib.contextmanager
    def room(self, size):
        """The address of memory for numbers, on the stack or the heap, within the ``with``."""
        b = self.builder
        module = self.builder.module
        heap = None
        if size <= ON_STACK:
            room = b.alloca(ir.ArrayType(REAL, max(size, 1)))
            room.align = 64
        else:
            malloc = declared(module, "malloc", [WORD], BYTES)
            malloc.return_value.add_attribute("noalias")
            room = heap = b.call(malloc, [WORD(8 * size)])
        yield b.bitcast(room, REAL.as_pointer())
        if heap is not None:
            b.call(declared(module, "free", [BYTES], VOID), [heap])

    def table(self, content, kind):
        """The address of a constant array of doubles or indices."""
        module = self.builder.module
        table = constant_bytes(module, module.get_unique_name("fastdyn_rows"), content)
        return table.bitcast(kind.as_pointer())

    def row(self, table, r, length):
        """The indices in row r of a table."""
        b = self.builder
        first = b.mul(r, WORD(length))
        return [b.sext(b.load(b.gep(table, [b.add(first, WORD(j))])), WORD) for j in range(length)]

    def vector(self, begin, k):
        """Load a vector of contiguous elements."""
        b = self.builder
        value = b.load(b.bitcast(b.gep(begin, [k]), VECTOR.as_pointer()))
        value.align = 8
        return value

    def splat(self, value):
        """Broadcast a number, or a truth value, to a vector."""
        b = self.builder
        kind = ir.VectorType(value.type, WIDTH)
        none = ir.Constant(kind, ir.Undefined)
        zeros = ir.VectorType(INDEX, WIDTH)
        one = b.insert_element(none, value, INDEX(0))
        return b.shuffle_vector(one, none, ir.Constant(zeros, [0] * WIDTH))

    def put(self, value, base, k):
        """Store a number or a vector; truth values are stored as 1.0 and 0.0."""
        b = self.builder
        value = self.number(value)
        at = b.bitcast(b.gep(base, [k]), value.type.as_pointer())
        b.store(value, at).align = 8

    def truth(self, truth, value):
        """Convert a stored number back to a truth value, if `truth`; else return the number."""
        if not truth:
            return value
        zero = REAL(0.0) if value.type == REAL else ir.Constant(VECTOR, [0.0] * WIDTH)
        return self.builder.fcmp_unordered("!=", value, zero)

    def number(self, value):
        """Convert truth values to 1.0 and 0.0; return numbers unchanged."""
        if getattr(value.type, "element", value.type) != BIT:
            return value
        return self.builder.uitofp(value, REAL if value.type == BIT else VECTOR)
