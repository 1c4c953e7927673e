"""Emits calls of library functions, whose addresses are parameters of the code."""

from llvmlite import ir

REAL, WORD, BIT, INDEX = ir.DoubleType(), ir.IntType(64), ir.IntType(1), ir.IntType(32)
ISLAND = ir.FunctionType(ir.VoidType(), [REAL.as_pointer(), REAL.as_pointer()])


def rooms(builder, data):
    """Allocate the memory for an island's inputs and for its outputs."""
    _, n_in, n_out = data
    with builder.goto_entry_block():  # an alloca in a loop would grow the stack
        rooms = [builder.alloca(ir.ArrayType(REAL, n)) for n in (max(n_in, 1), n_out + 1)]
        return [builder.bitcast(room, REAL.as_pointer()) for room in rooms]


def call_island(builder, source, data, given, found):
    """Call an island, which reads inputs at `given` and stores outputs at `found`; return `found`.

    The last output is the failure flag: the emitted code sets the flag, and the island clears it.
    """
    slot, _, n_out = data
    builder.store(REAL(1.0), builder.gep(found, [INDEX(n_out)]))
    address = builder.fptosi(source.parameter(slot), WORD)
    builder.call(builder.inttoptr(address, ISLAND.as_pointer()), [given, found])
    return found
