"""Small dense linear systems inside a right-hand side.

Matrices are tuples of rows, so that their size is known when code is made.  Up to LONGEST rows, the
elimination is straight-line code on registers, chooses the larger pivot by selection instead of
branches, and allocates no memory.  In Python, the functions of this file work on numbers, with
equal bits.  Code for more rows calls the loops of `padded/`, by another function `eliminate`, which
rounds differently.
"""

import math

import numpy as np

EPS = float(np.finfo(float).eps)
SINGULAR = "the matrix is singular"
# Most rows of straight-line code in a traced function, which grows with their third power: 8 rows
# take 0.4 us (the loops 0.6), 10 rows 2.5 us (0.9) and compile for 10 CPU s (0.7).
LONGEST = 8


class SingularMatrixError(ArithmeticError):
    """A system of linear equations without a unique solution, to working precision."""


def solve_linear(a, b):
    """Solve a x = b by elimination with scaled partial pivoting.

    Parameters
    ----------
    a : tuple of n tuples of n numbers
        Rows of the matrix.
    b : tuple of n numbers

    Returns
    -------
    tuple of n floats

    Raises
    ------
    SingularMatrixError
        If a pivot is below n eps of the largest entry of its row.
    """
    return in_python(linear_solved, SINGULAR, a, b)


def linear_solved(a, b, eliminate=None):
    if any(len(row) != len(b) for row in a) or len(a) != len(b):
        raise ValueError(f"the matrix must have {len(b)} rows of {len(b)} numbers")
    return (eliminate or eliminated)([[*row, r] for row, r in zip(a, b, strict=True)])


def eliminated(rows):
    """Solve the n x (n + 1) system; (x, whether the matrix is regular and finite)."""
    n = len(rows)
    rows = [list(row) for row in rows]
    scale = [largest(row[:n]) for row in rows]
    regular = True
    for k in range(n):
        for i in range(k + 1, n):  # row k becomes the row with the better pivot
            swap = abs(rows[i][k]) * scale[k] > abs(rows[k][k]) * scale[i]
            pairs = [(rows[k][j], rows[i][j]) for j in range(k, n + 1)]
            rows[k][k:] = [select(swap, y, x) for x, y in pairs]
            rows[i][k:] = [select(swap, x, y) for x, y in pairs]
            upper = scale[k]
            lower = scale[i]
            scale[k], scale[i] = select(swap, lower, upper), select(swap, upper, lower)
        floor = scale[k] * EPS
        total = floor
        for _ in range(n - 1):
            total = total + floor
        sound = abs(rows[k][k]) > total  # false for NaN too
        regular = sound if k == 0 else regular & sound
        for i in range(k + 1, n):
            factor = quotient(rows[i][k], rows[k][k])
            for j in range(k + 1, n + 1):
                rows[i][j] = rows[i][j] - factor * rows[k][j]
    x: list = [None] * n
    for k in reversed(range(n)):
        total = rows[k][n]
        for j in range(k + 1, n):
            total = total - rows[k][j] * x[j]
        x[k] = quotient(total, rows[k][k])
    return x, regular


def select(condition, x, y):
    """x where the condition holds, else y: numbers, Lanes or symbols."""
    if type(condition) in (bool, np.bool_):
        return x if condition else y
    return condition.choose(x, y)


def quotient(x, y):
    """x / y; for numbers, infinite or NaN where y is zero."""
    if type(y) is not float or y != 0.0:
        return x / y
    return math.nan if x == 0.0 or x != x else math.copysign(math.inf, x) * math.copysign(1, y)


def largest(values):
    """The largest absolute value."""
    largest, *others = map(abs, values)
    for x in others:
        largest = select(x > largest, x, largest)
    return largest


def in_python(formula, message, *given):
    """The x of ``formula(*lists)``, a pair (x, whether x is the only solution), on numbers."""
    x, regular = formula(*map(_in_tuples, given))
    if not regular:
        raise SingularMatrixError(message)
    return tuple(x)


def _in_tuples(given):
    """Numbers in tuples, as lists of floats; TypeError for anything else, such as a text."""
    try:
        found = _floats(given)
    except (TypeError, ValueError):
        found = None
    if not isinstance(found, list):
        raise TypeError(
            "a matrix is a tuple of rows, a row or a right-hand side a tuple of numbers; got "
            f"{given!r}."
        )
    return found


def _floats(given):
    if isinstance(given, str):
        raise TypeError("a text is no number")
    if isinstance(given, float) or not np.iterable(given):
        return float(given)
    return [*map(_floats, given)]
