"""The border of the domain of the equations: no step ends beyond it, a run may end at it.

A stage beyond the border has no derivative (NaN), which rejects the step in every adaptive method.
This file checks the end of each step: an implicit method may accept an end without a derivative.
The interpolant is checked, too: at equal distances, and near its least values between these points.

Components that must not be negative follow L. F. Shampine, S. Thompson, J. A. Kierzenka and G. D.
Byrne, "Non-negative solutions of ODEs", Appl. Math. Comput. 170 (2005): a step to a value below
-atol is rejected; a value that is less negative becomes 0, and the derivative is found anew.
"""

import numpy as np

from ..calls.block import MASS
from ..calls.calling_convention import invoke
from ..calls.consistent import rates_of
from ..calls.user_function import by_pointer, evaluate
from ..jit.options import INTERNAL, njit
from ..state.record import (
    ATOL,
    BAD_JACOBIAN,
    BORDER,
    FAILED_AGAIN,
    RAISED,
    RTOL,
    RUNNING,
    STAGE,
    STEP_TOO_SMALL,
    Y_OLD,
    K,
    Y,
)
from ..state.rows import copy_row, slot
from ..vector.scalar_or_vector import spacing
from .arguments import CHECKS, CLIPS, WITHIN
from .dense_output import interpolate, polynomial
from .projection import derive

# Results of `keep_inside`.
KEPT, CHANGED, TAKEN_BACK, TOO_SHORT, RAISES, ENDS, BEYOND = range(7)
STUCK, NEAR = 50, 1e-3  # see `_clings`
PARTS = 8  # of a step, at whose ends the domain is looked at
GOLDEN = 0.6180339887498949  # of golden sections
SECTIONS = 30  # the least value is sought to 1e-7 of a step
OUTSIDE, RAISED_WITHIN = -1.0, -2.0  # stand for values that are not positive, and for none
SHORTEST = 10.0  # steps, in units of the spacing of times
LOOKS = 9  # distances from the end of a run, each four times longer, at which the border is sought


@njit(**INTERNAL)
def keep_inside(kernels, solve, d, scratch):
    """Check a step; return KEPT, CHANGED, TAKEN_BACK, TOO_SHORT, RAISES, ENDS or BEYOND.

    The memory d of a polynomial is overwritten.
    """
    s = solve.state[0]
    work = solve.work
    y = work[Y]
    found = KEPT
    if kernels.keeps & CLIPS:
        if not evaluate(kernels.project, s.t, slot(None, work, Y), scratch[0]):
            return RAISES
        for i in range(len(y)):
            if scratch[0, i] - y[i] > work[ATOL, i]:
                return _take_back(kernels, solve)
        for i in range(len(y)):
            if scratch[0, i] != y[i]:
                s.cut += (scratch[0, i] - y[i]) / work[ATOL, i]
                y[i] = scratch[0, i]
                found = CHANGED
    if kernels.keeps & CHECKS:
        if not evaluate(kernels.inside, s.t, slot(None, work, Y), scratch[0]):
            return RAISES
        if not scratch[0, 0] > 0.0:
            return _take_back(kernels, solve)
        if s.n_rejected > s.n_accepted + STUCK and _clings(kernels, solve, scratch):
            return ENDS
    if kernels.keeps & WITHIN:
        least = leaves_within(kernels, solve, d, scratch)
        if least == RAISED_WITHIN:
            return RAISES
        if not least > 0.0:
            found = _take_back(kernels, solve)
            return BEYOND if found == TOO_SHORT else found
    return found


