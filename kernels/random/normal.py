"""Pairs of independent normal numbers on vectors, by the transformation of Box and Muller.

Source: Box, Muller, A note on the generation of random normal deviates, Annals of Mathematical
Statistics 29 (1958), https://doi.org/10.1214/aoms/1177706645.  The transformation has no branch,
which vectors need.  Its uniform numbers are multiples of 2^-52, so that no normal number exceeds
sqrt(104 log 2) = 8.49 (probability 2e-17).

LLVM, because Numba has no vectors.
"""

import math

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ..vector.emit import SHIFT, Lanes, bits, fma, real, sqrt, where, word
from ..vector.instructions import splat
from ..vector.logarithm import split, total
from ..vector.trigonometric import near_zero
from .philox import doubled, philox

ONE = word(1.0)
SIGN = 1 << 63
PI_2 = math.pi / 2
WHOLE = ir.IntType(64)


def _from_one(words):
    """Uniform numbers of [1, 2) from words of 64 bits."""
    return real((words >> 12) | ONE)


def normal_pair(words):
    """Two independent normal numbers from four random words."""
    below_one = 2.0 - _from_one(doubled(words[0], words[1]))  # of (0, 1]
    k, _, m = split(below_one)
    radius = sqrt(-2.0 * total(k, m, 0.0))
    quarters = fma(_from_one(doubled(words[2], words[3])), 4.0, -4.0)  # of [0, 4): the angle
    nearest = quarters + SHIFT
    pattern = bits(nearest)
    angle = (quarters - (nearest - SHIFT)) * PI_2
    (s, s_low), (c, c_low) = near_zero(angle, 0.0)
    sine = s + s_low
    cosine = c + c_low
    odd = (pattern << 63) < 0
    first = where(odd, sine, cosine)
    second = where(odd, cosine, sine)
    first = real(bits(first) ^ (((pattern + 1) << 62) & SIGN))
    second = real(bits(second) ^ ((pattern << 62) & SIGN))
    return radius * first, radius * second


def paths(width):
    """The constants 0, 1, ..., width - 1 as an LLVM vector."""
    return ir.Constant(ir.VectorType(WHOLE, width), list(range(width)))


@intrinsic
def normals(typingctx, form, key, path, step, source):
    """Two independent normal numbers for each lane: `path` + lane, a step and a source of noise."""
    vector = form.known.value.dtype

    def codegen(context, builder, signature, args):
        _, key, path, step, source = args

        def everywhere(value):
            return Lanes(builder, splat(builder, value, vector.width))

        number = everywhere(path) + Lanes(builder, paths(vector.width))
        counter = (everywhere(step), everywhere(step) >> 32, number, everywhere(source))
        words = philox(counter, (everywhere(key), everywhere(key) >> 32))
        pair = [x.value for x in normal_pair(words)]
        return context.make_tuple(builder, signature.return_type, pair)

    return types.UniTuple(vector, 2)(form, *[types.int64] * 4), codegen


@intrinsic
def everywhere(typingctx, form, number):
    """A number in each lane of one vector."""
    vector = form.known.value.dtype

    def codegen(context, builder, signature, args):
        return splat(builder, args[1], vector.width)

    return vector(form, types.float64), codegen
