"""All roots in (0, 1] of a polynomial, in order, and the change of sign at each root.

One bound excludes most polynomials, another bound leaves at most one root.  The other polynomials
are written in Bernstein's basis and halved until the signs of the coefficients leave one root, one
turn or none (Descartes' rule, Vincent's theorem); for integers see G. E. Collins and A. G. Akritas,
"Polynomial real root isolation using Descartes' rule of signs" (1976).

The coefficients are rounded.  A value is told from zero if the value exceeds

    noise = (2 m + 8) u sum|c|,    u = 2^-53.

The first term, 2 m u sum|c|, is the rounding of Horner's scheme (N. J. Higham, "Accuracy and
Stability of Numerical Algorithms", section 5.1); the conversion to Bernstein's basis needs only
m + 3 instead of 2 m.  The second term allows an error of 8 u in each given coefficient.

Two roots are one root if no value between them can be told from zero: a crossing if the polynomial
has different signs on both sides, otherwise a graze.
"""

import numpy as np

from ...jit.options import INTERNAL, njit
from .bernstein import (
    DEGREE,
    HEAD,
    HIGH,
    LOW,
    MOST,
    UNIT,
    changes,
    convert,
    is_clear,
    split,
    trim,
    turns,
)
from .newton import bracketed, derivatives, refined, sign_behind_one

NOT_FINITE = -1
MARGIN = 1.0 + 2.0**-44  # factor of a bound: covers the rounding of both sides of the bound
DEPTH = 50  # halvings of [0, 1]

# Rows of `room`: the search; the roots found; a row for the caller's coefficients; scratch; and the
# pieces that are still to be searched.
SEARCH, PLACES, TURNS, GIVEN, SCALED, SCRATCH, PIECES = range(7)
ROWS = PIECES + DEPTH + 2

# The row SEARCH: the last sign of the polynomial; the number of roots; whether and where the
# polynomial has touched zero since that sign; its noise; how many factors x were left out; the sign
# of c[0].
SIDE, FOUND, TOUCHED, FROM, TO, LEVEL, FACTORS, FIRST = range(8)


@njit(**INTERNAL)
def polynomial_roots(c, room):
    """The roots in (0, 1] of sum c[k] x^k.

    A root at 0 belongs to the previous step.  The sign of c[0], however small, is the sign before
    0; the polynomial crosses zero at 0 if it leaves 0 with the other sign.

    Parameters
    ----------
    c : array, at most MOST + 1 numbers
    room : array, (ROWS, WIDTH)
        Receives the roots in room[PLACES], and in room[TURNS] the sign of the polynomial
        behind each root, or 0 if the sign does not change at the root.

    Returns
    -------
    int
        Number of roots; NOT_FINITE if a coefficient is not finite.
    float
        The sign behind 1; 0 if the polynomial cannot be told from zero and c[0] is 0.
    """
    size = abs(c[0])
    if size > MARGIN * _sum(c, 1) and size < np.inf:
        return 0, np.sign(c[0])
    for k in range(1, len(c)):
        size = max(size, abs(c[k]))
    total = 0.0
    for k in range(len(c)):
        total += c[k] - c[k]  # NaN if a coefficient is not finite
    if total != 0.0:
        return NOT_FINITE, 0.0
    return _search(c, size, room)


@njit(**INTERNAL)
def _sum(c, first):
    """The sum of |c[k]| from k = first on."""
    total = 0.0
    for k in range(first, len(c)):
        total += abs(c[k])
    return total


@njit(**INTERNAL)
def _noise(a):
    """The size up to which values of the polynomial cannot be told from zero."""
    return (2 * len(a) + 6) * UNIT * _sum(a, 0)


@njit(**INTERNAL)
def _search(c, size, room):
    """`polynomial_roots` for coefficients of which `size` is the largest."""
    search = room[SEARCH]
    n = len(c)
    search[:] = 0.0
    search[SIDE] = search[FIRST] = np.sign(c[0])
    if size == 0.0:
        return 0, 0.0
    for k in range(n):
        room[SCALED, k] = c[k] / size
    a = room[SCALED, :n]
    search[LEVEL] = _noise(a)
    while len(a) > 0 and abs(a[0]) <= search[LEVEL]:
        _touch(search, 0.0, 0.0)
        a = a[1:]
        search[FACTORS] += 1.0
    if len(a) == 0:
        return 0, search[SIDE]
    if abs(a[0]) > MARGIN * _sum(a, 1):
        _see(a, room, 0.0, np.sign(a[0]))
    else:
        _cut(a, room)
    return int(search[FOUND]), search[SIDE]


