"""The matrices of an implicit method: where they lie in the work array, and who factorises them.

All are a J + b M, of the Jacobian J and the mass matrix M, or I where there is none.  Each takes
ROWS rows of the work array.  The block's word MATRICES is 0 for n rows, by columns, and our own
elimination, or names words, which `calls/block.py` has: a kind, where elements lie, bandwidths,
routines, and the new number of each component if they are in another order (ORDERED).

An OUTSIDE solver keeps the factors itself.  Rows of J hold its elements one after the other, in
the order of the solver, and those of the factors a and b, from which it can find them again; its
routines get the addresses of both.
"""

import numpy as np

from ..calls.block import (
    BAND,
    BASE,
    FULL,
    KIND,
    LD,
    MASS,
    MATRICES,
    NARROW,
    ORDER,
    ORDERED,
    OUTSIDE,
    OWN,
    PRODUCT,
    REAL,
    ROWS,
)
from ..calls.user_function import words_at
from ..jit_options import INTERNAL, njit
from ..state.rows import after, numbers_from
from . import lapack
from .factorise import add_matrix_product, factorise, solve
from .lapack import call_routine
from .mass import add_mass

NARROWER = 8  # a full matrix is a band if it is so many times narrower on each side


@njit(**INTERNAL)
def matrix_rows(block, n):
    """Rows of the work array that a matrix takes."""
    return n if block[MATRICES] == 0 else words_at(block[MATRICES])[ROWS]


@njit(**INTERNAL)
def leading(block, n):
    """The distance between columns, and the first element's place."""
    if block[MATRICES] == 0:
        return n, 0
    words = words_at(block[MATRICES])
    return words[LD], words[BASE]


@njit(**INTERNAL)
def matrix_at(work, block, first):
    """The numbers of the matrix whose rows begin with `first`, from its element (0, 0) on."""
    return numbers_from(work, first, leading(block, work.shape[1])[1])


@njit(**INTERNAL)
def kind_of(s, block, n):
    """Who factorises a real matrix."""
    if block[MATRICES] == 0:
        return OWN
    kind = words_at(block[MATRICES])[KIND]
    if kind == NARROW or (kind == FULL and max(s.lower, s.upper) * NARROWER < n):
        return OWN
    return kind


@njit(**INTERNAL)
def written(s, kind, n):
    """The diagonals below and above that are written: all where LAPACK reads all."""
    return (n - 1, n - 1) if kind == FULL else (s.lower, s.upper)


@njit(**INTERNAL)
def put_sum(work, block, first, to, a, b, ld, base, lower, upper):
    """Put a J + b M, of the J that lies at `first`, at `to`; its numbers."""
    n = work.shape[1]
    jacobian, sum_ = numbers_from(work, first, base), numbers_from(work, to, base)
    for j in range(n):
        column, target = after(jacobian, j * ld), after(sum_, j * ld)
        for i in range(max(0, j - lower - upper), min(n, j + 1 + lower)):
            target[i] = a * column[i]
    add_mass(block[MASS], b, sum_, ld, n)
    return sum_


@njit(**INTERNAL)
def factorise_sum(s, work, block, first, to, pivots, a, b):
    """Factorise a J + b M, of the J that lies at `first`, at `to`; whether it is regular."""
    n = work.shape[1]
    s.n_factorised += 1
    if block[MATRICES] == 0:
        return _eliminate(s, work, block, first, to, pivots, a, b, n, 0)
    kind, words = kind_of(s, block, n), words_at(block[MATRICES])
    if kind == OWN:
        return _eliminate(s, work, block, first, to, pivots, a, b, words[LD], words[BASE])
    if kind == OUTSIDE:
        work[to, 0], work[to, 1], work[to, 2] = a, b, 0.0
        return call_routine(words[REAL], (work[first], work[to])) == 0
    lower, upper = written(s, kind, n)
    put_sum(work, block, first, to, a, b, words[LD], words[BASE], lower, upper)
    stored = numbers_from(work, to, 0)
    if kind == FULL:
        return lapack.factorise_full(words[REAL], stored, n, work[pivots])
    return lapack.factorise_band(words[REAL], stored, n, s.lower, s.upper, work[pivots])


@njit(**INTERNAL)
def _eliminate(s, work, block, first, to, pivots, a, b, ld, base):
    """`factorise_sum` by our own elimination."""
    n, lower, upper = work.shape[1], s.lower, s.upper
    sum_ = put_sum(work, block, first, to, a, b, ld, base, lower, upper)
    factorise(sum_, ld, work[pivots], n, lower, upper)
    for j in range(n):
        if not np.isfinite(after(sum_, j * ld)[j]):
            return False
    return True


@njit(**INTERNAL)
def is_ordered(block):
    """Whether the components are in another order in matrices."""
    return block[MATRICES] != 0 and words_at(block[MATRICES])[ORDERED] != 0


@njit(**INTERNAL)
def new_number(block, i):
    """The row and the column in which component i is."""
    return words_at(block[MATRICES])[ORDER + i] if is_ordered(block) else i


@njit(**INTERNAL)
def solve_sum(s, work, block, first, to, pivots, row, free):
    """Put the solution in the place of a right-hand side, a row; `free` may be written to."""
    n = work.shape[1]
    if block[MATRICES] == 0:
        solve(numbers_from(work, to, 0), n, work[pivots], work[row], n, s.lower, s.upper)
    elif not is_ordered(block):
        _solve(s, work, block, first, to, pivots, work[row])
    else:
        for i in range(n):
            work[free, new_number(block, i)] = work[row, i]
        _solve(s, work, block, first, to, pivots, work[free])
        for i in range(n):
            work[row, i] = work[free, new_number(block, i)]


@njit(**INTERNAL)
def _solve(s, work, block, first, to, pivots, b):
    n, words, stored = work.shape[1], words_at(block[MATRICES]), numbers_from(work, to, 0)
    kind = kind_of(s, block, n)
    if kind == OWN:
        factors = numbers_from(work, to, words[BASE])
        solve(factors, words[LD], work[pivots], b, n, s.lower, s.upper)
    elif kind == FULL:
        lapack.solve_full(words[REAL + 1], stored, n, work[pivots], b)
    elif kind == BAND:
        lapack.solve_band(words[REAL + 1], stored, n, s.lower, s.upper, work[pivots], b)
    else:
        call_routine(words[REAL + 1], (work[first], work[to], b))


@njit(**INTERNAL)
def add_jacobian_product(s, work, block, first, given, out, free):
    """Add J times one row to another, of the J that lies at `first`.

    The rows `free` and the next may be written to.
    """
    n, words = work.shape[1], words_at(block[MATRICES])
    if block[MATRICES] == 0:
        jacobian = numbers_from(work, first, 0)
        add_matrix_product(jacobian, n, work[given], work[out], n, s.lower, s.upper)
        return
    if words[KIND] == OUTSIDE:
        call_routine(words[PRODUCT], (work[first], work[given], work[out]))
        return
    for i in range(n):
        work[free, new_number(block, i)] = work[given, i]
        work[free + 1, new_number(block, i)] = work[out, i]
    ld, jacobian = words[LD], numbers_from(work, first, words[BASE])
    add_matrix_product(jacobian, ld, work[free], work[free + 1], n, s.lower, s.upper)
    for i in range(n):
        work[out, i] = work[free + 1, new_number(block, i)]
