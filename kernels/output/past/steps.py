"""Steps of a delay equation that contain their own past.

An evaluation may ask for the past at a time within the step that is being taken: a delay vanishes,
or is shorter than the step.  Then the past is a trial polynomial.  The step is taken again with the
polynomial that it gave, until the polynomial changes no more: A. Bellen and M. Zennaro, "Numerical
Methods for Delay Differential Equations", Oxford 2003, section 3.3.  The method's own kernel takes
the steps, and controls their error.
"""

import numpy as np
from numba import carray

from ...calls.block import PAST_OF_RARE, RAISED_WORD, RARE
from ...calls.calling_convention import invoke
from ...calls.user_function import address_of, by_pointer, numbers_at, words_at
from ...jit.options import INTERNAL, njit
from ...state.record import ATOL, RTOL, STATE, STEP_TOO_SMALL, K, Y
from ...vector.scalar_or_vector import spacing
from .. import arguments as past
from ..dense_output import F, hermite, polynomial, slope_of_polynomial

N_STATE = STATE.itemsize // 8
# The iteration ends where its error is this share of the tolerance, Radau's for Newton's iteration.
SHARE = 0.03
MOST = 12  # iterations of a step; a step that needs more is shortened
SHORTER = 0.25
SLOW = 8  # iterations behind which the next step is no longer
# The shares of the step at which the residual of the polynomial is bounded.
SAMPLES = (0.04, 0.5, 0.96)
# Largest residual, times the step, in units of the tolerance.
LARGEST = 2.0
# An estimate may be zero by chance.  By a step at most GROWTH times as long as the last, an error
# of order 5 grows to 11 times that of the last at most.  A longer step is looked at: the residual
# of a step of 2.9 times the last was 16 000, its error 460 tolerances, its estimate below 1 (Tsit5,
# Mackey and Glass at 3e-7); beside right estimates, few were above OF_GROWN.
GROWTH = 1.5
OF_GROWN = 30.0
PLACES = 4  # shares of the step at which two polynomials are compared: 1/4, 1/2, 3/4, 1


@njit(**INTERNAL)
def _grows(words, h):
    """Whether a step of size h is far longer than the last step, or the first."""
    count = words_at(words[past.PAST_COUNT])[0]
    if count == 0:
        return True
    return h > GROWTH * numbers_at(words[past.PAST_SPANS])[2 * count - 1]


@njit(**INTERNAL)
def _predict(s, work, words, trial):
    """The polynomial of the last step, or the tangent where that is not near.

    The last polynomial ends elsewhere behind a jump of the state.
    """
    n = work.shape[1]
    rows = words[past.PAST_ROWS]
    count = words_at(words[past.PAST_COUNT])[0]
    if count > 0:
        spans = carray(numbers_at(words[past.PAST_SPANS]), (count, 2))
        start = spans[count - 1, 0]
        size = spans[count - 1, 1]
        if s.h <= size and abs(start + size - s.t) <= spacing(s.t, s.direction):
            trial[0] = start
            trial[1] = size
            last = numbers_at(words[past.PAST_D] + 8 * (count - 1) * rows * n)
            for i in range(rows * n):
                trial[2 + i] = last[i]
            return
    trial[0] = s.t
    trial[1] = s.h
    for i in range(rows * n):
        trial[2 + i] = 0.0
    slope = K + words[past.PAST_FSAL]
    for i in range(n):
        trial[2 + i] = work[Y, i]
        trial[2 + F * n + i] = s.h * work[slope, i]


@njit(**INTERNAL)
def _take(trial, start, size, d, rows):
    """Let the first rows of a polynomial be the trial."""
    n = d.shape[1]
    trial[0] = start
    trial[1] = size
    for r in range(d.shape[0]):
        for i in range(n):
            trial[2 + r * n + i] = d[r, i] if r < rows else 0.0


@njit(**INTERNAL)
def _copy_state(state, work, words, kept, back):
    """Copy the record and the rows of the method to `kept`, or back."""
    record = numbers_at(address_of(state))
    for i in range(N_STATE):
        if back:
            record[i] = kept[i]
        else:
            kept[i] = record[i]
    n = work.shape[1]
    for r in range(words[past.PAST_N_ROWS]):
        for i in range(n):
            at = N_STATE + r * n + i
            if back:
                work[r, i] = kept[at]
            else:
                kept[at] = work[r, i]


