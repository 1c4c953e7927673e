"""Vectors of real numbers as a number type: one operation acts on all lanes.

A `Vector` holds one double for each of `width` lanes, a `Mask` one truth value.  A kernel that is
written for numbers compiles for vectors without a change, unless the kernel branches on numbers.
Lanes never mix.  Products and sums may be fused, except on `exact` vectors: there, each lane holds,
to the last bit, the result of the code for one number.

LLVM, because Numba has no type for the vectors of a processor.
"""

import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, lower_cast, models, register_model

from .instructions import BIT, FUSE, REAL, intrinsic_of, splat

NUMBERS = (types.Float, types.Integer, types.Boolean)


class Wide(types.Type):
    """A value in each of `width` lanes."""

    def __init__(self, width, exact=False):
        self.width = width
        self.exact = exact
        super().__init__(name=f"{type(self).__name__}({width}{', exact' * exact})")


class Vector(Wide):
    """A double in each of `width` lanes."""

    def can_convert_from(self, typingctx, other):
        if isinstance(other, NUMBERS):
            return Conversion.promote

    def unify(self, typingctx, other):
        if isinstance(other, NUMBERS):
            return self


class Mask(Wide):
    """A truth value in each of `width` lanes."""


@register_model(Vector)
class VectorModel(models.PrimitiveModel):
    def __init__(self, manager, ty):
        super().__init__(manager, ty, ir.VectorType(REAL, ty.width))


@register_model(Mask)
class MaskModel(models.PrimitiveModel):
    def __init__(self, manager, ty):
        super().__init__(manager, ty, ir.VectorType(BIT, ty.width))


@lower_cast(types.Number, Vector)
@lower_cast(types.Boolean, Vector)
def _cast(context, builder, given, wanted, value):
    return splat(builder, context.cast(builder, value, given, types.float64), wanted.width)


def _teach(function, kinds, typed, code):
    """Teach Numba `function` of arguments of the classes `kinds`.

    ``typed(args)`` is its signature for arguments of these types, or None; ``code(context, builder,
    signature, args)`` gives the LLVM value, for arguments of the types of the signature.
    """

    @infer_global(function)
    class Template(AbstractTemplate):
        def generic(self, args, kws):
            return None if kws else typed(args)

    lower_builtin(function, *kinds)(code)


def _define(function, n, result, body):
    """Teach Numba `function` of n arguments, numbers and at least one vector.

    ``body(builder, vectors, flags)`` gives the LLVM value; `result` is Vector or Mask.
    """

    def typed(args):
        vectors = {a for a in args if isinstance(a, Vector)}
        known = all(isinstance(a, (Vector, *NUMBERS)) for a in args)
        if len(args) == n and len(vectors) == 1 and known:
            (vector,) = vectors
            return signature(result(vector.width, vector.exact), *[vector] * n)

    def code(context, builder, signature, args):
        return body(builder, args, () if signature.args[0].exact else FUSE)

    _teach(function, [Vector] * n, typed, code)


def _arithmetic(name):
    return lambda builder, v, flags: getattr(builder, name)(*v, flags=flags)


def _compared(sign):
    return lambda builder, v, _: builder.fcmp_ordered(sign, *v)


def _intrinsic(name):
    return lambda builder, v, _: builder.call(intrinsic_of(builder, name, v[0].type, 1), v)


for _name, _code in (("add", "fadd"), ("sub", "fsub"), ("mul", "fmul"), ("truediv", "fdiv")):
    for _function in (getattr(operator, _name), getattr(operator, "i" + _name)):
        _define(_function, 2, Vector, _arithmetic(_code))
for _name, _sign in (("lt", "<"), ("le", "<="), ("gt", ">"), ("ge", ">="), ("eq", "==")):
    _define(getattr(operator, _name), 2, Mask, _compared(_sign))
_define(operator.ne, 2, Mask, lambda builder, v, _: builder.fcmp_unordered("!=", *v))
_define(operator.neg, 1, Vector, lambda builder, v, _: builder.fneg(v[0]))
_define(np.sqrt, 1, Vector, _intrinsic("sqrt"))
_define(abs, 1, Vector, _intrinsic("fabs"))


def _define_of_masks(function, n, name):
    def typed(args):
        if len(args) == n and isinstance(args[0], Mask) and len(set(args)) == 1:
            return signature(args[0], *args)

    def code(context, builder, signature, args):
        return getattr(builder, name)(*args)

    _teach(function, [Mask] * n, typed, code)


for _function, _code in ((operator.and_, "and_"), (operator.or_, "or_")):
    _define_of_masks(_function, 2, _code)
_define_of_masks(operator.invert, 1, "not_")
