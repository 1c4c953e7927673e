"""Consistent states and derivatives of M y' = f(t, y) for a constant M.

The functions `rates`, `change`, `settle` and `act` have the common form of the user's functions and
are called by their addresses (`calls/consistent.py`), with the block of a pencil (`pencil.py`).

A singular matrix, or an iteration that does not converge, sets RAISED_WORD.  The block then keeps
the data of the message: the time in the word TIME, the failure in the word FAILURE, and the state
in the last row of `states`.
"""

import numpy as np
from numba import carray

from ..calls.block import (
    ACTION,
    NO_START,
    NOT_FOUND,
    PENCIL_OF_ACTION,
    RAISED_WORD,
    WORDS_OF_ACTION,
)
from ..calls.user_function import call_function, raised, words_at
from ..jit.options import INTERNAL, njit
from ..state.rows import copy_row
from ..vector.scalar_or_vector import spacing
from .pencil import (
    ABOVE,
    FAILED,
    LEAST,
    MOVED,
    TRIAL,
    F,
    algebraic_size,
    evaluate_finite,
    factorise_algebraic,
    fail,
    is_finite,
    pencil_at,
    solve_algebraic,
)

FORWARD = float(np.finfo(float).eps) ** 0.5  # step of a forward difference
ITERATIONS = 50
HALVINGS = 30
DESCENT = 1e-4  # the share of the linear decrease that a step must reach
CLOSE, NEAR = 1e-12, 1e-4  # bounds of the last change, relative to a component and to its tolerance


@njit(**INTERNAL)
def rates(t, y, n, block, out):
    """The derivative y' of a consistent state: M y' = f, and d/dt of the algebraic equations is 0.

    NaN if these equations do not determine y'.
    """
    words, p = pencil_at(block, n)
    state = carray(y, n)
    rate = carray(out, n)
    f = p.states[F]
    known = evaluate_finite(words, t, state, f)
    for i in range(n):
        rate[i] = 0.0
        for j in range(n):
            rate[i] += p.inverse[i, j] * f[j]
    if not known or len(p.left) == 0:
        return
    if not factorise_algebraic(words, p, t, state):
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
    if not evaluate_finite(words, t_new, p.states[MOVED], p.states[ABOVE]):
        rate[:] = np.nan
        return
    for i in range(n):
        f[i] = (p.states[ABOVE, i] - f[i]) / (t_new - t)
    algebraic_size(p, f, -1.0)
    solve_algebraic(p, p.states[TRIAL])
    for i in range(n):
        rate[i] += p.states[TRIAL, i]


@njit(**INTERNAL)
def change(t, y, n, block, out):
    """The change of y by a step of Newton's iteration to a consistent state; NaN if there is none.

    RAISED_WORD is set if the change exceeds the tolerance: y is no consistent start.
    """
    words, p = pencil_at(block, n)
    state = carray(y, n)
    found = carray(out, n)
    found[:] = 0.0
    if len(p.left) == 0:
        return
    copy_row(state, p.states[FAILED])
    if not evaluate_finite(words, t, state, p.states[F]) or not factorise_algebraic(
        words, p, t, state
    ):
        found[:] = np.nan
        fail(words, p, t, NO_START)
        return
    algebraic_size(p, p.states[F], -1.0)
    solve_algebraic(p, found)
    for i in range(n):
        if not abs(found[i]) <= p.atol[i] + p.rtol[i] * abs(state[i]):
            fail(words, p, t, NO_START)


@njit(**INTERNAL)
def _descend(words, p, t, y, direction, before):
    """Add a direction, or a part of it, to y so that the residual decreases; True on success."""
    share = 1.0
    trial = p.states[TRIAL]
    for _ in range(HALVINGS):
        for i in range(len(y)):
            trial[i] = y[i] + share * direction[i]
        if evaluate_finite(words, t, trial, p.states[F]):
            if algebraic_size(p, p.states[F], -1.0) <= (1.0 - DESCENT * share) * before:
                copy_row(trial, y)
                return True
        share *= 0.5
    return False


@njit(**INTERNAL)
def settle(t, y, n, block, out):
    """The consistent state x with M x = M y, by Newton's iteration."""
    words, p = pencil_at(block, n)
    state = carray(out, n)
    direction = p.states[MOVED]
    copy_row(carray(y, n), p.states[FAILED])
    copy_row(p.states[FAILED], state)
    if len(p.left) == 0:
        return
    found = evaluate_finite(words, t, state, p.states[F])
    for _ in range(ITERATIONS):
        if not found or not factorise_algebraic(words, p, t, state):
            break
        size = algebraic_size(p, p.states[F], -1.0)
        if size == 0.0:
            return
        solve_algebraic(p, direction)
        small = True
        for i in range(n):
            tolerance = p.atol[i] + p.rtol[i] * abs(state[i])
            small = small and abs(direction[i]) <= CLOSE * abs(state[i]) + NEAR * tolerance
        found = _descend(words, p, t, state, direction, size)
        if small:
            return
    fail(words, p, t, NOT_FOUND)


@njit(**INTERNAL)
def act(t, y, n, block, out):
    """The state behind an action of the user, made consistent."""
    own = carray(block, WORDS_OF_ACTION)
    new = carray(out, n)
    action = own[ACTION]
    pencil = own[PENCIL_OF_ACTION]
    call_function(action, t, carray(y, n), new)
    if raised(action):
        own[RAISED_WORD] = 1
    elif is_finite(new):
        settle(t, out, n, words_at(pencil), out)
        own[RAISED_WORD] = words_at(pencil)[RAISED_WORD]