@njit(**INTERNAL)
def _go_back(state, work, words, kept):
    """Return to the start of the step; its evaluations are those of a rejected step."""
    s = state[0]
    n_rejected = s.n_rejected + s.n_accepted
    n_extra = s.n_extra
    n_jacobians = s.n_jacobians
    n_factorised = s.n_factorised
    _copy_state(state, work, words, kept, True)
    s.n_rejected = n_rejected - s.n_accepted
    s.n_extra = n_extra
    s.n_jacobians = n_jacobians
    s.n_factorised = n_factorised
    s.factorised = 0  # the matrices are those of the step that is given up
    s.current = 0


@njit(**INTERNAL)
def size_of(work, state, difference):
    """The root of the mean square of a difference, in units of the tolerance; inf for NaN."""
    total = 0.0
    for i in range(len(state)):
        x = difference[i] / (work[ATOL, i] + work[RTOL, i] * abs(state[i]))
        total += x * x
    return np.sqrt(total / len(state)) if total == total else np.inf


@njit(**INTERNAL)
def _change(work, trial, rows, start, size, d, values):
    """The largest difference of two polynomials within a step, in units of the tolerance."""
    n = work.shape[1]
    earlier = carray(numbers_at(address_of(trial) + 16), (rows, n))
    largest = 0.0
    for k in range(1, PLACES + 1):
        x = k / PLACES
        # Of close times the difference is exact: a number may move far within a rounding of t.
        polynomial(earlier, (start - trial[0] + x * size) / trial[1], values[0])
        polynomial(d, x, values[1])
        for i in range(n):
            values[0, i] = values[1, i] - values[0, i]
        largest = max(largest, size_of(work, values[1], values[0]))
    return largest


@njit(**INTERNAL)
def _residual(state, work, block, words, d, values):
    """The largest of h |P' - f(t, P)| at the samples, in units of the tolerance.

    Where a jump is within the step, as of a past that a varying delay has passed, the residual is
    as large as the jump, and the estimate of a method may not see it.  In stiff components, a
    residual is far larger than the error that it makes, which the filter of the method estimates.
    """
    s = state[0]
    n = work.shape[1]
    h = s.t - s.t_old
    largest = 0.0
    for x in SAMPLES:
        t = s.t_old + x * h
        polynomial(d, x, values[0])
        slope_of_polynomial(d, x, h, 0, values[1])
        by_pointer(t, values[0], block, values[2])
        s.n_extra += 1
        for i in range(n):
            values[2, i] = h * (values[2, i] - values[1, i])
        size = size_of(work, values[0], values[2])
        if words[past.PAST_FILTER] != 0 and LARGEST < size < np.inf:
            falls = invoke(words[past.PAST_FILTER], (state, work, block, t, values))
            size = size_of(work, values[0], values[3]) if falls == 1 else np.inf
        largest = max(largest, size)
    return largest


@njit(**INTERNAL)
def _between_stages(s, work, words, d):
    """The error of Radau's polynomial within a step, in units of the tolerance.

    The polynomial of degree 3 meets the start and the stages, so that its error is h^4 y4 / 24
    times x (x - c1) (x - c2) (x - 1), at most 0.02, with the fourth derivative y4.  That is the
    change of the third since the last step, or the third over h where there is no step before.  The
    estimate of the method does not see this error in stiff components, and delays read it.
    """
    n = work.shape[1]
    h = s.t - s.t_old
    count = words_at(words[past.PAST_COUNT])[0]
    rows = words[past.PAST_ROWS]
    size = 0.0
    last = numbers_at(words[past.PAST_D] + 8 * max(count - 1, 0) * rows * n)
    if count > 0:
        spans = carray(numbers_at(words[past.PAST_SPANS]), (count, 2))
        if abs(spans[count - 1, 0] + spans[count - 1, 1] - s.t_old) <= spacing(s.t, s.direction):
            size = spans[count - 1, 1]
    total = 0.0
    for i in range(n):
        fourth = d[F + 2, i]  # but for the sign, h^3 y3 / 6, then h^4 y4 / 6
        if size > 0.0:
            before = last[(F + 2) * n + i] * (h / size) ** 3
            fourth = (fourth - before) * h / (0.5 * (h + size))
        error = 0.02 / 4.0 * fourth / (work[ATOL, i] + work[RTOL, i] * abs(work[Y, i]))
        total += error * error
    return np.sqrt(total / n)


