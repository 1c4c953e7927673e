"""Vectors of real numbers as a number type: one operation acts on all lanes.

A `Vector` holds one double of each of `width` lanes, a `Mask` one truth value.  A function that is
written for numbers compiles for vectors as it stands, unless it branches on them.  Lanes never mix.
Products and sums may be fused, and elementary functions have formulas of their own.  `exact`
vectors do neither: each lane holds, to the last bit, what the same code makes of one number.
"""

import math
import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typeconv import Conversion
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin, lower_cast, models, register_model

FUSE = ("contract",)
NUMBERS = (types.Number, types.Boolean)
REAL, BIT, INDEX = ir.DoubleType(), ir.IntType(1), ir.IntType(32)


class Wide(types.Type):
    """Something in each of `width` lanes."""

    def __init__(self, width, exact=False):
        self.width, self.exact = width, exact
        super().__init__(name=f"{type(self).__name__}({width}{', exact' * exact})")


class Vector(Wide):
    """A double in each of `width` lanes."""

    def can_convert_from(self, typingctx, other):
        if isinstance(other, NUMBERS) and not isinstance(other, types.Complex):
            return Conversion.promote

    def unify(self, typingctx, other):
        if isinstance(other, NUMBERS) and not isinstance(other, types.Complex):
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


def is_real(ty):
    """Whether a vector can be made of it: a vector, a real number or a truth value."""
    return isinstance(ty, Vector | types.Float | types.Integer | types.Boolean)


def splat(builder, value, width):
    """A vector with `value` in each lane."""
    kind = ir.VectorType(value.type, width)
    if isinstance(value, ir.Constant):
        return ir.Constant(kind, [value.constant] * width)
    one = builder.insert_element(ir.Constant(kind, ir.Undefined), value, INDEX(0))
    zeros = ir.Constant(ir.VectorType(INDEX, width), None)
    return builder.shuffle_vector(one, ir.Constant(kind, ir.Undefined), zeros)


def constant(kind, a):
    """The number `a` as a component of LLVM type `kind`."""
    if isinstance(kind, ir.VectorType):
        return ir.Constant(kind, [float(a)] * kind.count)
    return ir.Constant(kind, float(a))


def widen(context, builder, ty, value, width):
    """A value of type `ty` as a vector."""
    if isinstance(ty, Vector):
        return value
    return splat(builder, context.cast(builder, value, ty, types.float64), width)


def intrinsic_of(builder, name, kind, n):
    """The LLVM intrinsic `name` from n vectors to one."""
    function = ir.FunctionType(kind, [kind] * n)
    return cgutils.get_or_insert_function(builder.module, function, f"llvm.{name}.v{kind.count}f64")


@lower_cast(types.Number, Vector)
@lower_cast(types.Boolean, Vector)
def _cast(context, builder, given, wanted, value):
    return widen(context, builder, given, value, wanted.width)


def vector_in(args):
    """The one type of the vectors among argument types, None if there is none or not one."""
    vectors = {a for a in args if isinstance(a, Vector)}
    return vectors.pop() if len(vectors) == 1 and all(map(is_real, args)) else None


def define(function, n, result, body, exact=None):
    """Teach Numba `function` of n arguments, some of them vectors.

    `body(context, builder, vectors)` gives the LLVM value, and `exact` that of exact vectors, for
    which there is no such function without; `result` is Vector or Mask.
    """

    @infer_global(function)
    class Template(AbstractTemplate):
        def generic(self, args, kws):
            vector = vector_in(args)
            if vector and len(args) == n and not kws and (exact or not vector.exact):
                return signature(result(vector.width, vector.exact), *[vector] * n)

    def code(context, builder, signature, args):
        chosen = exact if signature.args[0].exact else body
        return chosen(context, builder, args)

    lower_builtin(function, *[Vector] * n)(code)


def _define_same(function, n, result, body):
    define(function, n, result, body, body)


def _operation(name, flags):
    return lambda _, builder, v: getattr(builder, name)(*v, flags=flags)


def _named(name):
    def body(context, builder, v):
        return builder.call(intrinsic_of(builder, name, v[0].type, len(v)), v)

    return body


def _compared(sign):
    return lambda _, builder, v: builder.fcmp_ordered(sign, *v)


