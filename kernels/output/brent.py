"""The zero of an event function inside a step, by Brent's method.

R. P. Brent, "Algorithms for Minimization without Derivatives" (1973), chapter 4.
"""

from ..calls.user_function import call_function, raised
from ..jit.options import INLINED, INTERNAL, njit
from .arguments import COUNTS, TOLERANCE
from .dense_output import polynomial

N_ITERATIONS = 100  # as in SciPy
STAYS_FOR = 2.0**-20  # share of a distance from a zero within which a function stays zero


@njit(**INTERNAL)
def resolution(t, unit):
    """The uncertainty of a root near t; see `unit` of EVENTS."""
    return TOLERANCE * unit + TOLERANCE * abs(t)


@njit(**INTERNAL)
def value(event, d, t_old, h, t, y, out):
    """The event function on the interpolant, at time t; y and out are scratch rows."""
    polynomial(d, (t - t_old) / h, y)
    call_function(event, t, y, out)
    return out[0]


@njit(**INTERNAL)
def crossing(e, d, t_from, t_new, t_old, h, y, out):
    """A time in [t_from, t_new] at which the function of an EVENTS record `e` is zero.

    The polynomial d begins at t_old and belongs to a step of length h.  If the function has one
    sign at both ends (a step so short that the ends coincide), the result is the end with the
    smaller value, but the start of a step where the function jumped just before.  If the event
    takes edges, and its function stays zero, the result is the time from which on the function is
    zero.
    """
    event = e.block
    a = t_from
    b = t_new
    fa = value(event, d, t_old, h, a, y, out)
    fb = value(event, d, t_old, h, b, y, out)
    if fa == 0.0:
        return a
    if fb == 0.0:
        return edge(e, d, b, a, t_old, h, y, out) if takes_edges(e) else b
    if (fa > 0.0) == (fb > 0.0):
        jumped = t_from == t_old and e.g * fa < 0.0  # at t0, and the steps begin behind
        return a if jumped or abs(fa) < abs(fb) else b
    c = a
    fc = fa
    step = previous = b - a
    for _ in range(N_ITERATIONS):
        if abs(fc) < abs(fb):  # keep the best point in b, its bracket in c
            a, b, c = b, c, b
            fa, fb, fc = fb, fc, fb
        tolerance = 0.5 * resolution(b, e.unit)
        middle = 0.5 * (c - b)
        if fb == 0.0 or abs(middle) <= tolerance or raised(event):
            break
        if abs(previous) < tolerance or abs(fa) <= abs(fb):
            step = previous = middle
        else:
            s = fb / fa
            if a == c:  # secant
                p = 2.0 * middle * s
                q = 1.0 - s
            else:  # inverse quadratic
                u = fa / fc
                v = fb / fc
                p = s * (2.0 * middle * u * (u - v) - (b - a) * (v - 1.0))
                q = (u - 1.0) * (v - 1.0) * (s - 1.0)
            if p > 0.0:
                q = -q
            p = abs(p)
            if 2.0 * p < min(3.0 * middle * q - abs(tolerance * q), abs(previous * q)):
                previous = step
                step = p / q
            else:
                step = previous = middle
        a = b
        fa = fb
        b += step if abs(step) > tolerance else (tolerance if middle > 0.0 else -tolerance)
        fb = value(event, d, t_old, h, b, y, out)
        if (fb > 0.0) == (fc > 0.0):
            c = a
            fc = fa
            step = previous = b - a
    if fb == 0.0 and takes_edges(e):
        return edge(e, d, b, t_from, t_old, h, y, out)
    return b


@njit(**INLINED)
def takes_edges(e):
    """Whether an interval on which the function of an event is exactly zero has two occurrences.

    Those of methods with SciPy's results that decide nothing occur as SciPy's do.
    """
    return e.inside == COUNTS


@njit(**INTERNAL)
def edge(e, d, t_zero, t_other, t_old, h, y, out):
    """The end, towards t_other, of the interval around t_zero where a function is exactly zero.

    The function is not zero at t_other.  The result is t_zero if t_zero is a zero by itself.
    """
    event = e.block
    zero = t_zero
    other = t_other
    probe = t_zero + STAYS_FOR * (t_other - t_zero)
    if value(event, d, t_old, h, probe, y, out) != 0.0:
        return t_zero
    while abs(other - zero) > resolution(zero, e.unit) and not raised(event):
        middle = 0.5 * (zero + other)
        if value(event, d, t_old, h, middle, y, out) == 0.0:
            zero = middle
        else:
            other = middle
    return zero


@njit(**INTERNAL)
def crossing_from_zero(e, d, t_from, t_new, t_old, h, y, out):
    """The next zero of a function that is zero to rounding at t_from and then has e.g's sign.

    The times t_from + (t_new - t_from) / 2^k are tried.  The result is `t_from` if the function has
    this sign at none of these times.
    """
    sign = e.g
    t = t_new
    while not raised(e.block):
        end = t
        t = t_from + 0.5 * (t - t_from)
        if t == t_from or t == end:
            break
        g = value(e.block, d, t_old, h, t, y, out)
        if (g > 0.0 and sign > 0.0) or (g < 0.0 and sign < 0.0):
            return crossing(e, d, t, end, t_old, h, y, out)
    return t_from
