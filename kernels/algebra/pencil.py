"""The numbers of a mass matrix M, and the algebraic equations of M y' = f(t, y).

The word PENCIL of M (see `mass.py`) is the address of the block of a pencil; `calls/block.py`
describes the words of this block.  The word NUMBERS of the block is the address of the numbers of a
`Pencil`.  The rows of `left` are combinations of the equations without y'.  The rows of `right` are
directions of y that M maps to 0.  If M is regular, `left` and `right` have no rows.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import carray

from ..calls.block import (
    EQUATIONS,
    EVALUATIONS,
    FAILURE,
    N_ALGEBRAIC,
    NUMBERS,
    RAISED_WORD,
    TIME,
    WORDS_OF_PENCIL,
)
from ..calls.user_function import call_function, numbers_at, raised
from ..jit.options import INTERNAL, njit
from .factorise import factorise, solve

STEP = float(np.finfo(float).eps) ** (1 / 3)  # of a central difference, relative to a component
LEAST = 1e-3  # size that a component has at least, for differences
SINGULAR = 1e-9  # pivot of a singular matrix, with rows and columns scaled to size 1


class Pencil(NamedTuple):
    """The numbers of a pencil of n components with r algebraic equations.

    `span` is the end less the start of the run, finite; `inverse` maps f to a y' with M y' = f, if
    such a y' exists.  The other arrays are room: `matrix` for the matrix of Newton's iteration, by
    columns; `small` for its pivots, the sizes of its rows and columns, and a right-hand side;
    `states` for five states, the last for the state of a failure.
    """

    span: Any
    rtol: Any
    atol: Any
    inverse: Any
    left: Any
    right: Any
    matrix: Any
    small: Any
    states: Any


PIVOTS, ROWS, COLUMNS, RIGHT_SIDE = range(4)  # in `small`
F, MOVED, ABOVE, TRIAL, FAILED = range(5)  # in `states`


@njit(**INTERNAL)
def pencil_at(block, n):
    """The words of a pencil's block, and its numbers."""
    words = carray(block, WORDS_OF_PENCIL)
    r = words[N_ALGEBRAIC]
    at = words[NUMBERS]
    of_row = 8 * n
    of_matrix = 8 * r * n
    rtol = at + 8
    inverse = rtol + 2 * of_row
    left = inverse + n * of_row
    matrix = left + 2 * of_matrix
    small = matrix + 8 * r * r
    return words, Pencil(
        carray(numbers_at(at), (1,)),
        carray(numbers_at(rtol), (n,)),
        carray(numbers_at(rtol + of_row), (n,)),
        carray(numbers_at(inverse), (n, n)),
        carray(numbers_at(left), (r, n)),
        carray(numbers_at(left + of_matrix), (r, n)),
        carray(numbers_at(matrix), (r, r)),
        carray(numbers_at(small), (4, r)),
        carray(numbers_at(small + 32 * r), (5, n)),
    )


@njit(**INTERNAL)
def is_finite(row):
    total = 0.0
    for i in range(len(row)):
        total += row[i] - row[i]
    return total == 0.0


@njit(**INTERNAL)
def evaluate_finite(words, t, y, out):
    """Evaluate the right-hand side; False if the function raised, or a number is not finite."""
    call_function(words[EQUATIONS], t, y, out)
    words[EVALUATIONS] += 1
    return not raised(words[EQUATIONS]) and is_finite(out)


@njit(**INTERNAL)
def _least(y):
    """The least size of a component for differences: the median of |y|, but at least LEAST."""
    n = len(y)
    for i in range(n):
        below = equal = 0
        for j in range(n):
            below += abs(y[j]) < abs(y[i])
            equal += abs(y[j]) == abs(y[i])
        if below <= n // 2 < below + equal:
            return max(LEAST, abs(y[i]))
    return LEAST


@njit(**INTERNAL)
def _along(words, p, t, y, direction, least, out):
    """The derivative of the algebraic equations along a direction; False if it is not finite."""
    moved = p.states[MOVED]
    above = p.states[ABOVE]
    size = np.inf
    for i in range(len(y)):
        if direction[i] != 0.0:
            size = min(size, STEP * max(abs(y[i]), least) / abs(direction[i]))
    for i in range(len(y)):
        moved[i] = y[i] + size * direction[i]
    if not evaluate_finite(words, t, moved, above):
        return False
    for i in range(len(y)):
        moved[i] = y[i] - size * direction[i]
    below = p.states[TRIAL]
    if not evaluate_finite(words, t, moved, below):
        return False
    for j in range(len(p.left)):
        total = 0.0
        for i in range(len(y)):
            total += p.left[j, i] * (above[i] - below[i])
        out[j] = total / (2.0 * size)
    return True


@njit(**INTERNAL)
def factorise_algebraic(words, p, t, y):
    """The factors of the Jacobian of the algebraic equations; False if it is singular."""
    r = len(p.left)
    least = _least(y)
    a = p.matrix
    rows = p.small[ROWS]
    columns = p.small[COLUMNS]
    for k in range(r):
        if not _along(words, p, t, y, p.right[k], least, a[k]):
            return False
    for j in range(r):
        rows[j] = 0.0
        for k in range(r):
            rows[j] = max(rows[j], abs(a[k, j]))
        if rows[j] == 0.0:
            return False
    for k in range(r):
        columns[k] = 0.0
        for j in range(r):
            a[k, j] /= rows[j]
            columns[k] = max(columns[k], abs(a[k, j]))
        if columns[k] == 0.0:
            return False
        for j in range(r):
            a[k, j] /= columns[k]
    factorise(a.reshape(-1), r, p.small[PIVOTS], r, r - 1, r - 1)
    for k in range(r):
        if not abs(a[k, k]) < 1.0 / SINGULAR:
            return False
    return True


@njit(**INTERNAL)
def solve_algebraic(p, out):
    """Put the change of y that changes the algebraic equations by RIGHT_SIDE in the row `out`."""
    r = len(p.left)
    b = p.small[RIGHT_SIDE]
    for j in range(r):
        b[j] /= p.small[ROWS, j]
    solve(p.matrix.reshape(-1), r, p.small[PIVOTS], b, r, r - 1, r - 1)
    for i in range(len(out)):
        out[i] = 0.0
    for k in range(r):
        for i in range(len(out)):
            out[i] += p.right[k, i] * (b[k] / p.small[COLUMNS, k])


@njit(**INTERNAL)
def algebraic_size(p, f, sign):
    """Put the algebraic equations, times a sign, in RIGHT_SIDE; return their scaled size."""
    size = 0.0
    for j in range(len(p.left)):
        total = 0.0
        for i in range(len(f)):
            total += p.left[j, i] * f[i]
        p.small[RIGHT_SIDE, j] = sign * total
        size = max(size, abs(total) / p.small[ROWS, j])
    return size


@njit(**INTERNAL)
def fail(words, p, t, failure):
    """Mark the block, and keep the failure and the time for the message."""
    words[RAISED_WORD] = 1
    words[FAILURE] = failure
    words.view(np.float64)[TIME] = t
