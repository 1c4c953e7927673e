"""The start of M y' = f(t, y) for a constant M: consistent states, and derivatives of the state.

The functions `rates`, `change`, `settle` and `act` have the common form of the user's functions and
are called by their addresses (`calls/consistent.py`).  Their block, at the address PENCIL of the
words of M (`mass.py`), has its words in `calls/block.py`; at NUMBERS are those of a `Pencil`.  Rows
of `left` are combinations of the equations that are free of y', rows of `right` are directions of y
that M does not see: there are none if M is regular.

What is singular or does not converge sets RAISED_WORD, and the block keeps what a sentence needs:
the time at TIME, what failed, the state in the last of `states`.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import carray

from ..calls.block import (
    ACTION,
    EQUATIONS,
    EVALUATIONS,
    FAILURE,
    N_ALGEBRAIC,
    NO_START,
    NOT_FOUND,
    NUMBERS,
    PENCIL_OF_ACTION,
    RAISED_WORD,
    TIME,
    WORDS_OF_ACTION,
    WORDS_OF_PENCIL,
)
from ..calls.user_function import call_function, numbers_at, raised, words_at
from ..jit_options import INTERNAL, njit
from ..state.rows import copy_row
from ..vector.scalar_or_vector import spacing
from .factorise import factorise, solve

STEP = float(np.finfo(float).eps) ** (1 / 3)  # of a central difference, relative to a component
LEAST = 1e-3  # size that a component has at least, for differences
FORWARD = float(np.finfo(float).eps) ** 0.5
SINGULAR = 1e-9  # pivot of a singular matrix, with rows and columns scaled to size 1
ITERATIONS, HALVINGS = 50, 30
DESCENT = 1e-4  # the share of the linear decrease that a step must reach
CLOSE, NEAR = 1e-12, 1e-4  # last change, relative to a component and to its tolerance


class Pencil(NamedTuple):
    """The numbers of a pencil of n components with r algebraic equations.

    `span` is the end less the start of the run, finite; `inverse` maps f to a y' with M y' = f, if
    there is one.  Then room: the matrix of Newton's iteration by columns, its pivots, sizes of its
    rows and columns, a right-hand side; five states, the last for a failure.
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
def _pencil(block, n):
    """The words of a pencil's block, and its numbers."""
    words = carray(block, WORDS_OF_PENCIL)
    r, at = words[N_ALGEBRAIC], words[NUMBERS]
    of_row, of_matrix = 8 * n, 8 * r * n
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
def _is_finite(row):
    total = 0.0
    for i in range(len(row)):
        total += row[i] - row[i]
    return total == 0.0


@njit(**INTERNAL)
def _evaluate(words, t, y, out):
    """The right-hand side; False if it raised, or is not finite."""
    call_function(words[EQUATIONS], t, y, out)
    words[EVALUATIONS] += 1
    return not raised(words[EQUATIONS]) and _is_finite(out)


@njit(**INTERNAL)
def _least(y):
    """The least size of a component for differences: a share of the median."""
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
    moved, above = p.states[MOVED], p.states[ABOVE]
    size = np.inf
    for i in range(len(y)):
        if direction[i] != 0.0:
            size = min(size, STEP * max(abs(y[i]), least) / abs(direction[i]))
    for i in range(len(y)):
        moved[i] = y[i] + size * direction[i]
    if not _evaluate(words, t, moved, above):
        return False
    for i in range(len(y)):
        moved[i] = y[i] - size * direction[i]
    below = p.states[TRIAL]
    if not _evaluate(words, t, moved, below):
        return False
    for j in range(len(p.left)):
        total = 0.0
        for i in range(len(y)):
            total += p.left[j, i] * (above[i] - below[i])
        out[j] = total / (2.0 * size)
    return True


@njit(**INTERNAL)
def _factorise(words, p, t, y):
    """The factors of the Jacobian of the algebraic equations; False if it is singular."""
    r, least, a = len(p.left), _least(y), p.matrix
    rows, columns = p.small[ROWS], p.small[COLUMNS]
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
def _solve(p, out):
    """Put the change of y, that makes the equations equal to RIGHT_SIDE, in the row `out`."""
    r, b = len(p.left), p.small[RIGHT_SIDE]
    for j in range(r):
        b[j] /= p.small[ROWS, j]
    solve(p.matrix.reshape(-1), r, p.small[PIVOTS], b, r, r - 1, r - 1)
    for i in range(len(out)):
        out[i] = 0.0
    for k in range(r):
        for i in range(len(out)):
            out[i] += p.right[k, i] * (b[k] / p.small[COLUMNS, k])


@njit(**INTERNAL)
def _algebraic(p, f, sign):
    """Put the algebraic equations, times a sign, in RIGHT_SIDE; their size in units of rows."""
    size = 0.0
    for j in range(len(p.left)):
        total = 0.0
        for i in range(len(f)):
            total += p.left[j, i] * f[i]
        p.small[RIGHT_SIDE, j] = sign * total
        size = max(size, abs(total) / p.small[ROWS, j])
    return size


