"""The roots of an event function in a step that is divided into equal parts.

On a long step, one series of the event function does not converge.  For each part, the polynomial
of the state is expanded about the start of the part, which is exact up to rounding, and the series
of the event function is computed from this expansion.  A series counts only if it is the function
at the end of the part and at points inside: a series knows neither the border of the domain, where
the function becomes NaN, nor a jump.  The shortest parts need no series: the function's own signs
at both ends of the part tell.
"""

import numpy as np

from ...calls.calling_convention import invoke
from ...calls.user_function import evaluate
from ...jit.options import INTERNAL, njit
from ...state.record import K
from ...state.rows import copy_row, slot
from ..arguments import MOST_ROOTS, MOST_TERMS
from ..brent import resolution
from ..events import JUMP, SIGN
from .polynomial_roots import GIVEN, PLACES, TURNS, polynomial_roots

CLOSE = 1e-9  # share of sum|c| that the last two terms, and a gap between parts, may reach
FEWEST_PARTS = 8
MOST_PARTS = 256
HALVINGS = 52  # of a part, to the spacing of numbers
# Share of the step: on long steps, the polynomial is rounded to 1000 units; they take 1e-13.
BEHIND = 2.0**-40
SAMPLES = 5  # points at which a series is compared with its function
BETWEEN = 1  # the row LOW, between the rows of the coefficients and the row of the unit of time


@njit(**INTERNAL)
def roots_in_parts(e, solve, t, begins, scale_row, room, kept, moved):
    """Find the roots, up to t, of an event function.

    Parameters
    ----------
    e : EVENTS record
    solve : state.record.Solve
    t : float
    begins : float
        Value of the event function at the start of the step.
    scale_row : int
        The row of `work` with the unit of time, behind the rows of the coefficients.
    room : array, shape (ROWS, WIDTH)
        Scratch of `polynomial_roots`.
    kept : array, shape (2, MOST_ROOTS)
        Receives the roots, as fractions of [t_old, t], and the sign of the event function after
        each root, or 0 if the sign does not change.
    moved : array, like `solve.work`
        Scratch.

    Returns
    -------
    found : int
        Number of roots; -1 if there are too many.
    side : float
        The sign of the event function at t; just after t if t is a root; NaN if the function is.
    size : float
        The largest finite size of the event function at an end of a part.
    """
    for i in range(len(moved)):
        copy_row(solve.work[i], moved[i])
    parts = FEWEST_PARTS
    while parts <= MOST_PARTS:
        found, side, size = _in_parts(e, solve, t, begins, scale_row, room, moved, kept, parts)
        if found >= 0:
            return found, side, size
        parts *= 2
    return -1, 0.0, 0.0


@njit(**INTERNAL)
def _in_parts(e, solve, t, begins, scale_row, room, moved, kept, parts):
    """`roots_in_parts` for a number of parts.

    -1 roots if a part of a coarse division has no series.  A side is NaN where the event function
    has no value.
    """
    s = solve.state[0]
    c = slot(None, room, GIVEN)
    h = (t - s.t_old) / parts
    found = 0
    before = begins
    largest = abs(begins) if np.isfinite(begins) else 0.0
    for part in range(parts):
        _move(solve.work, moved, part * h / solve.work[scale_row, 0], scale_row - K - BETWEEN)
        n = invoke(e.series, (s.t_old + part * h, h, moved, e.block, c))
        end = e.g_new
        if part + 1 < parts:
            end = _value(e, solve, (part + 1) * h, moved)
        if np.isfinite(end):
            largest = max(largest, abs(end))
        sound = before == before and n > 1 and n <= MOST_TERMS and _converges(c, n)
        if sound and _is_function(e, solve, part * h, h, c[:n], end, moved):
            if part == 0:
                c[0] = begins
            elif not c[0] * before > 0.0:
                c[0] = SIGN * before  # tiny, with the sign at the end of the previous part
            more, before = polynomial_roots(c[:n], room)
            if more < 0 or found + more > MOST_ROOTS:
                return -1, 0.0, 0.0
            for j in range(more):
                kept[0, found] = (part + room[PLACES, j]) / parts
                kept[1, found] = room[TURNS, j]
                found += 1
            continue
        if parts < MOST_PARTS:
            return -1, 0.0, 0.0
        if end == 0.0:
            end = before if before == before else 0.0
        if not before * end > 0.0:
            found = _by_signs(e, solve, part * h, h, before, end, largest, kept, found, moved)
            if found < 0:
                return -1, 0.0, 0.0
        before = np.sign(end) if end == end else np.nan
    return found, before, largest


