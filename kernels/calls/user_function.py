"""Calls from kernels to the user's functions.

Every compiled function of the user has one form, ``function(t, y, n, block, out)``.  y and out are
pointers to n numbers; `block` is an int64 array with the data of the function in this solve (see
`block.py`).  A shared kernel calls any function by its address (`by_pointer`).  A kernel
specialised to one function contains the code of the function (`inlined`).

LLVM, because Numba has no call of its own convention at an address or by a symbol that
comes later, and no pointer from a number.
"""

# Numba's type annotations are incomplete.
# pyright: reportCallIssue=false

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..jit.options import INTERNAL, njit
from ..state.elementwise import ROW, data_of, length_of
from ..state.record import RUNNING
from .block import ADDRESS, RAISED_WORD

WORDS = types.Array(types.int64, 1, "C")
FORM = (
    types.float64,
    types.CPointer(types.float64),
    types.intp,
    types.CPointer(types.int64),
    types.CPointer(types.float64),
)


@intrinsic
def address_of(typingctx, array):
    """The address of the data of an array."""

    def codegen(context, builder, signature, args):
        return builder.ptrtoint(data_of(context, builder, array, args[0]), ir.IntType(64))

    return types.int64(array), codegen


@intrinsic
def words_at(typingctx, address):
    """The words at an address, for example of a block."""

    def codegen(context, builder, signature, args):
        return builder.inttoptr(args[0], ir.IntType(64).as_pointer())

    return types.CPointer(types.int64)(types.int64), codegen


@intrinsic
def numbers_at(typingctx, address):
    """The numbers at an address."""

    def codegen(context, builder, signature, args):
        return builder.inttoptr(args[0], ir.DoubleType().as_pointer())

    return types.CPointer(types.float64)(types.int64), codegen


@njit(**INTERNAL)
def raised(block):
    """True if the function of the block at the address `block` raised."""
    return words_at(block)[RAISED_WORD] != 0


@intrinsic
def call_with(typingctx, function, block, t, y, out):
    """Call the function at one address with the block at another: out = function(t, y)."""

    def codegen(context, builder, signature, args):
        words = builder.inttoptr(args[1], ir.IntType(64).as_pointer())
        values, target = (data_of(context, builder, ROW, row) for row in args[3:])
        n = length_of(context, builder, ROW, args[3])
        kind = context.call_conv.get_function_type(types.none, FORM)
        function = builder.inttoptr(args[0], kind.as_pointer())
        arguments = (args[2], values, n, words, target)
        context.call_conv.call_function(builder, function, types.none, FORM, arguments)
        return context.get_dummy_value()

    return types.none(types.int64, types.int64, types.float64, ROW, ROW), codegen


@njit(**INTERNAL)
def call_function(block, t, y, out):
    """Call the function of the block at the address `block`: out = function(t, y)."""
    call_with(words_at(block)[ADDRESS], block, t, y, out)


@njit(**INTERNAL)
def evaluate(block, t, y, out):
    """Call the function of the block at the address `block`; False if the function raised."""
    call_function(block, t, y, out)
    return not raised(block)


@njit(**INTERNAL)
def by_pointer(t, y, block, out):
    """The derivative in the row `out`, by the function that the block names."""
    call_function(address_of(block), t, y, out)
    return out


@njit(**INTERNAL)
def one_evaluation(block, t, y, out):
    """A kernel that calls the function once."""
    by_pointer(t, y, block, out)
    return RUNNING


def linked_later(name):
    """A stand-in for the compiled function that LLVM links under this name later."""

    @intrinsic
    def call(typingctx, t, y, n, block, out):
        def codegen(context, builder, signature, args):
            kind = context.call_conv.get_function_type(types.none, FORM)
            function = cgutils.get_or_insert_function(builder.module, kind, name)
            context.call_conv.call_function(builder, function, types.none, FORM, args)
            return context.get_dummy_value()

        return types.none(*FORM), codegen

    @njit(**INTERNAL)
    def function(t, y, n, block, out):
        call(t, y, n, block, out)

    return function


@intrinsic
def inlined(typingctx, function, t, y, block):
    """The derivative as a tuple, by a compiled function of the common form.

    The block is an array, or an address.  y and the result pass through the stack, which the
    optimiser replaces by registers.
    """
    form = function.get_call_type(typingctx, FORM, {})
    n = len(y)

    def codegen(context, builder, signature, args):
        call = context.get_function(function, form)
        place = ir.ArrayType(ir.DoubleType(), n)
        given = cgutils.alloca_once(builder, place)
        found = cgutils.alloca_once(builder, place)
        for i in range(n):
            pointer = cgutils.gep(builder, given, 0, i)
            builder.store(builder.extract_value(args[2], i), pointer)
        first = [cgutils.gep(builder, p, 0, 0) for p in (given, found)]
        if block == types.int64:
            words = builder.inttoptr(args[3], ir.IntType(64).as_pointer())
        else:
            words = data_of(context, builder, WORDS, args[3])
        size = context.get_constant(types.intp, n)
        call(builder, (args[1], first[0], size, words, first[1]))
        parts = [builder.load(cgutils.gep(builder, found, 0, i)) for i in range(n)]
        return context.make_tuple(builder, y, parts)

    return y(function, types.float64, y, block), codegen