@njit(**INTERNAL)
def _fail(words, p, t, failure):
    """Keep what a sentence needs, besides the state."""
    words[RAISED_WORD], words[FAILURE] = 1, failure
    words.view(np.float64)[TIME] = t


@njit(**INTERNAL)
def rates(t, y, n, block, out):
    """The derivative y' of a consistent state: M y' = f, and d/dt of the algebraic equations is 0.

    NaN where they do not determine it.
    """
    words, p = _pencil(block, n)
    state, rate, f = carray(y, n), carray(out, n), p.states[F]
    known = _evaluate(words, t, state, f)
    for i in range(n):
        rate[i] = 0.0
        for j in range(n):
            rate[i] += p.inverse[i, j] * f[j]
    if not known or len(p.left) == 0:
        return
    if not _factorise(words, p, t, state):
        rate[:] = np.nan
        return
    h = FORWARD * max(abs(t), abs(p.span[0]))
    for i in range(n):
        if rate[i] != 0.0:
            h = min(h, FORWARD * max(abs(state[i]), LEAST) / abs(rate[i]))
    direction = 1.0 if p.span[0] >= 0.0 else -1.0
    t_new = t + direction * max(h, 64.0 * spacing(t, direction))
    for i in range(n):
        p.states[MOVED, i] = state[i] + (t_new - t) * rate[i]
    if not _evaluate(words, t_new, p.states[MOVED], p.states[ABOVE]):
        rate[:] = np.nan
        return
    for i in range(n):
        f[i] = (p.states[ABOVE, i] - f[i]) / (t_new - t)
    _algebraic(p, f, -1.0)
    _solve(p, p.states[TRIAL])
    for i in range(n):
        rate[i] += p.states[TRIAL, i]


@njit(**INTERNAL)
def change(t, y, n, block, out):
    """The change of y by a step of Newton's iteration towards a consistent state, NaN without one.

    RAISED_WORD is set, for a start, if the change is larger than the tolerance.
    """
    words, p = _pencil(block, n)
    state, found = carray(y, n), carray(out, n)
    found[:] = 0.0
    if len(p.left) == 0:
        return
    copy_row(state, p.states[FAILED])
    if not _evaluate(words, t, state, p.states[F]) or not _factorise(words, p, t, state):
        found[:] = np.nan
        _fail(words, p, t, NO_START)
        return
    _algebraic(p, p.states[F], -1.0)
    _solve(p, found)
    for i in range(n):
        if not abs(found[i]) <= p.atol[i] + p.rtol[i] * abs(state[i]):
            _fail(words, p, t, NO_START)


@njit(**INTERNAL)
def _descend(words, p, t, y, direction, before):
    """Move y along a direction, or by a part of it, so that the equations decrease; whether."""
    share, trial = 1.0, p.states[TRIAL]
    for _ in range(HALVINGS):
        for i in range(len(y)):
            trial[i] = y[i] + share * direction[i]
        if _evaluate(words, t, trial, p.states[F]):
            if _algebraic(p, p.states[F], -1.0) <= (1.0 - DESCENT * share) * before:
                copy_row(trial, y)
                return True
        share *= 0.5
    return False


@njit(**INTERNAL)
def settle(t, y, n, block, out):
    """The consistent state with M times the state as in y, by Newton's iteration."""
    words, p = _pencil(block, n)
    state, direction = carray(out, n), p.states[MOVED]
    copy_row(carray(y, n), p.states[FAILED])
    copy_row(p.states[FAILED], state)
    if len(p.left) == 0:
        return
    found = _evaluate(words, t, state, p.states[F])
    for _ in range(ITERATIONS):
        if not found or not _factorise(words, p, t, state):
            break
        size = _algebraic(p, p.states[F], -1.0)
        if size == 0.0:
            return
        _solve(p, direction)
        small = True
        for i in range(n):
            tolerance = p.atol[i] + p.rtol[i] * abs(state[i])
            small = small and abs(direction[i]) <= CLOSE * abs(state[i]) + NEAR * tolerance
        found = _descend(words, p, t, state, direction, size)
        if small:
            return
    _fail(words, p, t, NOT_FOUND)


@njit(**INTERNAL)
def act(t, y, n, block, out):
    """The state behind an action of the user, made consistent."""
    own, new = carray(block, WORDS_OF_ACTION), carray(out, n)
    action, pencil = own[ACTION], own[PENCIL_OF_ACTION]
    call_function(action, t, carray(y, n), new)
    if raised(action):
        own[RAISED_WORD] = 1
    elif _is_finite(new):
        settle(t, out, n, words_at(pencil), out)
        own[RAISED_WORD] = words_at(pencil)[RAISED_WORD]
