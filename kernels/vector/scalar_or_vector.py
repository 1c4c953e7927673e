"""Functions for the control of steps that take numbers and vectors.

LLVM, because Numba has no choice without a branch, which vectors need, does not say which branch is
rare, and does not read the bits of a double as a number.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from ..jit.options import INLINED, INTERNAL, njit
from .emit import Lanes, bits, real, where, word
from .instructions import BIT, declared, fuse, splat
from .number import Mask, Vector


@intrinsic
def select(typingctx, condition, a, b):
    """a where the condition holds, else b: numbers, or lanes of vectors."""
    if isinstance(condition, Mask):
        vector = Vector(condition.width, condition.exact)
        return vector(condition, vector, vector), lambda c, builder, s, v: builder.select(*v)
    number = types.float64
    return number(types.boolean, number, number), lambda c, builder, s, v: builder.select(*v)


@intrinsic
def rare(typingctx, condition):
    """A condition that seldom holds: on numbers, what depends on the condition becomes a branch.

    A choice waits for its condition; a branch that is foreseen does not.  With branches between two
    steps, RK45 takes 0.94 of the time for satellite and pendulum (Intel, AVX-512).
    """
    if isinstance(condition, Mask):
        return condition(condition), lambda c, builder, s, v: v[0]

    def codegen(context, builder, signature, args):
        expect = declared(builder.module, ir.FunctionType(BIT, [BIT, BIT]), "llvm.expect.i1")
        return builder.call(expect, [args[0], BIT(0)])

    return types.boolean(types.boolean), codegen


@intrinsic
def fused(typingctx, a, b, c):
    """a b + c, rounded once where the processor has an instruction for that."""
    number = a if isinstance(a, Vector) else types.float64
    return number(number, number, number), lambda context, builder, s, v: fuse(builder, *v)


@intrinsic
def spacing(typingctx, t, direction):
    """Distance from t to the next number in `direction`, |nextafter(t, direction * inf) - t|."""
    number = t if isinstance(t, Vector) else types.float64

    def codegen(context, builder, signature, args):
        t = Lanes(builder, args[0])
        direction = Lanes(builder, splat(builder, args[1], t.count) if t.count else args[1])
        away = (t > 0.0) == (direction > 0.0)
        gap = abs(real(where(away, bits(t) + 1, bits(t) - 1)) - t)
        return where(t == 0.0, 5e-324, gap).value

    return number(number, types.float64), codegen


def power(error, exponent):
    """error ** exponent; on vectors, with an error of a few roundings."""
    return error**exponent


@overload(power, jit_options=INTERNAL)
def _power(error, exponent):
    if isinstance(error, Vector):
        return lambda error, exponent: _root(error, exponent)
    return lambda error, exponent: error**exponent


@intrinsic
def _near_power(typingctx, x, exponent):
    """x ** exponent to 4 %: the bits of a double, read as a number, are nearly its logarithm."""

    def codegen(context, builder, signature, args):
        x = Lanes(builder, args[0])
        exponent = splat(builder, args[1], x.value.type.count)
        number = real((bits(x) >> 12) | word(2.0**52))
        logarithm = (number - 2.0**52) * 2.0**-40 - (1023 - 0.043)
        power = Lanes(builder, exponent) * logarithm + (1023 - 0.043)
        return real(bits(power * 2.0**40 + 2.0**52) << 12).value

    return x(x, types.float64), codegen


@njit(**INLINED)
def _root(x, exponent):
    """x ** exponent for exponent = -1/p or 1/p: steps of order 4 of z = z (x z^p)^(-1/p)."""
    down = -abs(exponent)
    p = int(np.rint(-1.0 / down))
    z = _near_power(x, down)
    a = 1.0 / p
    b = (1.0 / p + 1.0) / 2.0
    c = (1.0 / p + 2.0) / 3.0
    for _ in range(2 if p < 6 else 3):
        product = x * z
        for _ in range(p - 1):
            product = product * z
        r = 1.0 - product
        z = z + z * (a * r) * (1.0 + b * r * (1.0 + c * r))
    return z if exponent < 0.0 else 1.0 / z


@intrinsic
def any_lane(typingctx, mask):
    """Whether a mask is true in any lane."""

    def codegen(context, builder, signature, args):
        bits = builder.bitcast(args[0], ir.IntType(mask.width))
        return builder.icmp_unsigned("!=", bits, bits.type(0))

    return types.boolean(mask), codegen