@njit(**INTERNAL)
def _clings(kernels, solve, scratch):
    """True if a short step by y', a small share of the tolerance, leads over the border.

    The equations of an implicit step may have a solution inside the domain where the exact solution
    leaves the domain; an example is y_1 = y_0 - h sqrt(y_1).  The run would crawl along the border,
    and the first trial of each step would be rejected.
    """
    s = solve.state[0]
    work = solve.work
    steepest = 0.0
    rate = slot(None, work, K + kernels.fsal_stage)
    if solve.block[MASS] != 0:
        rate = scratch[0]
        rates_of(solve.block[MASS], s.t, slot(None, work, Y), rate)
    for i in range(len(rate)):
        tolerance = work[ATOL, i] + work[RTOL, i] * abs(work[Y, i])
        steepest = max(steepest, abs(rate[i]) / tolerance)
    if not steepest > 0.0:
        return False
    h = s.direction * NEAR / steepest
    for i in range(len(rate)):
        scratch[1, i] = work[Y, i] + h * rate[i]
    inside = evaluate(kernels.inside, s.t + h, scratch[1], scratch[0])
    return inside and not scratch[0, 0] > 0.0


@njit(**INTERNAL)
def _take_back(kernels, solve):
    """Reject the last step; a method begins anew with half of the step at most."""
    s = solve.state[0]
    work = solve.work
    h = 0.5 * abs(s.t - s.t_old)
    copy_row(work[Y_OLD], work[Y])
    s.t = s.t_old
    s.n_accepted -= 1
    s.n_rejected += 1
    if h < SHORTEST * spacing(s.t, s.direction):
        return TOO_SHORT
    status = _begin_anew(kernels, solve, h)
    return TAKEN_BACK if status == RUNNING else RAISES if status == RAISED else TOO_SHORT


@njit(**INTERNAL)
def _begin_anew(kernels, solve, h):
    """Let a method begin at the present state, with a step of size h at most; the status.

    A method that looks back at more than one step chooses its step as at the start of a solve.
    """
    s = solve.state[0]
    work = solve.work
    for i in range(K, work.shape[0]):
        for j in range(work.shape[1]):
            work[i, j] = 0.0
    s.order = s.n_equal = 0
    s.h_old = 0.0
    s.t_old = s.t
    if kernels.n_past == 0:
        s.h = h
        return derive(solve, kernels.fsal_stage)
    s.h = 0.0
    start = (solve.state, work, solve.block, kernels.order, kernels.fsal_stage)
    status = invoke(kernels.start, start)
    s.h = min(s.h, h) if s.h > 0.0 else h
    return status


@njit(**INTERNAL)
def goes_on(kernels, solve, scratch, status):
    """Begin anew with a shorter step if the Jacobian is NaN at the border; True on success.

    Differences are NaN if they reach over the border.  A Jacobian behind the border is NaN, too.
    LSODA shortens a step ten times; where a component is kept from being negative, that is not
    enough.
    """
    s = solve.state[0]
    if status == FAILED_AGAIN and kernels.keeps & CLIPS and s.h > 2.0 * s.h_least:
        s.n_rejected += 1
        h = 0.5 * s.h
        if h < SHORTEST * spacing(s.t, s.direction):
            return False
        return _begin_anew(kernels, solve, h) == RUNNING
    if status != BAD_JACOBIAN or kernels.keeps & CHECKS == 0:
        return False
    if not evaluate(kernels.inside, s.t, slot(None, solve.work, Y), scratch[0]):
        return False
    if not scratch[0, 0] > 0.0:  # the step has been taken, though not counted
        s.n_accepted += 1
        return _take_back(kernels, solve) == TAKEN_BACK
    s.n_rejected += 1
    h = 0.5 * min(s.h, s.h_max)
    if h < SHORTEST * spacing(s.t, s.direction):
        return False
    return _begin_anew(kernels, solve, h) == RUNNING


@njit(**INTERNAL)
def settle(kernels, solve, scratch):
    """Evaluate the derivative at a changed end; clear the past of components that became 0.

    Returns False if the function raised.
    """
    s = solve.state[0]
    work = solve.work
    first = kernels.past
    if s.t == s.t_old:  # behind a jump
        return True
    if kernels.n_past > 0:
        scratch[0, :] = -1.0
        if not evaluate(kernels.project, s.t, scratch[0], scratch[1]):
            return False
        for i in range(work.shape[1]):
            if scratch[1, i] == 0.0 and work[Y, i] == 0.0:  # a component of `nonnegative`
                for r in range(first, first + kernels.n_past):
                    work[r, i] = 0.0
    return derive(solve, kernels.fsal_stage) != RAISED


