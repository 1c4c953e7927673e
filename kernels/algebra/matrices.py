"""The matrices of an implicit method: their rows in the work array, and their elimination.

Each matrix is a J + b M, with the Jacobian J and the mass matrix M (I without a mass matrix), and
takes ROWS rows of the work array.  The word MATRICES of the block is 0 for our own elimination of a
matrix of n rows, stored by columns.  Otherwise the word is the address of words that
`calls/block.py` describes: the kind of elimination, the layout of the elements, bandwidths,
routines, and, if ORDERED, the new number of each component.

An OUTSIDE solver keeps the factors itself.  The rows of J then hold the elements of J, in the order
of the solver.  The rows of the factors hold a and b, from which the solver can factorise again.
The routines of the solver get the addresses of the elements of J and of a and b.
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
    ORDER,
    ORDERED,
    OTHER_FACTORS,
    OTHER_SOLUTION,
    OUTSIDE,
    OWN,
    PRODUCT,
    RARE,
    REAL,
    ROWS,
)
from ..calls.calling_convention import invoke
from ..calls.user_function import words_at
from ..jit.options import INTERNAL, njit
from ..state.rows import after, numbers_from
from . import lapack
from .factorise import add_matrix_product, factorise, solve
from .lapack import call_routine
from .mass import add_mass

NARROWER = 8  # a matrix is treated as a band if n is so many times each bandwidth


@njit(**INTERNAL)
def matrix_rows(block, n):
    """The number of rows of the work array that a matrix takes."""
    return n if block[MATRICES] == 0 else words_at(block[MATRICES])[ROWS]


@njit(**INTERNAL)
def leading(block, n):
    """The distance between columns, and the place of the first element."""
    if block[MATRICES] == 0:
        return n, 0
    words = words_at(block[MATRICES])
    return words[LD], words[BASE]


@njit(**INTERNAL)
def matrix_at(work, block, first):
    """The numbers from element (0, 0) on of the matrix that begins at row `first`."""
    return numbers_from(work, first, leading(block, work.shape[1])[1])


@njit(**INTERNAL)
def kind_of(s, block, n):
    """The kind of elimination: see `calls/block.py`."""
    if block[MATRICES] == 0:
        return OWN
    kind = words_at(block[MATRICES])[KIND]
    if kind == FULL and max(s.lower, s.upper) * NARROWER < n:
        return OWN
    return kind


@njit(**INTERNAL)
def written(s, kind, n):
    """The numbers of diagonals to write below and above; all diagonals if LAPACK reads all."""
    return (n - 1, n - 1) if kind == FULL else (s.lower, s.upper)


@njit(**INTERNAL)
def put_sum(work, block, first, to, a, b, ld, base, lower, upper):
    """Put a J + b M at row `to`, with J from row `first`; return the numbers of the sum."""
    n = work.shape[1]
    jacobian = numbers_from(work, first, base)
    sum_ = numbers_from(work, to, base)
    for j in range(n):
        first = max(0, j - lower - upper)
        end = min(n, j + 1 + lower)
        column = after(jacobian, j * ld + first)
        target = after(sum_, j * ld + first)
        for i in range(end - first):
            target[i] = a * column[i]
    add_mass(block[MASS], b, sum_, ld, n)
    return sum_


@njit(**INTERNAL)
def factorise_sum(s, work, block, first, to, pivots, a, b):
    """Factorise a J + b M, with J from row `first`, at row `to`; return whether it is regular."""
    n = work.shape[1]
    s.n_factorised += 1
    if kind_of(s, block, n) != FULL:
        kernel = rare(block, OTHER_FACTORS)
        given = (s, work, block, first, to, pivots, a, b)
        return invoke(kernel, given) == 1
    words = words_at(block[MATRICES])
    put_sum(work, block, first, to, a, b, words[LD], words[BASE], n - 1, n - 1)
    return lapack.factorise_full(words[REAL], numbers_from(work, to, 0), n, work[pivots])


@njit(**INTERNAL)
def rare(block, which):
    """The address of a kernel that few solves need: see `calls/block.py`."""
    return words_at(block[RARE])[which]


@njit(**INTERNAL)
def other_factors(state, work, block, first, to, pivots, a, b):
    """`factorise_sum` for matrices that are not full: a kernel of its own."""
    s = state[0]
    n = work.shape[1]
    return 1 if _other_factors(s, work, block, first, to, pivots, a, b, n) else 0


@njit(**INTERNAL)
def _other_factors(s, work, block, first, to, pivots, a, b, n):
    if block[MATRICES] == 0:
        return _eliminate(s, work, block, first, to, pivots, a, b, n, 0)
    kind = kind_of(s, block, n)
    words = words_at(block[MATRICES])
    if kind == OWN:
        return _eliminate(s, work, block, first, to, pivots, a, b, words[LD], words[BASE])
    if kind == OUTSIDE:
        work[to, 0] = a
        work[to, 1] = b
        work[to, 2] = 0.0
        return call_routine(words[REAL], (work[first], work[to])) == 0
    put_sum(work, block, first, to, a, b, words[LD], words[BASE], s.lower, s.upper)
    stored = numbers_from(work, to, 0)
    return lapack.factorise_band(words[REAL], stored, n, s.lower, s.upper, work[pivots])


@njit(**INTERNAL)
def _eliminate(s, work, block, first, to, pivots, a, b, ld, base):
    """`factorise_sum` by our own elimination."""
    n = work.shape[1]
    lower = s.lower
    upper = s.upper
    sum_ = put_sum(work, block, first, to, a, b, ld, base, lower, upper)
    factorise(sum_, ld, work[pivots], n, lower, upper)
    for j in range(n):
        if not np.isfinite(after(sum_, j * ld)[j]):
            return False
    return True


@njit(**INTERNAL)
def is_ordered(block):
    """Whether matrices order the components in another way than the state."""
    return block[MATRICES] != 0 and words_at(block[MATRICES])[ORDERED] != 0


@njit(**INTERNAL)
def new_number(block, i):
    """The row and column of component i in matrices."""
    return words_at(block[MATRICES])[ORDER + i] if is_ordered(block) else i


@njit(**INTERNAL)
def solve_sum(s, work, block, first, to, pivots, row, free):
    """Replace a right-hand side, a row, by the solution; row `free` may be overwritten."""
    n = work.shape[1]
    if kind_of(s, block, n) == FULL:
        routine = words_at(block[MATRICES])[REAL + 1]
        stored = numbers_from(work, to, 0)
        lapack.solve_full(routine, stored, n, work[pivots], work[row])
    else:
        invoke(rare(block, OTHER_SOLUTION), (s, work, block, first, to, pivots, row, free))


@njit(**INTERNAL)
def other_solution(state, work, block, first, to, pivots, row, free):
    """`solve_sum` for matrices that are not full: a kernel of its own."""
    s = state[0]
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
    return 0


@njit(**INTERNAL)
def _solve(s, work, block, first, to, pivots, b):
    n = work.shape[1]
    words = words_at(block[MATRICES])
    stored = numbers_from(work, to, 0)
    kind = kind_of(s, block, n)
    if kind == OWN:
        factors = numbers_from(work, to, words[BASE])
        solve(factors, words[LD], work[pivots], b, n, s.lower, s.upper)
    elif kind == BAND:
        lapack.solve_band(words[REAL + 1], stored, n, s.lower, s.upper, work[pivots], b)
    else:
        call_routine(words[REAL + 1], (work[first], work[to], b))


@njit(**INTERNAL)
def add_jacobian_product(s, work, block, first, given, out, free):
    """Add J times the row `given` to the row `out`, with J from row `first`.

    The row `free` and the next row may be overwritten.
    """
    n = work.shape[1]
    words = words_at(block[MATRICES])
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
    ld = words[LD]
    jacobian = numbers_from(work, first, words[BASE])
    add_matrix_product(jacobian, ld, work[free], work[free + 1], n, s.lower, s.upper)
    for i in range(n):
        work[out, i] = work[free + 1, new_number(block, i)]
