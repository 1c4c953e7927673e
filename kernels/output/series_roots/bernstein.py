"""Polynomials on an interval in Bernstein's basis, whose coefficients bound signs and turns.

A piece is a row: its degree, its ends in [0, 1], the error of its coefficients, and its
coefficients from HEAD on.  With u = 2^-53, the error of a coefficient is at most

- (m + 3) u sum|c| after `convert`: a quotient, a product, a rounded reciprocal, and at most m sums,
  all of whose weights are C(i, k) / C(m, k) <= 1;
- m u max|b| more after `split`: the halves are exact, and m sums with weights that add to 1.

G. Farin, "Curves and Surfaces for CAGD", chapters 5 and 6.
"""

import math

import numpy as np

from ...jit.options import INTERNAL, njit
from ..arguments import MOST_TERMS as MOST  # the highest degree

DEGREE, LOW, HIGH, NOISE, HEAD = range(5)
WIDTH = HEAD + MOST + 1
UNIT = 2.0**-53

RECIPROCALS = np.zeros((MOST + 1, MOST + 1))
for _m in range(MOST + 1):
    RECIPROCALS[_m, : _m + 1] = [1.0 / math.comb(_m, _k) for _k in range(_m + 1)]


@njit(**INTERNAL)
def convert(a, noise, piece, scratch):
    """The polynomial sum a[k] s^k as a piece, on [0, 1]."""
    m = len(a) - 1
    piece[DEGREE] = m
    piece[LOW] = 0.0
    piece[HIGH] = 1.0
    piece[NOISE] = noise
    for k in range(m + 1):
        scratch[k] = a[k] * RECIPROCALS[m, k]
    for i in range(m + 1):
        piece[HEAD + i] = scratch[0]
        for k in range(m - i):
            scratch[k] += scratch[k + 1]


@njit(**INTERNAL)
def split(piece, left):
    """Leave the upper half in `piece`, the lower one in `left`: de Casteljau."""
    m = int(piece[DEGREE])
    middle = 0.5 * (piece[LOW] + piece[HIGH])
    piece[NOISE] += m * UNIT * largest(piece)
    for i in range(HEAD):
        left[i] = piece[i]
    left[HIGH] = piece[LOW] = middle
    for i in range(m + 1):
        left[HEAD + i] = piece[HEAD]
        for k in range(HEAD, HEAD + m - i):
            piece[k] = 0.5 * (piece[k] + piece[k + 1])


@njit(**INTERNAL)
def trim(piece):
    """Set end coefficients to zero if noise hides their sign; return the range of the others."""
    low = HEAD
    high = HEAD + int(piece[DEGREE])
    while low <= high and abs(piece[low]) <= piece[NOISE]:
        piece[low] = 0.0
        low += 1
    while low <= high and abs(piece[high]) <= piece[NOISE]:
        piece[high] = 0.0
        high -= 1
    return low, high


@njit(**INTERNAL)
def largest(piece):
    """The largest absolute value of the coefficients."""
    found = 0.0
    for i in range(HEAD, HEAD + int(piece[DEGREE]) + 1):
        found = max(found, abs(piece[i]))
    return found


@njit(**INTERNAL)
def is_clear(piece, low, high):
    """True if the coefficients from `low` to `high` have one sign beyond their error."""
    sign = 1.0 if piece[low] > 0.0 else -1.0
    for i in range(low, high + 1):
        if not sign * piece[i] > piece[NOISE]:
            return False
    return True


@njit(**INTERNAL)
def changes(piece, low, high):
    """Sign changes of the coefficients: the number of roots, or more by an even number."""
    n = 0
    before = piece[low]
    for i in range(low, high + 1):
        if piece[i] != 0.0:
            n += (piece[i] > 0.0) != (before > 0.0)
            before = piece[i]
    return n


@njit(**INTERNAL)
def turns(piece):
    """Sign changes of the derivative's coefficients: at least the number of turns."""
    n = 0
    before = 0.0
    for i in range(HEAD, HEAD + int(piece[DEGREE])):
        rise = piece[i + 1] - piece[i]
        if rise != 0.0:
            n += before != 0.0 and (rise > 0.0) != (before > 0.0)
            before = rise
    return n
