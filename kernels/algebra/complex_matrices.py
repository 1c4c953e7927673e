"""The complex matrices a J + (b + i c) I of an implicit method; see `matrices.py`.

Each takes the rows of two.  Our own elimination keeps real and imaginary parts apart, LAPACK's one
after the other.
"""

from ..calls.block import MATRICES
from ..calls.user_function import words_at
from ..jit_options import INTERNAL, njit
from ..state.rows import numbers_of
from . import lapack
from .factorise_complex import factorise_complex, solve_complex
from .lapack import call_routine
from .matrices import (
    BAND,
    COMPLEX,
    FULL,
    KIND,
    OUTSIDE,
    OWN,
    kind_of,
    leading,
    matrix_at,
    matrix_rows,
    new_number,
    put_sum,
)


@njit(**INTERNAL)
def _kind(s, block, n):
    """Who factorises a complex matrix: LAPACK in each band."""
    if block[MATRICES] != 0 and words_at(block[MATRICES])[KIND] == BAND:
        return BAND
    return kind_of(s, block, n)


@njit(**INTERNAL)
def _parts(work, block, to):
    """The numbers of the real and of the imaginary parts."""
    im = to + matrix_rows(block, work.shape[1])
    return matrix_at(work, block, to), matrix_at(work, block, im)


@njit(**INTERNAL)
def _put_parts(s, work, block, first, to, a, b, c):
    """The matrix in two parts."""
    n, ld = work.shape[1], leading(block, work.shape[1])[0]
    put_sum(s, work, block, first, to, a, b)
    re, im = _parts(work, block, to)
    for j in range(n):
        for i in range(max(0, j - s.lower - s.upper), min(n, j + 1 + s.lower)):
            im[j * ld + i] = 0.0
        im[j * ld + j] = c
    return re, im


@njit(**INTERNAL)
def _put_pairs(s, work, block, first, to, a, b, c):
    """The matrix in pairs of numbers; all of them, from where LAPACK begins to count."""
    n = work.shape[1]
    ld, base = leading(block, n)
    jacobian, pairs = matrix_at(work, block, first), numbers_of(work)[to * n :]
    for j in range(n):
        for i in range(max(0, j - s.upper), min(n, j + 1 + s.lower)):
            place = 2 * (base + j * ld + i)
            pairs[place] = a * jacobian[j * ld + i]
            pairs[place + 1] = 0.0
        place = 2 * (base + j * ld + j)
        pairs[place] += b
        pairs[place + 1] = c
    return pairs


@njit(**INTERNAL)
def factorise_complex_sum(s, work, block, first, to, pivots, a, b, c):
    """Factorise a J + (b + i c) I, of the J that lies at `first`, at `to`."""
    n = work.shape[1]
    kind, words = _kind(s, block, n), words_at(block[MATRICES])
    s.n_factorised += 1
    if kind == OWN:
        re, im = _put_parts(s, work, block, first, to, a, b, c)
        ld = leading(block, n)[0]
        factorise_complex(re, im, ld, work[pivots], n, s.lower, s.upper)
    elif kind == OUTSIDE:
        work[to, 0], work[to, 1], work[to, 2] = a, b, c
        call_routine(words[COMPLEX], (work[first], work[to]))
    else:
        pairs = _put_pairs(s, work, block, first, to, a, b, c)
        if kind == FULL:
            lapack.factorise_full(words[COMPLEX], pairs, n, work[pivots])
        else:
            given = pairs, n, s.lower, s.upper, work[pivots]
            lapack.factorise_band(words[COMPLEX], *given)


@njit(**INTERNAL)
def solve_complex_sum(s, work, block, first, to, pivots, row, free):
    """Put the solution in the place of a right-hand side, the row of its real parts and the next.

    The rows `free` and the next may be written to.
    """
    n = work.shape[1]
    kind, words = _kind(s, block, n), words_at(block[MATRICES])
    b, c = work[row], work[row + 1]
    if kind == OWN:
        re, im = _parts(work, block, to)
        ld = leading(block, n)[0]
        solve_complex(re, im, ld, work[pivots], b, c, n, s.lower, s.upper)
        return
    if kind == OUTSIDE:
        call_routine(words[COMPLEX + 1], (work[first], work[to], b, c))
        return
    pairs, stored = numbers_of(work)[free * n : (free + 2) * n], numbers_of(work)[to * n :]
    for i in range(n):
        place = 2 * new_number(block, i)
        pairs[place], pairs[place + 1] = b[i], c[i]
    if kind == FULL:
        lapack.solve_full(words[COMPLEX + 1], stored, n, work[pivots], pairs)
    else:
        lapack.solve_band(words[COMPLEX + 1], stored, n, s.lower, s.upper, work[pivots], pairs)
    for i in range(n):
        place = 2 * new_number(block, i)
        b[i], c[i] = pairs[place], pairs[place + 1]
