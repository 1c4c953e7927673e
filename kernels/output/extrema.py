"""The largest and the smallest value of each component along a trajectory, and when.

Both values are those of the interpolant.  Few steps need the interpolant: a maximum lies inside a
step only if the slope changes sign in the step.  The maximum is at most the mean of the tangents of
both ends at the middle of the step; this bound is compared first, in all lanes at once.
"""

from ..jit.options import INLINED, INTERNAL, njit
from ..state.elementwise import apply
from ..state.record import Y
from ..state.reduce import add, reduce_components
from ..vector.scalar_or_vector import select

MAX, T_MAX, MIN, T_MIN = range(4)  # rows of the result
N_ITERATIONS = 60  # 47 halvings would reach TOLERANCE
TOLERANCE = 1e-14  # of the place in a step, as a share of the step


@njit(**INLINED)
def _turns(h, y, y_new, f, f_new, top, low):
    rise = h * f
    fall = h * f_new
    bound = 0.5 * (y + y_new) + 0.25 * (rise - fall)
    over = (rise >= 0.0) & (fall <= 0.0) & (bound > top)
    under = (rise <= 0.0) & (fall >= 0.0) & (bound < low)
    return (select(over | under, 1.0, 0.0),)


@njit(**INLINED)
def turning(h, y, y_new, k, k_new, tops, lows):
    """Lanes in which a component may exceed `tops` or fall below `lows` inside the step."""
    turns = apply(_turns, (None,), (h,), (y, y_new, k, k_new, tops, lows))
    return reduce_components(add, add, 0.0, turns) > 0.0


@njit(**INTERNAL)
def _value_and_slope(d, i, x):
    """Component i of the polynomial d of a step, and its derivative with respect to x."""
    total = 0.0
    slope = 0.0
    for j in range(d.shape[0] - 1, 0, -1):
        total += d[j, i]
        if (j - 1) % 2 == 0:
            slope = slope * x + total
            total *= x
        else:
            slope = slope * (1.0 - x) - total
            total *= 1.0 - x
    return d[0, i] + total, slope


@njit(**INTERNAL)
def _turn(d, i, a, b, fa, fb):
    """The place in [a, b] at which the slope is zero, by the Illinois variant of regula falsi."""
    for _ in range(N_ITERATIONS):
        x = (a * fb - b * fa) / (fb - fa)
        if abs(b - a) <= TOLERANCE or x == a or x == b:
            break
        fx = _value_and_slope(d, i, x)[1]
        if fx == 0.0:
            break
        if (fx > 0.0) == (fb > 0.0):
            fa *= 0.5
        else:
            a = b
            fa = fb
        b = x
        fb = fx
    return x


@njit(**INTERNAL)
def note_state(best, t, work):
    """Update the extrema with the state in row Y at time t."""
    for i in range(best.shape[1]):
        if not work[Y, i] <= best[MAX, i]:
            best[MAX, i] = work[Y, i]
            best[T_MAX, i] = t
        if not work[Y, i] >= best[MIN, i]:
            best[MIN, i] = work[Y, i]
            best[T_MIN, i] = t


@njit(**INTERNAL)
def note_step(best, d, t_old, h, x_end):
    """Update the extrema with the interpolant d of a step between the start and x_end."""
    for i in range(best.shape[1]):
        fa = _value_and_slope(d, i, 0.0)[1]
        fb = _value_and_slope(d, i, x_end)[1]
        if fa * fb < 0.0:
            x = _turn(d, i, 0.0, x_end, fa, fb)
            value = _value_and_slope(d, i, x)[0]
            if value > best[MAX, i]:
                best[MAX, i] = value
                best[T_MAX, i] = t_old + x * h
            if value < best[MIN, i]:
                best[MIN, i] = value
                best[T_MIN, i] = t_old + x * h