@njit(**INTERNAL)
def at_border(kernels, solve, scratch, status):
    """The status of a run that ends; BORDER if the steps failed because of the border."""
    if kernels.inside == 0 or status < STEP_TOO_SMALL or status == RAISED:
        return status
    if status == BAD_JACOBIAN and kernels.keeps & CHECKS and _clings(kernels, solve, scratch):
        return BORDER  # the border is nearer than the differences reach
    s = solve.state[0]
    work = solve.work
    y = slot(None, solve.work, Y)
    rate = slot(None, work, STAGE)
    if solve.block[MASS] != 0:
        rates_of(solve.block[MASS], s.t, y, rate)
    else:
        by_pointer(s.t, y, solve.block, rate)
        s.n_extra += 1
    for i in range(len(y)):
        if not np.isfinite(rate[i]):
            return status
    h = SHORTEST * spacing(s.t, s.direction)
    for _ in range(LOOKS):
        for i in range(len(y)):
            scratch[1, i] = y[i] + s.direction * h * rate[i]
        if not evaluate(kernels.inside, s.t + s.direction * h, scratch[1], scratch[0]):
            return RAISED
        if not scratch[0, 0] > 0.0:
            return BORDER
        h *= 4.0
    return status


@njit(**INTERNAL)
def leaves_within(kernels, solve, d, scratch):
    """OUTSIDE if the last step leaves the domain, RAISED_WITHIN if the function raised, else 1.

    The interpolant of the step is written to d.
    """
    interpolate(kernels, solve, d)
    before = left = _inside(kernels, solve, d, scratch, 0.0)
    right = _inside(kernels, solve, d, scratch, 1.0 / PARTS)
    for i in range(PARTS):
        if not left > 0.0:
            return left
        if not right > 0.0:
            return right
        after = _inside(kernels, solve, d, scratch, min(i + 2, PARTS) / PARTS)
        # A function that goes on with the slopes beside this part reaches zero in it, or nearly so.
        if left + right < 2.0 * max(abs(left - before), abs(after - right)):
            least = _least(kernels, solve, d, scratch, i / PARTS, (i + 1) / PARTS)
            if not least > 0.0:
                return least
        before = left
        left = right
        right = after
    return 1.0


@njit(**INTERNAL)
def _inside(kernels, solve, d, scratch, x):
    """The function at x in [0, 1] of the last step; OUTSIDE for NaN and 0, too."""
    s = solve.state[0]
    polynomial(d, x, scratch[1])
    if not evaluate(kernels.inside, s.t_old + x * (s.t - s.t_old), scratch[1], scratch[0]):
        return RAISED_WITHIN
    return scratch[0, 0] if scratch[0, 0] > 0.0 else OUTSIDE


@njit(**INTERNAL)
def _least(kernels, solve, d, scratch, a, b):
    """The least value of the function in [a, b], or the first value that is not positive."""
    left = b - GOLDEN * (b - a)
    right = a + GOLDEN * (b - a)
    at_left = _inside(kernels, solve, d, scratch, left)
    at_right = _inside(kernels, solve, d, scratch, right)
    for _ in range(SECTIONS):
        if at_left < at_right:
            if not at_left > 0.0:
                return at_left
            b = right
            right = left
            at_right = at_left
            left = b - GOLDEN * (b - a)
            at_left = _inside(kernels, solve, d, scratch, left)
        else:
            if not at_right > 0.0:
                return at_right
            a = left
            left = right
            at_left = at_right
            right = a + GOLDEN * (b - a)
            at_right = _inside(kernels, solve, d, scratch, right)
    return min(at_left, at_right)
