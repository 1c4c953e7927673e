"""Dense output: one polynomial a step, in the form of Hairer, Norsett and Wanner (II.6).

With x = (t - t_old) / h in [0, 1],

    y(x) = y_old + x (F0 + (1 - x) (F1 + x (F2 + (1 - x) (F3 + ...)))).

F0, F1, F2 make the cubic Hermite polynomial of the two ends, for every method; a method of higher
order adds rows.  The polynomial meets both ends of the step to round-off.
"""

from numba import carray

from ..calls.block import RAISED_WORD
from ..calls.calling_convention import invoke
from ..calls.user_function import address_of, call_function, numbers_at, words_at
from ..jit.options import INLINED, INTERNAL, njit
from ..state.layout import Form
from ..state.record import RAISED, RUNNING, Y_OLD, K, Y
from ..state.rows import keep_vector, numbers_of, scratch, vector_at
from .arguments import (
    COUPLED,
    PAST_ASKED,
    PAST_BEGINS,
    PAST_COUNT,
    PAST_COUPLED,
    PAST_D,
    PAST_HINT,
    PAST_HISTORY,
    PAST_N,
    PAST_NOW,
    PAST_OPEN,
    PAST_ROOM,
    PAST_ROWS,
    PAST_SLACK,
    PAST_SPANS,
    PAST_T0,
    PAST_TRIAL,
    PAST_Y0,
    STEPPING,
)

F = 1  # rows of `d`: y_old, then F0, F1, ...
WIDTH = 4  # components that `polynomial` evaluates together, each rounded as if alone
VECTOR = Form(1, WIDTH, exact=True)
_lanes = scratch(WIDTH)


@njit(**INTERNAL)
def hermite(h, fsal_stage, work, d):
    """Fill y_old, F0, F1 and F2 in the rows of d; stages 0 and `fsal_stage` are the slopes."""
    for i in range(d.shape[1]):
        rise = work[Y, i] - work[Y_OLD, i]
        first = work[K, i]
        final = work[K + fsal_stage, i]
        d[0, i] = work[Y_OLD, i]
        d[F, i] = rise
        d[F + 1, i] = h * first - rise
        d[F + 2, i] = 2.0 * rise - h * (final + first)


@njit(**INTERNAL)
def polynomial(d, x, out):
    """The value at x in [0, 1], written to `out` of length n."""
    n = d.shape[1]
    last = d.shape[0] - 1
    numbers = numbers_of(d)
    whole = n - n % WIDTH
    for i in range(0, whole, WIDTH):
        total = vector_at(VECTOR, numbers, last * n + i) + 0.0
        for j in range(last, 0, -1):
            total = vector_at(VECTOR, numbers, (j - 1) * n + i) + total * _factor(x, j)
        keep_vector(VECTOR, out, i, total)
    for i in range(whole, n):
        total = d[last, i] + 0.0
        for j in range(last, 0, -1):
            total = d[j - 1, i] + total * _factor(x, j)
        out[i] = total


@njit(**INTERNAL)
def some_of_polynomial(d, x, first, out):
    """The components from `first` on at x, with the bits of `polynomial`."""
    last = d.shape[0] - 1
    for i in range(len(out)):
        total = d[last, first + i] + 0.0
        for j in range(last, 0, -1):
            total = d[j - 1, first + i] + total * _factor(x, j)
        out[i] = total


@njit(**INTERNAL)
def slope_of_polynomial(d, x, h, first, out):
    """The derivatives by t of the components from `first` on, at x of a step of size h."""
    last = d.shape[0] - 1
    for i in range(len(out)):
        total = d[last, first + i] + 0.0
        slope = 0.0
        for j in range(last, 0, -1):
            slope = slope * _factor(x, j) + (total if (j - F) % 2 == 0 else -total)
            total = d[j - 1, first + i] + total * _factor(x, j)
        out[i] = slope / h


