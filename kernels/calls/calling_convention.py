"""The calling convention of kernels: arguments in words of 8 bytes.

Every kernel has one compiled form, ``int64 kernel(int64 *words)``, for calls from Python and from
other kernels.  A number takes one word.  An array takes the word of its address and the words of
its shape.  A named tuple takes the words of its fields.  Arrays are C-contiguous; the caller keeps
arrays alive.

LLVM, because Numba has no call at an address, and no words for arguments of any type.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..jit.arrays import borrowed, field_of, shape_of

WORD = ir.IntType(64)


def n_words(ty):
    """The number of words of an argument of this type."""
    if isinstance(ty, types.BaseTuple):
        return sum(map(n_words, ty.types))
    if isinstance(ty, types.Record):
        return 2
    return 1 + ty.ndim if isinstance(ty, types.Array) else 1


def array_of(context, builder, ty, words):
    """Build an array from the next of `words`: the address, then the lengths of the axes."""
    data = builder.inttoptr(next(words), context.get_value_type(types.CPointer(ty.dtype)))
    return borrowed(context, builder, ty, data, [next(words) for _ in range(ty.ndim)])


def values_of(context, builder, tys, pointer):
    """The arguments that the words at `pointer` hold."""

    def loads():
        at = 0
        while True:
            yield builder.load(cgutils.gep(builder, pointer, at))
            at += 1

    words = loads()
    return [_value_of(context, builder, ty, words) for ty in tys]


def _value_of(context, builder, ty, words):
    if isinstance(ty, types.BaseTuple):
        parts = [_value_of(context, builder, part, words) for part in ty.types]
        return context.make_tuple(builder, ty, parts)
    if isinstance(ty, types.Array):
        return array_of(context, builder, ty, words)
    if ty == types.float64:
        return builder.bitcast(next(words), ir.DoubleType())
    if ty == types.int64:
        return next(words)
    raise TypeError(f"a kernel takes no argument of type {ty}")


def words_of(context, builder, tys, values):
    """The words of arguments, as a list of integers."""
    words = []
    for ty, value in zip(tys, values, strict=True):
        if isinstance(ty, types.BaseTuple):
            parts = [builder.extract_value(value, i) for i in range(len(ty.types))]
            words += words_of(context, builder, ty.types, parts)
        elif isinstance(ty, types.Array):
            data = field_of(context, builder, ty, value, "data")
            words += [builder.ptrtoint(data, WORD), *shape_of(context, builder, ty, value)]
        elif isinstance(ty, types.Record):  # an array of one record
            words += [builder.ptrtoint(value, WORD), WORD(1)]
        elif isinstance(ty, types.Float):
            real = context.cast(builder, value, ty, types.float64)
            words.append(builder.bitcast(real, WORD))
        else:
            words.append(context.cast(builder, value, ty, types.int64))
    return words


@intrinsic
def call_kernel(typingctx, address, words):
    """Call the kernel at `address` with the words at the address `words`; returns its status."""

    def codegen(context, builder, signature, args):
        kind = ir.FunctionType(WORD, [WORD.as_pointer()])
        kernel = builder.inttoptr(args[0], kind.as_pointer())
        return builder.call(kernel, [builder.inttoptr(args[1], WORD.as_pointer())])

    return types.int64(types.int64, types.int64), codegen


@intrinsic
def invoke(typingctx, address, given):
    """Call the kernel at `address` with a tuple of arguments; returns its status."""
    room = sum(map(n_words, given))

    def codegen(context, builder, signature, args):
        place = cgutils.alloca_once(builder, ir.ArrayType(WORD, room))
        parts = [builder.extract_value(args[1], i) for i in range(len(given))]
        for i, word in enumerate(words_of(context, builder, given, parts)):
            builder.store(word, cgutils.gep(builder, place, 0, i))
        kind = ir.FunctionType(WORD, [WORD.as_pointer()])
        kernel = builder.inttoptr(args[0], kind.as_pointer())
        return builder.call(kernel, [cgutils.gep(builder, place, 0, 0)])

    return types.int64(types.int64, given), codegen
