"""The first change of sign of a polynomial, and how far a polynomial stays near its value at 0.

The polynomials are series of an order, with the coefficients c[place], c[place + stride], ...
"""

import math

from ...jit.options import INTERNAL, njit

ROUNDS = 100  # most rounds of a search; a step then ends before the change
BEYOND = 2.0**-50  # distance from a change to the step's end, as a share of step and time
TAIL = 2.0**50  # weight of the last two terms in the size of a polynomial: see VANISHING
VANISHING = 2.0**-48  # below this share of its size, the argument of a root counts as zero
# Largest remainder of a difference at its change, as a share of its motion, in units of the order's
# smallest tolerance.  The steps end where the states are accurate, and the difference may be less
# accurate: one with y^3, at rtol = 1e-6 and 0.04 % of the step away from its change.  From half of
# the length, the next step finds the change by a series whose remainder is smaller by 2^order.
REMAINDER = 0.1
LEAST_BOUND = 1e-300  # least bound of a second derivative


@njit(**INTERNAL)
def first_sign(c, place, stride, order):
    """The sign of the first coefficient that is not zero; 0 if all are zero."""
    for k in range(order + 1):
        if c[place + k * stride] > 0.0:
            return 1.0
        if c[place + k * stride] < 0.0:
            return -1.0
    return 0.0


@njit(**INTERNAL)
def size_at(c, place, stride, order, x):
    """The sum of |c[k]| x^k for k > 0."""
    total = 0.0
    for k in range(order, 0, -1):
        total = (total + abs(c[place + k * stride])) * x
    return total


@njit(**INTERNAL)
def not_far(c, place, stride, order, end, width, share):
    """The largest x = 2^-i end up to which the polynomial stays near its value at 0.

    The bound sum(|c[k]| |x|^k), k > 0, is at most the larger of `width` and `share` |c[0]|.
    """
    near = share * abs(c[place])
    x = end
    near = near if near > width else width
    for _ in range(ROUNDS):
        if size_at(c, place, stride, order, abs(x)) <= near:
            break
        x *= 0.5
    return x


@njit(**INTERNAL)
def _tail(c, place, stride, order, x):
    """The size of the last two terms, an estimate of the remainder."""
    last = place + order * stride
    return x ** (order - 1) * (abs(c[last]) * x + abs(c[last - stride]))


@njit(**INTERNAL)
def _least(x, q, p, m):
    """The least value of q + p s + m s^2 for 0 <= s <= x."""
    lowest = q
    if p < 0.0 and 2.0 * m * x + p > 0.0:
        lowest = q - p * p / (4.0 * m)
    last = (m * x + p) * x + q
    return last if last < lowest else lowest


@njit(**INTERNAL)
def first_change(c, place, stride, order, end, least, share, remainder):
    """The first x in (0, end] behind a change of sign, `end` if there is none.

    With a `share`, the polynomial counts as zero below this share of its size.  The change is then
    the point where the polynomial begins to vanish, or ceases to vanish.

    From a point where the value is q and the slope p (with signs such that q > 0), the polynomial
    stays positive for lengths s with q + p s - m s^2 / 2 > 0, where m bounds the second derivative.
    Steps of such lengths approach a simple zero quadratically, a double zero linearly.
    """
    x = abs(end)
    direction = math.copysign(1.0, end)
    first = c[place]
    slope = c[place + stride]
    bend = c[place + 2 * stride]
    rest = 0.0  # all terms but three
    for k in range(order, 2, -1):
        rest = (rest + abs(c[place + k * stride])) * x
    rest *= x * x
    total = (abs(bend) * x + abs(slope)) * x + abs(first) + rest
    tiny = share * (TAIL * _tail(c, place, stride, order, x) + total)
    shift = 4.0 * tiny if first < tiny else tiny
    q = first - shift
    side = -1.0 if q < 0.0 else 1.0
    if total == 0.0 or _least(x, side * q, side * direction * slope, side * bend) > rest:
        return end
    bound = 0.0  # of the second derivative
    for k in range(order, 1, -1):
        bound = bound * x + k * (k - 1) * abs(c[place + k * stride])
    bound = max(bound, LEAST_BOUND)
    sign = side if q != 0.0 else first_sign(c, place, stride, order)
    begun = 0.0
    for _ in range(ROUNDS):
        q = 0.0
        p = 0.0
        at = begun * direction
        for k in range(order, -1, -1):
            p = p * at + q
            q = q * at + c[place + k * stride]
        q = sign * (q - shift)
        p = sign * direction * p
        if q < 0.0 and begun > 0.0:
            break
        q = 0.0 if q < 0.0 else q
        root = math.sqrt(p * p + 2.0 * bound * q)
        s = 2.0 * q / (root - p) if p < 0.0 else (root + p) / bound
        shortest = begun * BEYOND + least
        begun += s if s > shortest else shortest
        if begun >= x:
            return end
    # If the remainder could have moved the change, half of the length: see REMAINDER.
    motion = remainder * size_at(c, place, stride, order, begun)
    vague = share == 0.0 and _tail(c, place, stride, order, begun) > motion
    return direction * (0.5 * begun if vague else begun)
