"""The complex matrices a J + (b + i c) M of an implicit method; see `matrices.py`.

A complex matrix takes the rows of two real matrices.  Our own elimination stores all real parts
before all imaginary parts; LAPACK stores the two parts of each element side by side.
"""

from ..calls.block import (
    BASE,
    COMPLEX,
    FULL,
    LD,
    MASS,
    MATRICES,
    OTHER_COMPLEX_FACTORS,
    OTHER_COMPLEX_SOLUTION,
    OUTSIDE,
    OWN,
    ROWS,
)  # fmt: skip
from ..calls.calling_convention import invoke
from ..calls.user_function import words_at
from ..jit.options import INTERNAL, njit
from ..state.rows import after, numbers_from
from . import lapack
from .factorise_complex import factorise_complex, solve_complex
from .lapack import call_routine
from .mass import add_mass, add_mass_to_pairs
from .matrices import kind_of, leading, matrix_at, matrix_rows, new_number, put_sum, rare, written


@njit(**INTERNAL)
def _eliminate(s, work, block, first, to, pivots, numbers, ld, base):
    """`factorise_complex_sum` by our own elimination, of the matrix in two parts."""
    n = work.shape[1]
    a, b, c = numbers
    re = put_sum(work, block, first, to, a, b, ld, base, s.lower, s.upper)
    im = numbers_from(work, to + matrix_rows(block, n), base)
    for j in range(n):
        first = max(0, j - s.lower - s.upper)
        end = min(n, j + 1 + s.lower)
        column = after(im, j * ld + first)
        for i in range(end - first):
            column[i] = 0.0
    add_mass(block[MASS], c, im, ld, n)
    factorise_complex(re, im, ld, work[pivots], n, s.lower, s.upper)


@njit(**INTERNAL)
def _put_pairs(s, work, block, kind, first, to, a, b, c):
    """Store the matrix as pairs of numbers; return the pairs from LAPACK's first element on."""
    n = work.shape[1]
    ld, base = leading(block, n)
    lower, upper = written(s, kind, n)
    jacobian = matrix_at(work, block, first)
    pairs = numbers_from(work, to, 0)
    for j in range(n):
        for i in range(max(0, j - lower - upper), min(n, j + 1 + lower)):
            place = 2 * (base + j * ld + i)
            pairs[place] = a * jacobian[j * ld + i]
            pairs[place + 1] = 0.0
    add_mass_to_pairs(block[MASS], b, c, pairs, base, ld, n)
    return pairs


@njit(**INTERNAL)
def factorise_complex_sum(s, work, block, first, to, pivots, a, b, c):
    """Factorise a J + (b + i c) M: J is read from row `first` on, the factors begin at row `to`."""
    n = work.shape[1]
    s.n_factorised += 1
    if kind_of(s, block, n) == FULL:
        pairs = _put_pairs(s, work, block, FULL, first, to, a, b, c)
        routine = words_at(block[MATRICES])[COMPLEX]
        lapack.factorise_full(routine, pairs, n, work[pivots])
    else:
        given = s, work, block, first, to, pivots, a, b, c
        invoke(rare(block, OTHER_COMPLEX_FACTORS), given)


@njit(**INTERNAL)
def other_complex_factors(state, work, block, first, to, pivots, a, b, c):
    """`factorise_complex_sum` for matrices that are not full: a kernel of its own."""
    s = state[0]
    n = work.shape[1]
    if block[MATRICES] == 0:
        _eliminate(s, work, block, first, to, pivots, (a, b, c), n, 0)
        return 0
    kind = kind_of(s, block, n)
    words = words_at(block[MATRICES])
    if kind == OWN:
        _eliminate(s, work, block, first, to, pivots, (a, b, c), words[LD], words[BASE])
    elif kind == OUTSIDE:
        work[to, 0] = a
        work[to, 1] = b
        work[to, 2] = c
        call_routine(words[COMPLEX], (work[first], work[to]))
    else:
        pairs = _put_pairs(s, work, block, kind, first, to, a, b, c)
        given = pairs, n, s.lower, s.upper, work[pivots]
        lapack.factorise_band(words[COMPLEX], *given)
    return 0


@njit(**INTERNAL)
def solve_complex_sum(s, work, block, first, to, pivots, row, free):
    """Replace a right-hand side by the solution: real parts in `row`, imaginary parts in the next.

    The row `free` and the row behind it may be overwritten.
    """
    if kind_of(s, block, work.shape[1]) == FULL:
        _solve_pairs(s, work, block, FULL, to, pivots, row, free)
    else:
        given = s, work, block, first, to, pivots, row, free
        invoke(rare(block, OTHER_COMPLEX_SOLUTION), given)


@njit(**INTERNAL)
def other_complex_solution(state, work, block, first, to, pivots, row, free):
    """`solve_complex_sum` for matrices that are not full: a kernel of its own."""
    s = state[0]
    n = work.shape[1]
    b = work[row]
    c = work[row + 1]
    if block[MATRICES] == 0:
        re = numbers_from(work, to, 0)
        im = numbers_from(work, to + n, 0)
        solve_complex(re, im, n, work[pivots], b, c, n, s.lower, s.upper)
        return 0
    kind = kind_of(s, block, n)
    words = words_at(block[MATRICES])
    if kind == OUTSIDE:
        call_routine(words[COMPLEX + 1], (work[first], work[to], b, c))
    elif kind == OWN:
        re = numbers_from(work, to, words[BASE])
        im = numbers_from(work, to + words[ROWS], words[BASE])
        x = work[free]
        y = work[free + 1]
        for i in range(n):
            place = new_number(block, i)
            x[place], y[place] = b[i], c[i]
        solve_complex(re, im, words[LD], work[pivots], x, y, n, s.lower, s.upper)
        for i in range(n):
            place = new_number(block, i)
            b[i], c[i] = x[place], y[place]
    else:
        _solve_pairs(s, work, block, kind, to, pivots, row, free)
    return 0


@njit(**INTERNAL)
def _solve_pairs(s, work, block, kind, to, pivots, row, free):
    """`solve_complex_sum` by LAPACK."""
    n = work.shape[1]
    words = words_at(block[MATRICES])
    stored = numbers_from(work, to, 0)
    b = work[row]
    c = work[row + 1]
    pairs = numbers_from(work, free, 0)
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
