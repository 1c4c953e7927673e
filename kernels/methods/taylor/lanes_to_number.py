"""The lanes of a vector joined to one number.

LLVM, because Numba takes no lane of a vector.
"""

from llvmlite import ir
from numba import types
from numba.extending import intrinsic


def _across(join):
    """A function that joins the lanes of a vector, in pairs."""

    @intrinsic
    def across(typingctx, vector):
        def codegen(context, builder, signature, args):
            places = map(ir.IntType(32), range(vector.width))
            lanes = [builder.extract_element(args[0], place) for place in places]
            while len(lanes) > 1:
                lanes = [join(builder, *pair) for pair in zip(lanes[::2], lanes[1::2], strict=True)]
            return lanes[0]

        return types.float64(vector), codegen

    return across


largest = _across(lambda b, x, y: b.select(b.fcmp_ordered("<", x, y), y, x))
total = _across(lambda b, x, y: b.fadd(x, y))
