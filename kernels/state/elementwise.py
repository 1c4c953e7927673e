"""Operations on values of the state, for every storage; no other file knows the storage.

A value is a tuple of numbers (small n: the compiler keeps it in registers), a row of the work
array (any n), or a tuple of vectors, each with one component of several states.  The functions here
generate code: a step written with the functions becomes straight-line code for a tuple and one loop
for a row.  Tuples, rows and vectors give equal bits, because each component passes through equal
operations in equal order.  A product and the sum to which it is added have one rounding, where the
processor has an instruction for both (FMA): RK45 then takes 0.91 of the time for satellite and
pendulum (Intel), because each stage waits for the last product and sum, twice.

LLVM, because Numba maps no function over a tuple, and would compile one for each row of
coefficients.  `halves` and `join` with Numba's slices give equal bits, but a step of KahanLi8 on
rows takes 2.5 % longer (160 instead of 156 ms for 300 000 steps of two numbers).

Everywhere `out` is the row that receives the result, or None for tuples.
"""

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

from ..jit.arrays import borrowed, field_of
from ..vector.instructions import constant, fuse
from ..vector.number import Vector

ROW = types.Array(types.float64, 1, "C")


def length_of(context, builder, ty, value):
    return field_of(context, builder, ty, value, "shape", 0)


def data_of(context, builder, ty, value):
    return field_of(context, builder, ty, value, "data")


def view(context, builder, pointer, n):
    """A C-contiguous float64 array over borrowed memory."""
    return borrowed(context, builder, ROW, pointer, [n])


def map_components(context, builder, outs, operands, body):
    """Write the results of body(builder, [component of each operand]) for each component.

    `outs` and `operands` are lists of (type, value); the body returns one result for each item of
    `outs`.  Returns a list of tuple values or the rows `outs`.
    """
    ty, value = operands[0]
    if isinstance(ty, types.BaseTuple):
        results = [
            body(builder, [builder.extract_value(v, i) for _, v in operands])
            for i in range(len(ty))
        ]
        return [context.make_tuple(builder, ty, part) for part in zip(*results, strict=True)]
    pointers = [data_of(context, builder, t, v) for t, v in operands]
    targets = [data_of(context, builder, *out) for out in outs]
    with cgutils.for_range(builder, length_of(context, builder, ty, value)) as loop:
        components = [builder.load(builder.gep(p, [loop.index])) for p in pointers]
        for result, target in zip(body(builder, components), targets, strict=True):
            builder.store(result, builder.gep(target, [loop.index]))
    return [value for _, value in outs]


def element(value):
    """Type of one component of a value."""
    return value.dtype if isinstance(value, types.BaseTuple) else types.float64


@intrinsic
def apply(typingctx, function, outs, numbers, values):
    """The results of ``function(*numbers, *components)`` for each component of `values`.

    The compiled function returns a tuple with one component of each new value.  `outs` are the
    places of the new values.
    """
    n = len(outs)
    kind, *_ = values
    inner = function.get_call_type(typingctx, (*numbers, *map(element, values)), {})

    def codegen(context, builder, signature, args):
        call = context.get_function(function, inner)
        places, first, operands = (
            [(t, builder.extract_value(whole, i)) for i, t in enumerate(kinds)]
            for kinds, whole in zip(signature.args[1:], args[1:], strict=True)
        )

        def body(builder, components):
            found = call(builder, [*(v for _, v in first), *components])
            return [builder.extract_value(found, i) for i in range(n)]

        results = map_components(context, builder, places, operands, body)
        return context.make_tuple(builder, signature.return_type, results)

    return types.UniTuple(kind, n)(function, outs, numbers, values), codegen


def _map(context, builder, out, operands, body):
    """`map_components` for one result."""
    one = map_components(context, builder, [out], operands, lambda b, c: (body(b, c),))
    return one[0]


def factor(value):
    """Type of a number that multiplies the components of a value."""
    return element(value) if isinstance(element(value), Vector) else types.float64


def _weighted_map(row, k, start=None):
    """The code of h sum(a_i k_i), or of start + h sum(a_i k_i), from left to right.

    The sum omits each a_i that is zero, except the last a_i of a Row that is `to_the_end`.  The
    arguments are out, the start, h, the row and the k_i.
    """
    if len(row.known.exact) != len(k):
        raise ValueError(f"{len(row.known.exact)} coefficients for {len(k)} values")
    last = len(k) - 1 if row.known.to_the_end else None
    used = [(i, a) for i, a in enumerate(row.known.exact) if a != 0 or i == last]
    first = [] if start is None else [start]

    def codegen(context, builder, signature, args):
        out, *given, h, _, stages = args
        operands = [*zip(first, given, strict=True)]
        operands += [(k[i], builder.extract_value(stages, i)) for i, _ in used]

        def body(builder, c):
            total = None
            for (_, a), x in zip(used, c[len(first) :], strict=True):
                a = constant(x.type, a)
                total = builder.fmul(a, x) if total is None else fuse(builder, a, x, total)
            return fuse(builder, h, total, c[0]) if first else builder.fmul(h, total)

        return _map(context, builder, (signature.args[0], out), operands, body)

    return codegen


@intrinsic
def combine(typingctx, out, y, h, row, k):
    """y + h * sum(a_i k_i)."""
    return y(out, y, factor(y), row, k), _weighted_map(row, k, y)


@intrinsic
def weigh(typingctx, out, h, row, k):
    """h * sum(a_i k_i)."""
    return k[0](out, factor(k[0]), row, k), _weighted_map(row, k)


@intrinsic
def assign(typingctx, out, value):
    """A copy of `value` in `out`; a tuple is its own copy."""

    def codegen(context, builder, signature, args):
        return _map(context, builder, (out, args[0]), [(value, args[1])], lambda b, c: c[0])

    return value(out, value), codegen


def load(builder, pointer):
    value = builder.load(pointer)
    value.align = 8  # also for a vector, because rows are aligned to numbers only
    return value


@intrinsic
def halves(typingctx, value):
    """The two halves of a value, (q, v) of a state [q, v]; (None, None) for None."""
    if isinstance(value, types.NoneType):
        none = types.Tuple((types.none, types.none))
        return none(value), lambda c, b, s, a: c.make_tuple(b, none, [c.get_dummy_value()] * 2)
    if value == ROW:
        pair = types.UniTuple(ROW, 2)

        def split(context, builder, signature, args):
            m = builder.lshr(length_of(context, builder, ROW, args[0]), ir.IntType(64)(1))
            data = data_of(context, builder, ROW, args[0])
            parts = [data, builder.gep(data, [m])]
            return context.make_tuple(builder, pair, [view(context, builder, p, m) for p in parts])

        return pair(value), split
    m = len(value) // 2
    half = types.UniTuple(value.dtype, m)

    def codegen(context, builder, signature, args):
        parts = [builder.extract_value(args[0], i) for i in range(2 * m)]
        both = [context.make_tuple(builder, half, p) for p in (parts[:m], parts[m:])]
        return context.make_tuple(builder, signature.return_type, both)

    return types.UniTuple(half, 2)(value), codegen


@intrinsic
def join(typingctx, out, first, second):
    """The value [first, second]; the halves of the row `out` are in place already."""
    if first == ROW:
        return ROW(out, first, second), lambda c, b, s, a: a[0]
    whole = types.UniTuple(first.dtype, len(first) + len(second))

    def codegen(context, builder, signature, args):
        parts = [builder.extract_value(v, i) for v in args[1:] for i in range(len(first))]
        return context.make_tuple(builder, whole, parts)

    return whole(out, first, second), codegen
