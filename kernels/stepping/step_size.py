"""Where the step size is chosen: error norms, the first step, two controllers.

A controller is four functions: `smallest` (no step is shorter), `aim` (where the step to try ends),
`grow` (after acceptance), `shrink` (after a rejection; 0 where no step is left).  An error estimate
is accepted when its norm is below 1.  They choose by `select`, for numbers and vectors alike.

SCIPY is the rule of `scipy.integrate.RK45`, after Hairer, Norsett and Wanner, "Solving Ordinary
Differential Equations I", second edition, section II.4.  MATLAB is the rule of MATLAB's ode45,
after Shampine and Reichelt, "The MATLAB ODE suite", SIAM J. Sci. Comput. 18 (1997), in the form
that reproduces ode45's published step sequences.
"""

from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic, overload

from ..jit_options import BARE, FUSED, njit
from ..state.elementwise import constant
from ..state.fold import fold
from ..vector.number import Mask, Vector, splat

SAFETY = 0.9
MIN_FACTOR = 0.2
MAX_FACTOR = 10.0


class Controller(NamedTuple):
    """The decisions of an adaptive loop; see the functions of the same names below."""

    smallest: object
    aim: object
    grow: object
    shrink: object


@intrinsic
def select(typingctx, condition, a, b):
    """a where the condition holds, else b: numbers, or lanes of vectors."""
    if isinstance(condition, Mask):
        vector = Vector(condition.width, condition.exact)
        return vector(condition, vector, vector), lambda c, builder, s, v: builder.select(*v)
    number = types.float64
    return number(types.boolean, number, number), lambda c, builder, s, v: builder.select(*v)


@intrinsic
def spacing(typingctx, t, direction):
    """Distance from t to the next number in `direction`, |nextafter(t, direction * inf) - t|."""
    number = t if isinstance(t, Vector) else types.float64

    def codegen(context, builder, signature, args):
        t, direction = args
        kind = t.type
        whole, zero = ir.IntType(64), constant(kind, 0)
        if isinstance(kind, ir.VectorType):
            direction = splat(builder, direction, kind.count)
            whole = ir.VectorType(whole, kind.count)
        up = builder.fcmp_ordered(">", direction, zero)
        away = builder.icmp_signed("==", builder.fcmp_ordered(">", t, zero), up)
        bits = builder.bitcast(t, whole)
        step = builder.sub(builder.zext(away, whole), builder.zext(builder.not_(away), whole))
        after = builder.bitcast(builder.add(bits, step), kind)
        gap = builder.fsub(after, t)
        gap = builder.select(builder.fcmp_ordered("<", gap, zero), builder.fneg(gap), gap)
        return builder.select(builder.fcmp_ordered("==", t, zero), constant(kind, 5e-324), gap)

    return number(number, types.float64), codegen


def power(error, exponent):
    """error ** exponent, of vectors to a few roundings."""
    return error**exponent


@overload(power, jit_options=BARE)
def _power(error, exponent):
    if isinstance(error, Vector):
        return lambda error, exponent: _root(error, exponent)
    return lambda error, exponent: error**exponent


@intrinsic
def _near_power(typingctx, x, exponent):
    """x ** exponent to 4 %: the bits of a double, read as a number, are nearly its logarithm."""

    def codegen(context, builder, signature, args):
        x, exponent = args
        whole, shift = ir.VectorType(ir.IntType(64), x.type.count), 2.0**52
        twelve = ir.Constant(whole, [12] * x.type.count)
        head = builder.lshr(builder.bitcast(x, whole), twelve)
        number = builder.bitcast(
            builder.or_(head, builder.bitcast(constant(x.type, shift), whole)), x.type
        )
        scale = 2.0**-40
        logarithm = builder.fmul(
            builder.fsub(number, constant(x.type, shift)), constant(x.type, scale)
        )
        logarithm = builder.fsub(logarithm, constant(x.type, 1023 - 0.043))
        power = builder.fmul(splat(builder, exponent, x.type.count), logarithm)
        power = builder.fadd(power, constant(x.type, 1023 - 0.043))
        bits = builder.fadd(
            builder.fmul(power, constant(x.type, 1 / scale)), constant(x.type, shift)
        )
        return builder.bitcast(builder.shl(builder.bitcast(bits, whole), twelve), x.type)

    return x(x, types.float64), codegen