@njit(**INTERNAL)
def _by_signs(e, solve, a, h, before, end, largest, kept, found, scratch):
    """Add the changes of sign in a part from a on, which has no series; the new count, or -1.

    Where the function has no value at one end, or between different signs, each side is followed
    to the border of the domain.
    """
    x = 0.0
    turn = 0.0
    if before == before and before != 0.0:
        x, behind = _halved(e, solve, a, h, before, end, largest, scratch)
        if behind == behind:
            turn = -np.sign(before)
    if turn == 0.0 and before != 0.0 and end == end and end != 0.0:
        x, behind = _halved(e, solve, a + h, -h, end, before, largest, scratch)
        if behind == behind:
            turn = np.sign(end)
    if turn == 0.0:
        return found
    if found == MOST_ROOTS:
        return -1
    whole = solve.state[0].t - solve.state[0].t_old
    kept[0, found] = min(x / whole, 1.0)
    kept[1, found] = turn
    return found + 1


@njit(**INTERNAL)
def _value(e, solve, later, scratch):
    """The event function at a time after the start of the step; NaN if it raised."""
    s = solve.state[0]
    work = solve.work
    _state(work, later, scratch[0])
    if not evaluate(e.block, s.t_old + later, scratch[0], scratch[1]):
        return np.nan
    return scratch[1, 0]


@njit(**INTERNAL)
def _halved(e, solve, a, h, sign, behind, largest, scratch):
    """Where the function loses the sign that it has at a, between a and a + h; and its value there.

    `behind` is the value at a + h.  If the event changes the state, the place is so far
    behind a jump of the function that rounding does not lead before the jump, where the event would
    occur again.
    """
    last = sign
    for _ in range(HALVINGS):
        h *= 0.5
        value = _value(e, solve, a + h, scratch)
        if value * sign > 0.0:
            a = a + h
            last = value
        else:
            behind = value
    place = a + h
    if e.jump != 0 and abs(behind - last) > JUMP * largest:
        s = solve.state[0]
        far = 2.0 * resolution(s.t_old + place, e.unit) + BEHIND * abs(s.t - s.t_old)
        place += s.direction * far
    return place, behind


@njit(**INTERNAL)
def _state(work, later, y):
    """The polynomial of the step at a time after its start."""
    last = len(work) - 2 - BETWEEN - K
    u = later / work[len(work) - 1, 0]
    for i in range(work.shape[1]):
        total = 0.0
        for k in range(last, -1, -1):
            total = total * u + work[K + k, i]
        y[i] = total


@njit(**INTERNAL)
def _sums(c, n):
    """The sum of the series, and the sum of the absolute values of its terms."""
    total = size = 0.0
    for k in range(n):
        total += c[k]
        size += abs(c[k])
    return total, size


@njit(**INTERNAL)
def agrees(e, solve, a, h, c, far, scratch):
    """True if series and function differ by at most `far` at SAMPLES points between a and a + h.

    a is a time after the start of the step.
    """
    for j in range(1, SAMPLES + 1):
        x = j / (SAMPLES + 1.0)
        value = 0.0
        for k in range(len(c) - 1, -1, -1):
            value = value * x + c[k]
        if not abs(value - _value(e, solve, a + x * h, scratch)) <= far:
            return False
    return True


@njit(**INTERNAL)
def _is_function(e, solve, a, h, c, end, scratch):
    """True if the series is the function in a part, from a to a + h, with the value `end`."""
    total, size = _sums(c, len(c))
    far = CLOSE * size
    return abs(total - end) <= far and agrees(e, solve, a, h, c, far, scratch)


@njit(**INTERNAL)
def _converges(c, n):
    _, size = _sums(c, n)
    return abs(c[n - 1]) + abs(c[n - 2]) <= CLOSE * size


@njit(**INTERNAL)
def _move(work, moved, x, n_rows):
    """Write the coefficients of the expansion about x to `moved`, by repeated Horner schemes."""
    for k in range(n_rows):
        copy_row(work[K + k], moved[K + k])
    for first in range(n_rows - 1):
        for k in range(n_rows - 2, first - 1, -1):
            for i in range(work.shape[1]):
                moved[K + k, i] += x * moved[K + k + 1, i]