@njit(**INTERNAL)
def polynomials(d, t_old, h, times, first, end, out):
    """The values at times[first:end] of the step from t_old, written to these rows of `out`.

    Four times at once, with the bits of `polynomial`: the sums of one time wait for each other.
    """
    n = d.shape[1]
    last = d.shape[0] - 1
    numbers = numbers_of(d)
    whole = n - n % WIDTH
    lanes = _lanes()
    while end - first >= WIDTH:
        x = (vector_at(VECTOR, times, first) - t_old) / h
        keep_vector(VECTOR, lanes, 0, x)
        given = d, numbers, last, lanes[0], lanes[1], lanes[2], lanes[3]
        for i in range(0, whole, WIDTH):
            _four(*given, i, out, first)
        for i in range(whole, n):
            total = x * 0.0 + d[last, i]
            for j in range(last, 0, -1):
                total = total * _factor(x, j) + d[j - 1, i]
            keep_vector(VECTOR, lanes, 0, total)
            for k in range(WIDTH):
                out[first + k, i] = lanes[k]
        first += WIDTH
    for k in range(first, end):
        polynomial(d, (times[k] - t_old) / h, out[k])


@njit(**INLINED)
def _four(d, numbers, last, x0, x1, x2, x3, i, out, first):
    """The values of the components from i on at four places of the step."""
    n = d.shape[1]
    row = vector_at(VECTOR, numbers, last * n + i) + 0.0
    v0 = row
    v1 = row
    v2 = row
    v3 = row
    for j in range(last, 0, -1):
        row = vector_at(VECTOR, numbers, (j - 1) * n + i)
        v0 = row + v0 * _factor(x0, j)
        v1 = row + v1 * _factor(x1, j)
        v2 = row + v2 * _factor(x2, j)
        v3 = row + v3 * _factor(x3, j)
    place = numbers_of(out)
    keep_vector(VECTOR, place, first * n + i, v0)
    keep_vector(VECTOR, place, (first + 1) * n + i, v1)
    keep_vector(VECTOR, place, (first + 2) * n + i, v2)
    keep_vector(VECTOR, place, (first + 3) * n + i, v3)


@njit(**INLINED)
def _factor(x, j):
    """The factor of row j and of the rows behind it."""
    return x if (j - F) % 2 == 0 else 1.0 - x


@njit(**INTERNAL)
def nest(d, order):
    """Bring a polynomial into the form above; row j of d has the coefficients of (x - 1)^j.

    The polynomial is divided by x and by 1 - x in turn.
    """
    for k in range(order):
        for j in range(order - 1, k - 1, -1):
            for i in range(d.shape[1]):
                if k % 2 == 0:
                    d[j, i] -= d[j + 1, i]
                else:
                    d[k + order - j, i] = -d[k + order - j, i]


@njit(**INLINED)
def cubic(rhs, t, h, work, block, d):
    """Add no rows: the interpolant is the Hermite cubic; 0 evaluations."""
    return 0


@njit(**INTERNAL)
def interpolant(kernels, solve, d):
    """`interpolate` as a kernel: RUNNING, or RAISED."""
    interpolate(kernels, solve, d)
    return RAISED if solve.block[RAISED_WORD] != 0 else RUNNING


@njit(**INTERNAL)
def interpolate(kernels, solve, d):
    """Write the polynomial of the last step to the rows of d."""
    s = solve.state[0]
    h = s.t - s.t_old
    hermite(h, kernels.fsal_stage, solve.work, d)
    s.n_extra += invoke(kernels.dense_rows, (s.t_old, h, solve.work, solve.block, d))


# -- the past of a delay equation

BEYOND = 4.0 * 2.220446049250313e-16  # by which a time may pass the last step, as its roundings do


@njit(**INTERNAL)
def _found(spans, count, t, hint):
    """The polynomial whose step contains t: the hint, the next, or by bisection."""
    if hint < count and spans[hint, 0] <= t:
        if hint + 1 == count or t < spans[hint + 1, 0]:
            return hint
        if hint + 2 == count or t < spans[hint + 2, 0]:
            return hint + 1
    low = 0
    high = count
    while high - low > 1:
        middle = (low + high) // 2
        if spans[middle, 0] <= t:
            low = middle
        else:
            high = middle
    return low


