"""Sums of the series, for vectors of components and for vectors of trajectories.

The coefficients of a vector lie `stride` numbers apart.  Four sums, each of every fourth term, run
side by side; an order is one more than a multiple of four.
"""

from ...jit_options import INLINED, njit
from ...state.rows import vector_at


def sums(form, order):
    """``ends(room, place, stride, x, low)``: the state at x, its rounding error, its slope.

    `low` is the rounding error of the state at 0; the slope is in the unit of the series.
    """

    @njit(**INLINED)
    def ends(room, place, stride, x, low):
        x2 = x * x
        x4 = x2 * x2
        at, k = place + order * stride, float(order)
        a = vector_at(form, room, at)
        b = a * k
        d, c, e = a * 0.0, a * 0.0, a * 0.0
        slope_d, slope_c, slope_e = d, d, d
        for _ in range(order // 4):
            term = vector_at(form, room, at - stride)
            d, slope_d = d * x4 + term, slope_d * x4 + term * (k - 1.0)
            term = vector_at(form, room, at - 2 * stride)
            c, slope_c = c * x4 + term, slope_c * x4 + term * (k - 2.0)
            term = vector_at(form, room, at - 3 * stride)
            e, slope_e = e * x4 + term, slope_e * x4 + term * (k - 3.0)
            at, k = at - 4 * stride, k - 4.0
            term = vector_at(form, room, at)
            a, b = a * x4 + term, b * x4 + term * k
        y = vector_at(form, room, place)
        rise = ((d * x + c) * x2 + (e * x + a)) * x + low
        value = y + rise
        slope = (slope_d * x + slope_c) * x2 + (slope_e * x + b)
        return value, rise - (value - y), slope

    return ends


def motions(form, order):
    """``motion(room, place, stride, x)``: the sum of |c[k]| x^k for 0 < k <= order, below order 4m.

    The order is a multiple of four.
    """

    @njit(**INLINED)
    def motion(room, place, stride, x):
        x2 = x * x
        x4, at = x2 * x2, place + order * stride
        a = vector_at(form, room, at) * 0.0
        b, c, d = a, a, a
        for _ in range(order // 4):
            a = a * x4 + abs(vector_at(form, room, at))
            b = b * x4 + abs(vector_at(form, room, at - stride))
            c = c * x4 + abs(vector_at(form, room, at - 2 * stride))
            d = d * x4 + abs(vector_at(form, room, at - 3 * stride))
            at -= 4 * stride
        return ((a * x + b) * x2 + (c * x + d)) * x

    return motion
