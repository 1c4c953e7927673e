"""The roots of an event function in a step that is divided into equal parts.

On a long step, one series of the event function does not converge.  For each part, the polynomial
of the state is expanded about the start of the part, which is exact up to rounding, and the series
of the event function is computed from this expansion.
"""

from ...calls.calling_convention import invoke
from ...calls.user_function import evaluate
from ...jit.options import INTERNAL, njit
from ...state.record import K
from ...state.rows import copy_row, slot
from ..arguments import MOST_ROOTS, MOST_TERMS
from ..events import SIGN
from .polynomial_roots import GIVEN, PLACES, TURNS, polynomial_roots

CLOSE = 1e-9  # share of sum|c| that the last two terms, and a gap between parts, may reach
FEWEST_PARTS, MOST_PARTS = 8, 256
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
        Number of roots; -1 if there are too many, or the series do not converge.
    side : float
        The sign of the event function at t; just after t if t is a root.
    """
    for i in range(len(moved)):
        copy_row(solve.work[i], moved[i])
    parts = FEWEST_PARTS
    while parts <= MOST_PARTS:
        found, side = _in_parts(e, solve, t, begins, scale_row, room, moved, kept, parts)
        if found >= 0:
            return found, side
        parts *= 2
    return -1, 0.0


@njit(**INTERNAL)
def _in_parts(e, solve, t, begins, scale_row, room, moved, kept, parts):
    s, c = solve.state[0], slot(None, room, GIVEN)
    h, found, side = (t - s.t_old) / parts, 0, 0.0
    expected = size = 0.0
    for part in range(parts):
        _move(solve.work, moved, part * h / solve.work[scale_row, 0], scale_row - K - BETWEEN)
        n = invoke(e.series, (s.t_old + part * h, h, moved, e.block, c))
        if n < 2 or n > MOST_TERMS or not _converges(c, n):
            return -1, 0.0
        if part > 0 and not abs(c[0] - expected) <= CLOSE * size:
            return -1, 0.0
        expected, size = _sums(c, n)
        if part == 0:
            c[0] = begins
        elif not c[0] * side > 0.0:
            c[0] = SIGN * side  # tiny, with the sign at the end of the previous part
        more, side = polynomial_roots(c[:n], room)
        if more < 0 or found + more > MOST_ROOTS:
            return -1, 0.0
        for j in range(more):
            kept[0, found] = (part + room[PLACES, j]) / parts
            kept[1, found] = room[TURNS, j]
            found += 1
    return found, side


@njit(**INTERNAL)
def _sums(c, n):
    """The sum of the series, and the sum of the absolute values of its terms."""
    total = size = 0.0
    for k in range(n):
        total += c[k]
        size += abs(c[k])
    return total, size


@njit(**INTERNAL)
def agrees(e, solve, t, c, far, scratch):
    """True if series and function differ by at most `far` at SAMPLES points inside the step."""
    s, work = solve.state[0], solve.work
    last = len(work) - 2 - BETWEEN - K
    for j in range(1, SAMPLES + 1):
        x = j / (SAMPLES + 1.0)
        at = s.t_old + x * (t - s.t_old)
        u = (at - s.t_old) / work[len(work) - 1, 0]
        for i in range(work.shape[1]):
            total = 0.0
            for k in range(last, -1, -1):
                total = total * u + work[K + k, i]
            scratch[0, i] = total
        if not evaluate(e.block, at, scratch[0], scratch[1]):
            return False
        value = 0.0
        for k in range(len(c) - 1, -1, -1):
            value = value * x + c[k]
        if not abs(value - scratch[1, 0]) <= far:
            return False
    return True


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