@njit(**INTERNAL)
def _shortened(state, work, block, words, d, values):
    """The factor by which a converged step must be shortened for its polynomial; 1 if it need not.

    Bounds the next step by the error between the stages, if that is looked at.
    """
    s = state[0]
    looks = words[past.PAST_LOOKS]
    if looks & past.GROWN != 0 and _grows(words, s.t - s.t_old):
        if _residual(state, work, block, words, d, values) > OF_GROWN:
            return SHORTER
    if looks & past.STAGES != 0:
        error = _between_stages(s, work, words, d)
        factor = 0.9 * error**-0.25 if error > 0.0 else np.inf
        if error > 1.0:
            return max(SHORTER, factor)
        s.h = min(s.h, factor * (s.t - s.t_old))
    if looks & past.RESIDUALS != 0:
        largest = OF_GROWN if looks & past.STAGES != 0 else LARGEST
        if _residual(state, work, block, words, d, values) > largest:
            return SHORTER
    return 1.0


@njit(**INTERNAL)
def advance(state, work, block, n_steps):
    """Take one step; see `adaptive.kernel`."""
    s = state[0]
    words = words_at(words_at(block[RARE])[PAST_OF_RARE])
    alone = words[past.PAST_LOOKS] & ~past.GROWN == 0  # no step contains its past
    if alone and not _grows(words, s.h):
        return invoke(words[past.PAST_ADVANCE], (state, work, block, 1))
    rows = words[past.PAST_ROWS]
    n = work.shape[1]
    size_of_trial = 2 + rows * n
    address = words[past.PAST_TRIAL]
    trial = carray(numbers_at(address), (size_of_trial,))
    values = carray(numbers_at(address + 8 * size_of_trial), (4, n))
    d = carray(numbers_at(address + 8 * (size_of_trial + 4 * n)), (rows, n))
    kept = carray(
        numbers_at(address + 8 * (size_of_trial + (4 + rows) * n)),
        (N_STATE + words[past.PAST_N_ROWS] * n,),
    )
    words[past.PAST_COUPLED] |= past.STEPPING
    _copy_state(state, work, words, kept, False)
    before = s.n_accepted
    h_min = 10.0 * spacing(s.t, s.direction)
    _predict(s, work, words, trial)
    change = np.inf
    iterations = 0
    while True:
        words[past.PAST_ASKED] = 0
        status = invoke(words[past.PAST_ADVANCE], (state, work, block, 1))
        h = s.t - s.t_old
        if s.n_accepted == before or (alone and not _grows(words, h)):
            break  # a failure, or nothing to look at
        hermite(h, words[past.PAST_FSAL], work, d)
        if words[past.PAST_ASKED] == 0:  # the stages of the interpolant may still ask
            _take(trial, s.t_old, h, d, F + 3)
        s.n_extra += invoke(words[past.PAST_DENSE_ROWS], (s.t_old, h, work, block, d))
        converged = words[past.PAST_ASKED] == 0
        if not converged:
            last = change
            change = _change(work, trial, rows, s.t_old, h, d, values)
            rate = change / last  # 0 for the first
            left = change if last == np.inf else change * rate / (1.0 - rate)
            converged = change == 0.0 or (rate < 1.0 and left < SHARE)
        factor = 1.0  # by which the step is shortened
        if converged:
            if iterations > SLOW:
                s.h = min(s.h, h)
            factor = _shortened(state, work, block, words, d, values)
            if factor == 1.0 or block[RAISED_WORD] != 0:
                break
        else:
            iterations += 1
            if iterations >= MOST or (iterations > 2 and rate >= 1.0) or not change < np.inf:
                factor = SHORTER
        _go_back(state, work, words, kept)
        if factor < 1.0:
            h = factor * h
            if h < h_min:
                status = STEP_TOO_SMALL
                break
            s.h = h
            _predict(s, work, words, trial)
            change = np.inf
            iterations = 0
            continue
        s.h = h
        _take(trial, s.t, h, d, rows)
    words[past.PAST_COUPLED] &= past.COUPLED
    return status
