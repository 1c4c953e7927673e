"""The elimination of the unknowns within a mesh, for `collocation.py`.

Linearised, the equations of interval i are A_i y_i + C_i y_{i+1} + P_i p = r_i, n of them; n + k
more couple y_0, y_N and p.  The unknowns within are eliminated from left to right: y_i by a
Householder QR factorisation of what its two intervals hold of it, so that n equations between y_0,
y_{i+1} and p are left.  This is stable where elimination with pivots of rows grows.  S. J. Wright,
"Stable parallel algorithms for two-point boundary value problems", SIAM J. Sci. Stat. Comput. 13
(1992).

A block is a table of 2 n + 1 rows.  Rows up to n: those of y_i; up to 2 n: those that are left; the
last: the factors of the reflections.  Columns: y_i and, below its triangle, the reflections; y_0;
y_{i+1}; p.  Block 0 has the equations of interval 0 in its second n rows.
"""

import numpy as np

from ..algebra.factorise import solve
from ..jit.options import INTERNAL, njit


@njit(**INTERNAL)
def copy_numbers(source, target):
    """Copy a row to the first numbers of another; slices would allocate memory."""
    for i in range(min(len(source), len(target))):
        target[i] = source[i]


@njit(**INTERNAL)
def _reflect(b, j, rows):
    """Eliminate column j below its diagonal, in `rows` rows; the next row is room for sums."""
    size = 0.0
    width = b.shape[1]
    for i in range(j + 1, rows):
        size += b[i, j] * b[i, j]
    if size == 0.0:
        b[rows, j] = 0.0
        return
    norm = np.sqrt(size + b[j, j] * b[j, j])
    if b[j, j] > 0.0:
        norm = -norm
    head = b[j, j] - norm
    for i in range(j + 1, rows):
        b[i, j] /= head
    b[rows, j] = -head / norm
    b[j, j] = norm
    for c in range(j + 1, width):
        b[rows, c] = b[j, c]
    for i in range(j + 1, rows):
        v = b[i, j]
        for c in range(j + 1, width):
            b[rows, c] += v * b[i, c]
    for c in range(j + 1, width):
        b[rows, c] *= b[rows, j]
        b[j, c] -= b[rows, c]
    for i in range(j + 1, rows):
        v = b[i, j]
        for c in range(j + 1, width):
            b[i, c] -= v * b[rows, c]


@njit(**INTERNAL)
def eliminate(rows, blocks):
    """Factorise the equations of all intervals; False if they are singular."""
    count, n, width = rows.shape
    for i in range(count):
        b = blocks[i]
        for r in range(2 * n + 1):
            for c in range(width + n):
                b[r, c] = 0.0
        for r in range(n):
            for c in range(n, width):
                b[n + r, n + c] = rows[i, r, c]
            for c in range(n):
                b[n + r, c + (n if i == 0 else 0)] = rows[i, r, c]
        if i == 0:
            continue
        before = blocks[i - 1]
        for r in range(n):
            for c in range(n):
                b[r, c], b[r, n + c] = before[n + r, 2 * n + c], before[n + r, n + c]
            for c in range(3 * n, width + n):
                b[r, c] = before[n + r, c]
        for j in range(n):
            _reflect(b, j, 2 * n)
            if b[j, j] == 0.0 or not np.isfinite(b[j, j]):
                return False
    return True


@njit(**INTERNAL)
def solve_linearised(room, r, p):
    """Put the solution for the present residuals and conditions into r and p."""
    n = r.shape[1]
    k = len(p)
    blocks = room.blocks
    right = room.right
    for i in range(len(blocks)):
        copy_numbers(room.residuals[i], r[i])
    copy_numbers(r[0], right)
    for i in range(1, len(blocks)):
        b = blocks[i]
        for j in range(n):  # [s, r_i], of which the first is kept in row i
            r[i, j], right[j] = right[j], r[i, j]
        for j in range(n):
            total = r[i, j]
            for q in range(j + 1, n):
                total += b[q, j] * r[i, q]
            for q in range(n):
                total += b[n + q, j] * right[q]
            total *= b[2 * n, j]
            r[i, j] -= total
            for q in range(j + 1, n):
                r[i, q] -= total * b[q, j]
            for q in range(n):
                right[q] -= total * b[n + q, j]
    for i in range(n + k):
        right[n + i] = room.conditions[i]
    size = 2 * n + k
    solve(room.last, size, room.pivots, right, size, size - 1, size - 1)
    for i in range(n):
        r[0, i], r[len(blocks), i] = right[i], right[n + i]
    for i in range(k):
        p[i] = right[2 * n + i]
    for i in range(len(blocks) - 1, 0, -1):
        b = blocks[i]
        for j in range(n - 1, -1, -1):
            total = r[i, j]
            for c in range(n):
                total -= b[j, n + c] * r[0, c] + b[j, 2 * n + c] * r[i + 1, c]
            for c in range(k):
                total -= b[j, 3 * n + c] * p[c]
            for c in range(j + 1, n):
                total -= b[j, c] * r[i, c]
            r[i, j] = total / b[j, j]
