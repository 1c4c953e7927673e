"""A constant mass matrix beside vectors: its numbers, the same in all lanes, and its products.

LLVM, because Numba builds no tuple of a length that a type determines.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..calls.block import MASS, PLACES, N
from ..calls.user_function import words_at
from ..jit.options import INLINED, njit
from ..vector.instructions import splat
from .elimination_in_lanes import make_product


def make_numbers(count, form):
    """``numbers(block)``: the `count` numbers of the matrix that the block names, as vectors."""
    kind = form.value.dtype
    whole = types.UniTuple(kind, count)

    @intrinsic
    def loaded(typingctx, address):
        def codegen(context, builder, signature, args):
            first = builder.inttoptr(args[0], ir.DoubleType().as_pointer())
            numbers = [builder.load(cgutils.gep(builder, first, i)) for i in range(count)]
            return context.make_tuple(
                builder, whole, [splat(builder, x, kind.width) for x in numbers]
            )

        return whole(types.int64), codegen

    @njit(**INLINED)
    def numbers(block):
        mass = block[MASS]
        return loaded(mass + 8 * (PLACES + words_at(mass)[N]))

    return numbers


def make_mass_product(rows, columns, form):
    """``add(block, x, total)`` gives M x + total; M has numbers at (rows, columns)."""
    numbers, multiply = make_numbers(len(rows), form), make_product(rows, columns)

    @njit(**INLINED)
    def add(block, x, total):
        return multiply(numbers(block), x, total)

    return add