def _smaller(builder, v):
    """Python's min: the first unless the second is less."""
    return builder.select(builder.fcmp_ordered("<", v[1], v[0]), v[1], v[0])


def _larger(builder, v):
    return builder.select(builder.fcmp_ordered(">", v[1], v[0]), v[1], v[0])


def _or_nan(choose):
    """NumPy's maximum and minimum: NaN if either is."""

    def body(context, builder, v):
        unordered = builder.fcmp_unordered("uno", v[1], v[1])
        return builder.select(unordered, v[1], choose(builder, v))

    return body


ARITHMETIC = {"add": "fadd", "sub": "fsub", "mul": "fmul", "truediv": "fdiv"}
for _name, _code in ARITHMETIC.items():
    for _function in (getattr(operator, _name), getattr(operator, "i" + _name)):
        define(_function, 2, Vector, _operation(_code, FUSE), _operation(_code, ()))
for _function in (operator.neg, np.negative):
    _define_same(_function, 1, Vector, lambda _, builder, v: builder.fneg(v[0]))
for _function in (operator.pos, float, np.positive):
    _define_same(_function, 1, Vector, lambda _, builder, v: v[0])
for _name, _sign in (("lt", "<"), ("le", "<="), ("gt", ">"), ("ge", ">="), ("eq", "==")):
    _define_same(getattr(operator, _name), 2, Mask, _compared(_sign))
_define_same(operator.ne, 2, Mask, lambda _, builder, v: builder.fcmp_unordered("!=", *v))
for _function in (math.sqrt, np.sqrt):
    _define_same(_function, 1, Vector, _named("sqrt"))
for _function in (abs, math.fabs, np.abs, np.fabs):
    _define_same(_function, 1, Vector, _named("fabs"))
for _function in (np.floor, np.ceil, np.trunc, np.rint):
    _define_same(_function, 1, Vector, _named(_function.__name__))
for _function in (math.copysign, np.copysign):
    _define_same(_function, 2, Vector, _named("copysign"))
for _n in (2, 3, 4):
    for _function, _pair in ((min, _smaller), (max, _larger)):

        def _body(context, builder, v, pair=_pair):
            best = v[0]
            for other in v[1:]:
                best = pair(builder, (best, other))
            return best

        _define_same(_function, _n, Vector, _body)
_define_same(np.minimum, 2, Vector, _or_nan(_smaller))
_define_same(np.maximum, 2, Vector, _or_nan(_larger))


def _logic(function, operation):
    @infer_global(function)
    class Template(AbstractTemplate):
        def generic(self, args, kws):
            if len(args) == 2 and isinstance(args[0], Mask) and args[0] == args[1]:
                return signature(args[0], *args)

    @lower_builtin(function, Mask, Mask)
    def code(context, builder, signature, args):
        return getattr(builder, operation)(*args)


for _name, _code in (("and", "and_"), ("or", "or_"), ("xor", "xor")):
    _logic(getattr(operator, _code), _code)
    _logic(getattr(np, f"logical_{_name}"), _code)


def _negation(function):
    @infer_global(function)
    class Template(AbstractTemplate):
        def generic(self, args, kws):
            if len(args) == 1 and isinstance(args[0], Mask):
                return signature(args[0], args[0])

    @lower_builtin(function, Mask)
    def code(context, builder, signature, args):
        return builder.not_(args[0])


_negation(operator.invert)
_negation(np.logical_not)


def choose(context, builder, signature, args):
    """The value where the mask is true, else the other one."""
    width = signature.args[0].width
    pair = zip(signature.args[1:], args[1:], strict=True)
    return builder.select(args[0], *(widen(context, builder, *value, width) for value in pair))


@infer_global(np.where)
class Where(AbstractTemplate):
    """np.where(mask, a, b)."""

    def generic(self, args, kws):
        if len(args) == 3 and isinstance(args[0], Mask) and all(map(is_real, args[1:])):
            return signature(Vector(args[0].width, args[0].exact), *args)


for _kinds in ((a, b) for a in (Vector, *NUMBERS) for b in (Vector, *NUMBERS)):
    lower_builtin(np.where, Mask, *_kinds)(choose)