@njit(**INTERNAL)
def _of_history(words, t, order, first, out):
    """Write components of the history, or of its derivative, at time t to `out`."""
    n = words[PAST_N]
    y0 = carray(numbers_at(words[PAST_Y0]), (n,))
    if len(out) == n:
        call_function(words[PAST_HISTORY + order], t, y0, out)
        return
    room = carray(numbers_at(words[PAST_ROOM]), (n,))
    call_function(words[PAST_HISTORY + order], t, y0, room)
    for i in range(len(out)):
        out[i] = room[first + i]


@njit(**INTERNAL)
def _write(words, address, x, h, order, first, out):
    """Write components of the polynomial at an address, or of its derivative by t."""
    n = words[PAST_N]
    d = carray(numbers_at(address), (words[PAST_ROWS], n))
    if order != 0:
        slope_of_polynomial(d, x, h, first, out)
    elif len(out) == n:
        polynomial(d, x, out)
    else:
        some_of_polynomial(d, x, first, out)


@njit(**INTERNAL)
def state_before(history, place, t, now, order, first, out):
    """Write components of the state at time t, or of its derivative; NaN where t is after `now`.

    With order 2, `out` is the weight with which the past moves with the state at `now`, for a
    method whose stages are coupled with it: 1 for a delay far shorter than the step, 0 for a longer
    one.  Within the step that is being taken, the polynomial is that of `past/steps.py`; NaN if
    there is none.

    A delay equation reads the dense output of its own solve.  `history` is the array of words of
    `arguments.py`; `place` numbers the reads of the function, `order` is 0, or 1 for the
    derivative, which is that of the step that begins where two steps meet.  `out` receives the
    components from `first` on.
    """
    words = words_at(address_of(history))
    if order > 1:
        weight = 0.0
        if words[PAST_COUPLED] == COUPLED | STEPPING:
            weight = 1.0 - (now - t) / numbers_at(words[PAST_TRIAL])[1]
        for i in range(len(out)):
            out[i] = min(max(weight, 0.0), 1.0)
        return 0
    t0 = history[PAST_T0]
    if not t > t0 or words[PAST_BEGINS] != 0:
        _of_history(words, min(t, t0), order, first, out)
        return 0
    count = words_at(words[PAST_COUNT])[0]
    spans = carray(numbers_at(words[PAST_SPANS]), (count + 1, 2))
    end = t0
    if count != 0:  # an event may end a step before its polynomial
        end = min(spans[count - 1, 0] + spans[count - 1, 1], numbers_at(words[PAST_NOW])[0])
    if t > end + BEYOND * max(abs(t), abs(end)):
        later = history[PAST_SLACK] * max(abs(now), now - t0)
        if words[PAST_OPEN] == 0 or t > now + later + BEYOND * max(abs(t), abs(now)):
            for i in range(len(out)):
                out[i] = float("nan")
            return 0
        words[PAST_ASKED] = 1
        trial = numbers_at(words[PAST_TRIAL])
        x = (min(t, now) - trial[0]) / trial[1]
        _write(words, words[PAST_TRIAL] + 16, x, trial[1], order, first, out)
        return 0
    if count == 0:
        _of_history(words, t0, order, first, out)
        return 0
    at = _found(spans, count, t, words[PAST_HINT + place])
    if at == 0 and t < spans[0, 0] - BEYOND * max(abs(t), abs(t0)):  # no longer kept
        for i in range(len(out)):
            out[i] = float("nan")
        return 0
    words[PAST_HINT + place] = at
    size = spans[at, 1]
    place_of = words[PAST_D] + 8 * at * words[PAST_ROWS] * words[PAST_N]
    _write(words, place_of, (t - spans[at, 0]) / size, size, order, first, out)
    return 0
