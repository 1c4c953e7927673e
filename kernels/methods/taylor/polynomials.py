"""Sums of the series, for vectors of components and for vectors of trajectories.

The coefficients of a vector lie `stride` numbers apart.  Four sums, each of every fourth term, run
side by side; an order is one more than a multiple of four.

LLVM, because it fuses by itself the product that the next sum does not wait for.
"""

from numba.extending import intrinsic

from ...jit.options import INLINED, njit
from ...state.rows import vector_at
from ...vector.instructions import intrinsic_of, splat


@intrinsic
def fused(typingctx, a, b, c):
    """a b + c for vectors a and c and a number or vector b, where the processor has it in one."""

    def codegen(context, builder, signature, args):
        a, factor, c = args
        factor = factor if b == signature.return_type else splat(builder, factor, a.type.count)
        return builder.call(intrinsic_of(builder, "fmuladd", a.type, 3), [a, factor, c])

    return a(a, b, c), codegen


def sums(form, order):
    """``ends(room, place, stride, x, low)``: the state at x, its rounding error, its slope.

    `low` is the rounding error of the state at 0; the slope is in the unit of the series.
    """

    @njit(**INLINED)
    def ends(room, place, stride, x, low):
        x2 = x * x
        x4 = x2 * x2
        k = float(order)
        at = place + order * stride
        a = vector_at(form, room, at)
        b = vector_at(form, room, at - 3 * stride)
        c = vector_at(form, room, at - 2 * stride)
        d = vector_at(form, room, at - stride)
        slope_a = a * k
        slope_b = b * (k - 3.0)
        slope_c = c * (k - 2.0)
        slope_d = d * (k - 1.0)
        for _ in range(order // 4 - 1):
            at = at - 4 * stride
            k = k - 4.0
            term = vector_at(form, room, at)
            a = fused(a, x4, term)
            slope_a = fused(slope_a, x4, term * k)
            term = vector_at(form, room, at - 3 * stride)
            b = fused(b, x4, term)
            slope_b = fused(slope_b, x4, term * (k - 3.0))
            term = vector_at(form, room, at - 2 * stride)
            c = fused(c, x4, term)
            slope_c = fused(slope_c, x4, term * (k - 2.0))
            term = vector_at(form, room, at - stride)
            d = fused(d, x4, term)
            slope_d = fused(slope_d, x4, term * (k - 1.0))
        term = vector_at(form, room, place + stride)
        y = vector_at(form, room, place)
        a = fused(a, x4, term)
        slope_a = fused(slope_a, x4, term)
        rise = ((d * x + c) * x2 + (b * x + a)) * x + low
        value = y + rise
        slope = (slope_d * x + slope_c) * x2 + (slope_b * x + slope_a)
        return value, rise - (value - y), slope

    return ends


def motions(form, order):
    """``motion(room, place, stride, x)``: the sum of |c[k]| x^k for 0 < k <= order, below order 4m.

    The order is a multiple of four.
    """

    @njit(**INLINED)
    def motion(room, place, stride, x):
        x2 = x * x
        x4 = x2 * x2
        at = place + order * stride
        a = vector_at(form, room, at) * 0.0
        b = a
        c = a
        d = a
        for _ in range(order // 4):
            a = a * x4 + abs(vector_at(form, room, at))
            b = b * x4 + abs(vector_at(form, room, at - stride))
            c = c * x4 + abs(vector_at(form, room, at - 2 * stride))
            d = d * x4 + abs(vector_at(form, room, at - 3 * stride))
            at -= 4 * stride
        return ((a * x + b) * x2 + (c * x + d)) * x

    return motion
