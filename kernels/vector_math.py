"""Elementary functions of vectors."""

import math
import operator

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.typing.templates import signature
from numba.extending import intrinsic, overload

from . import vector_arc, vector_exp, vector_log, vector_trig
from .calls import BARE
from .vector import INDEX, Vector, define, is_real
from .vector_code import routine


def by_lanes(scalar, n):
    """Body of a function of n vectors that calls the scalar one for each lane."""

    def body(context, builder, v):
        kind = v[0].type
        kinds = signature(types.float64, *[types.float64] * n)
        function = context.get_function(scalar, kinds)
        result = ir.Constant(kind, ir.Undefined)
        for i in range(kind.count):
            parts = [builder.extract_element(x, INDEX(i)) for x in v]
            result = builder.insert_element(result, function(builder, parts), INDEX(i))
        return result

    return body


FORMULAS = {
    vector_trig.tangent: (math.tan, np.tan),
    vector_arc.arc_sine: (math.asin, np.arcsin),
    vector_arc.arc_cosine: (math.acos, np.arccos),
    vector_arc.arc_tangent: (math.atan, np.arctan),
    vector_arc.arc_tangent_of_two: (math.atan2, np.arctan2),
    vector_arc.hypotenuse: (math.hypot, np.hypot),
    vector_exp.exponential: (math.exp, np.exp),
    vector_exp.exponential_less_one: (math.expm1, np.expm1),
    vector_exp.hyperbolic_sine: (math.sinh, np.sinh),
    vector_exp.hyperbolic_cosine: (math.cosh, np.cosh),
    vector_exp.hyperbolic_tangent: (math.tanh, np.tanh),
    vector_log.logarithm: (math.log, np.log),
    vector_log.logarithm_of_one_plus: (math.log1p, np.log1p),
    vector_log.logarithm_2: (math.log2, np.log2),
    vector_log.logarithm_10: (math.log10, np.log10),
}
TWO = {math.atan2, np.arctan2, math.hypot, np.hypot}
for _formula, _functions in FORMULAS.items():
    for _function in _functions:
        define(_function, 2 if _function in TWO else 1, Vector, routine(_formula))
for _part, _functions in enumerate(((math.sin, np.sin), (math.cos, np.cos))):
    for _function in _functions:
        define(_function, 1, Vector, routine(vector_trig.sine_cosine, _part))

BY_LANES = {
    math.asinh: (np.arcsinh,),
    math.acosh: (np.arccosh,),
    math.atanh: (np.arctanh,),
    math.erf: (),
}
for _function, _others in BY_LANES.items():
    for _name in (_function, *_others):
        define(_name, 1, Vector, by_lanes(_function, 1))


@intrinsic
def _power_of(typingctx, a, b):
    vector = a if isinstance(a, Vector) else b
    return vector(vector, vector), lambda c, builder, s, v: routine(vector_log.power)(c, builder, v)


@intrinsic(prefer_literal=True)
def _whole_power(typingctx, a, n):
    """a^n by repeated squaring, in the order in which Numba multiplies numbers."""

    def codegen(context, builder, signature, args):
        one = ir.Constant(args[0].type, [1.0] * a.width)
        result, square, left = one, args[0], abs(n.literal_value)
        while left:
            if left & 1:
                result = square if result is one else builder.fmul(result, square)
            left >>= 1
            if left:
                square = builder.fmul(square, square)
        return builder.fdiv(one, result) if n.literal_value < 0 else result

    return a(a, n), codegen


def _power(a, b):
    if isinstance(a, Vector) and isinstance(b, types.IntegerLiteral) and abs(b.literal_value) < 64:
        return lambda a, b: _whole_power(a, b)
    if (isinstance(a, Vector) and is_real(b)) or (isinstance(b, Vector) and is_real(a)):
        return lambda a, b: _power_of(a, b)


for _function in (operator.pow, operator.ipow, math.pow, np.power):
    overload(_function, jit_options=BARE, prefer_literal=True)(_power)