@njit(**INTERNAL)
def _cut(a, room):
    """Search the polynomial for roots, piece by piece."""
    search = room[SEARCH]
    top = PIECES
    convert(a, search[LEVEL], room[PIECES], room[SCRATCH])
    while top >= PIECES:
        top = _look(a, room, top)
    if search[TOUCHED] != 0.0 and search[FROM] > 0.0:
        behind = sign_behind_one(a, search[LEVEL])
        _see(a, room, 1.0, behind if behind != 0.0 else search[SIDE])


@njit(**INTERNAL)
def _look(a, room, top):
    """Search the piece in row `top`, or halve the piece; return the row of the next piece."""
    piece = room[top]
    search = room[SEARCH]
    x = piece[LOW]
    x_end = piece[HIGH]
    low, high = trim(piece)
    if low > high or top == PIECES + DEPTH:
        _touch(search, x, x_end)
        return top - 1
    sign = np.sign(piece[low])
    rest = piece[low] * piece[high] > 0.0
    whole = piece[HEAD] * piece[HEAD + int(piece[DEGREE])] != 0.0
    n_turns = turns(piece) if whole else -1
    clear = rest and (n_turns == 0 or is_clear(piece, low, high))
    crosses = not rest and (n_turns == 0 or changes(piece, low, high) == 1)
    if not (clear or crosses or (rest and n_turns == 1)):
        split(piece, room[top + 1])
        return top + 1
    if low > HEAD:
        _touch(search, x, x)
    _see(a, room, x, sign)
    if crosses:
        _report(a, room, bracketed(a, 0, x, x_end, sign), -sign)
    elif not clear:
        _turn(a, room, x, x_end, sign)
    if high < HEAD + int(piece[DEGREE]):
        _touch(search, x_end, x_end)
    return top - 1


@njit(**INTERNAL)
def _turn(a, room, x, x_end, sign):
    """The roots of a piece with one turn of the polynomial, whose ends have the given sign."""
    if sign * derivatives(a, x)[1] > 0.0:
        return  # away from zero
    middle = bracketed(a, 1, x, x_end, -sign)
    value = sign * derivatives(a, middle)[0]
    noise = room[SEARCH, LEVEL]
    if value < -noise:
        _report(a, room, bracketed(a, 0, x, middle, sign), -sign)
        _report(a, room, bracketed(a, 0, middle, x_end, -sign), sign)
    elif value <= noise:
        _report(a, room, middle, 0.0)


@njit(**INTERNAL)
def _touch(search, low, high):
    """Note that the polynomial cannot be told from zero from low to high."""
    if search[TOUCHED] == 0.0:
        search[TOUCHED] = 1.0
        search[FROM] = low
    search[TO] = high


@njit(**INTERNAL)
def _see(a, room, x, sign):
    """Note the sign of the polynomial behind x; report a root if zero was touched before x."""
    search = room[SEARCH]
    side = search[SIDE]
    touched = search[TOUCHED] != 0.0
    if not touched:
        search[FROM] = search[TO] = x
    search[TOUCHED] = 0.0
    search[SIDE] = sign
    turn = sign if side != 0.0 and sign != side else 0.0
    if turn != 0.0 or (touched and search[FROM] > 0.0):
        middle = 0.5 * (search[FROM] + search[TO])
        if search[TO] > 0.0:
            middle = refined(a, middle, 0 if turn != 0.0 else 1)
        _report(a, room, middle, turn)


@njit(**INTERNAL)
def _noise_at(a, x):
    """The size up to which the value at x cannot be told from zero."""
    total = 0.0
    for k in range(len(a) - 1, -1, -1):
        total = total * x + abs(a[k])
    return (2 * len(a) + 6) * UNIT * total


@njit(**INTERNAL)
def _report(a, room, x, turn):
    """Add a root, or merge it with the last root if no value between them can be told from zero.

    Near a root at 0 the noise decreases with the powers of x, so that very low bounces are found.
    """
    search = room[SEARCH]
    places = room[PLACES]
    changed = room[TURNS]
    n = int(search[FOUND])
    factors = int(search[FACTORS])
    if turn != 0.0:
        search[SIDE] = turn
    before = places[n - 1] if n > 0 else 0.0
    middle = 0.5 * (before + x)
    value = abs(derivatives(a, middle)[0])
    if n > 0:
        apart = value * middle**factors > search[LEVEL]
    else:
        apart = x == 0.0 or factors == 0 or value > _noise_at(a, middle)
    if apart:
        if n < MOST:
            places[n] = max(x, before)
            changed[n] = turn
            search[FOUND] = n + 1.0
    elif n == 0:  # the same root as the root at 0
        if turn != 0.0 and search[FIRST] != 0.0:
            places[0] = 0.0
            changed[0] = turn
            search[FOUND] = 1.0
    elif turn != 0.0:
        changed[n - 1] = turn if changed[n - 1] == 0.0 else 0.0
        if before == 0.0:
            search[FOUND] = n - 1.0