@njit(**FUSED)
def _root(x, exponent):
    """x ** exponent for exponent = -1/p or 1/p: steps of order 4 of z = z (x z^p)^(-1/p)."""
    down = -abs(exponent)
    p = int(np.rint(-1.0 / down))
    z = _near_power(x, down)
    a, b, c = 1.0 / p, (1.0 / p + 1.0) / 2.0, (1.0 / p + 2.0) / 3.0
    for _ in range(2 if p < 6 else 3):
        product = x * z
        for _ in range(p - 1):
            product = product * z
        r = 1.0 - product
        z = z + z * (a * r) * (1.0 + b * r * (1.0 + c * r))
    return z if exponent < 0.0 else 1.0 / z


@njit(**BARE)
def larger(a, b):
    """The larger of two numbers; NaN if either is, as np.maximum."""
    return select((b > a) | (b != b), b, a)


@njit(**BARE)
def _plus(a, b):
    return a + b


@njit(**BARE)
def _square_of_scaled(total, error, y, y_new, rtol, atol):
    x = error / (atol + larger(abs(y), abs(y_new)) * rtol)
    return total + x * x


@njit(**BARE)
def sum_of_squares(error, y, y_new, rtol, atol):
    """Sum of (error / (atol + rtol * max(|y|, |y_new|)))^2 over the components."""
    return fold(_square_of_scaled, _plus, 0.0, (error, y, y_new, rtol, atol))


@njit(**BARE)
def rms(error, y, y_new, rtol, atol):
    """Root mean square of the error over its tolerance: SciPy's norm."""
    return np.sqrt(sum_of_squares(error, y, y_new, rtol, atol) / len(error))


@njit(**BARE)
def _largest_scaled(total, error, y, y_new, rtol, atol):
    floor = atol / rtol
    size = larger(larger(abs(y), abs(y_new)), floor)
    return larger(total, abs(error) / size / rtol)


@njit(**BARE)
def largest(error, y, y_new, rtol, atol):
    """Largest |error| / max(|y|, |y_new|, atol / rtol) in units of rtol: MATLAB's norm."""
    return fold(_largest_scaled, larger, 0.0, (error, y, y_new, rtol, atol))


@njit(**BARE)
def _scipy_smallest(t, direction):
    return 10.0 * spacing(t, direction)


@njit(**BARE)
def _scipy_aim(t, h, t_end, direction):
    t_new = t + h * direction
    return select(direction * (t_new - t_end) > 0.0, t_end, t_new)


@njit(**BARE)
def _scipy_grow(h, error, exponent, rejections):
    factor = SAFETY * power(error, exponent)  # infinite where the error is zero
    factor = select(factor > MAX_FACTOR, MAX_FACTOR, factor)
    return h * select((rejections > 0) & (factor > 1.0), 1.0, factor)


@njit(**BARE)
def _scipy_shrink(h, error, exponent, rejections, h_min):
    factor = SAFETY * power(error, exponent)
    h = h * select(factor > MIN_FACTOR, factor, MIN_FACTOR)
    return select(h >= h_min, h, 0.0)


@njit(**BARE)
def _matlab_smallest(t, direction):
    return 16.0 * spacing(abs(t), 1.0)


@njit(**BARE)
def _matlab_aim(t, h, t_end, direction):
    return select(1.1 * h >= abs(t_end - t), t_end, t + h * direction)


@njit(**BARE)
def _matlab_grow(h, error, exponent, rejections):
    q = 1.25 * power(error, -exponent)
    return select(rejections > 0, h, select(q > 0.2, h / q, 5.0 * h))


@njit(**BARE)
def _matlab_shrink(h, error, exponent, rejections, h_min):
    factor = 0.8 * power(error, exponent)
    shorter = h * select(rejections > 0, 0.5, select(factor > 0.1, factor, 0.1))
    return select(h <= h_min, 0.0, select(shorter > h_min, shorter, h_min))


SCIPY = Controller(_scipy_smallest, _scipy_aim, _scipy_grow, _scipy_shrink)
MATLAB = Controller(_matlab_smallest, _matlab_aim, _matlab_grow, _matlab_shrink)
