"""Loops over arrays in LLVM: vectors of neighbours, truth values kept as numbers, tables."""

import contextlib

from llvmlite import ir

from .numbers import BIT, INDEX, REAL, WORD, constant_bytes

WIDTH = 8
VECTOR = ir.VectorType(REAL, WIDTH)


class Memory:
    """Reads, writes and loops through a builder."""

    def __init__(self, builder):
        self.builder = builder

    @contextlib.contextmanager
    def each(self, count, width):
        """A loop over ``range(0, count, width)``; the last step begins at ``count - width``."""
        b = self.builder
        before, body = b.block, b.append_basic_block()
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

    def table(self, content, kind):
        """Where a constant array lies, of doubles or of indices."""
        module = self.builder.module
        table = constant_bytes(module, module.get_unique_name("fastdyn_rows"), content)
        return table.bitcast(kind.as_pointer())

    def row(self, table, r, length):
        """The whole numbers of a row of a table of indices."""
        b = self.builder
        first = b.mul(r, WORD(length))
        return [b.sext(b.load(b.gep(table, [b.add(first, WORD(j))])), WORD) for j in range(length)]

    def vector(self, begin, k):
        """Neighbours from a place on."""
        b = self.builder
        value = b.load(b.bitcast(b.gep(begin, [k]), VECTOR.as_pointer()))
        value.align = 8
        return value

    def splat(self, value):
        """A vector of one number, or of one truth value."""
        b, kind = self.builder, ir.VectorType(value.type, WIDTH)
        none, zeros = ir.Constant(kind, ir.Undefined), ir.VectorType(INDEX, WIDTH)
        one = b.insert_element(none, value, INDEX(0))
        return b.shuffle_vector(one, none, ir.Constant(zeros, [0] * WIDTH))

    def put(self, value, base, k):
        """Store a number or a vector."""
        b, value = self.builder, self.number(value)
        at = b.bitcast(b.gep(base, [k]), value.type.as_pointer())
        b.store(value, at).align = 8

    def truth(self, truth, value):
        """A truth value that was kept as a number."""
        if not truth:
            return value
        zero = REAL(0.0) if value.type == REAL else ir.Constant(VECTOR, [0.0] * WIDTH)
        return self.builder.fcmp_unordered("!=", value, zero)

    def number(self, value):
        """A number, of a truth value 1 or 0."""
        if getattr(value.type, "element", value.type) != BIT:
            return value
        return self.builder.uitofp(value, REAL if value.type == BIT else VECTOR)
