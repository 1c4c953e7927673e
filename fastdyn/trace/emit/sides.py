"""Emits code that notes for each decision whether it was ever true, and whether ever false."""

from llvmlite import ir

from .memory import WIDTH
from .numbers import BIT, WORD

MASK = ir.VectorType(BIT, WIDTH)
BITS = ir.IntType(WIDTH)


class Sides:
    """The sides that decisions take in one call of the code: true, false or both.

    The truth values of a vector are kept as the bits of a small integer, because loops have no
    vector registers to spare.

    Parameters
    ----------
    builder : ir.IRBuilder
    most : int
        The number of separate notes; decisions i and i + most share a note.
    """

    def __init__(self, builder, most):
        self.builder = builder
        self._most = most
        self._seen = {}

    def note(self, decision, truth):
        """Note a truth value, or a vector of truth values, of a decision."""
        b = self.builder
        if truth.type == MASK:
            truth = b.bitcast(truth, BITS)
        place = decision % self._most, truth.type
        if place not in self._seen:
            with b.goto_entry_block():
                self._seen[place] = self._room(truth.type, 0), self._room(truth.type, -1)
        somewhere, everywhere = self._seen[place]
        b.store(b.or_(b.load(somewhere), truth), somewhere)
        b.store(b.and_(b.load(everywhere), truth), everywhere)

    def _room(self, kind, value):
        room = self.builder.alloca(kind)
        self.builder.store(kind(value), room)
        return room

    def store(self, place):
        """Set the bits of the sides in the word at an address: two bits for each decision."""
        b = self.builder
        word = b.load(place)
        for (decision, kind), (somewhere, everywhere) in self._seen.items():
            was_true = b.icmp_unsigned("!=", b.load(somewhere), kind(0))
            was_false = b.icmp_unsigned("!=", b.load(everywhere), kind(-1))
            for side, truth in enumerate((was_true, was_false)):
                word = b.or_(word, b.select(truth, WORD(1 << (2 * decision + side)), WORD(0)))
        b.store(word, place)
