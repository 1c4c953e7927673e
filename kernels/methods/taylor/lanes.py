"""The loop over Taylor steps with a trajectory in each lane, as in `kernels/ensemble/lanes.py`.

The function is called after each step, for the proof: see `steps.py`.
"""

from ...ensemble.lanes import field, leave
from ...jit.options import INLINED, INTERNAL, njit
from ...state.lane_fields import (
    ACCEPTED,
    LIMIT,
    LIVE,
    NOTHING,
    STATUS,
    T_END,
    T_OLD,
    T_STOP,
    TRIES,
    H,
    T,
)
from ...state.layout import Form
from ...state.record import ATOL, FINISHED, RTOL, STEP_TOO_SMALL, Y_OLD, K, Y
from ...state.rows import keep_vector, numbers_of, vector_at
from ...state.series import LOW, SCALE
from ...vector.scalar_or_vector import any_lane, select
from .description import (
    ARRAYS,
    DECEPTIVE,
    FLAGS,
    GIVEN,
    LOW_NOW,
    MAY_RAISE,
    N_OF_LANES,
    N_VECTORS,
    N_WATCHED,
    NOW,
    PREDICTED,
    RAISES,
    SHARES,
    STRIDE,
    TABLES,
    TIMES,
    UNITS,
    WATCHED,
    WEIGHTS,
    WIDTH,
    WIDTHS,
)
from .lengths import (
    LEAST,
    TERMS,
    allowed,
    bounds,
    exponential,
    landed,
    larger,
    logarithm,
    longest,
    retry,
    smaller,
    unit_of,
    weight,
)
from .polynomials import motions, sums
from .proof import DOUBT, SHORTER, WITHIN
from .steps import call

AFTER_RAISING = 0.125  # factor of a step's length if the function raises at the step's end
HALF = 0.5  # factor of a step's length if a number may move too far: see `kinks.py`


@njit(**INLINED)
def _refuse(refused, share, h, t, before):
    """(refused lanes, failed lanes, next lengths, tries) after a test of a step of length h to t.

    A refused step is tried again with `share` of its length, unless the test before refused it.
    """
    bad, failed, wanted, tries = before
    refused = refused & ~bad
    shorter = h * share
    failed = failed | (refused & (shorter <= LEAST * abs(t)))
    tries = select(refused, h * 0.0 + 1.0, tries)
    return bad | refused, failed, select(refused, shorter, wanted), tries


@njit(**INLINED)
def _array(words, name, i):
    """The place of a component in an array."""
    return words[ARRAYS] + (name * words[N_VECTORS] + i) * words[WIDTH]


@njit(**INLINED)
def _of_lanes(form, room, words, name):
    return vector_at(form, room, words[ARRAYS] + (name - N_OF_LANES) * words[WIDTH])


@njit(**INLINED)
def _store(form, room, words, name, value):
    keep_vector(form, room, words[ARRAYS] + (name - N_OF_LANES) * words[WIDTH], value)


def _length(form, order):
    bound = bounds(order)

    @njit(**INTERNAL)
    def length(rows, room, words, tolerance):
        """The length of a step in the unit of the series, and the sum of the last terms."""
        n = words[N_VECTORS]
        stride = words[STRIDE]
        width = words[WIDTH]
        for i in range(n):
            place = words[TABLES + i]
            rtol = vector_at(form, rows, (RTOL * n + i) * width)
            atol = vector_at(form, rows, (ATOL * n + i) * width)
            y = vector_at(form, room, place)
            slope = vector_at(form, room, place + stride)
            keep_vector(form, room, _array(words, WEIGHTS, i), weight(y, slope, rtol, atol))
        size = tolerance * 0.0
        found = size
        for k in range(order, order - TERMS, -1):
            norm = size * 0.0
            for i in range(n):
                c = abs(vector_at(form, room, words[TABLES + i] + k * stride))
                c = c * vector_at(form, room, _array(words, WEIGHTS, i))
                norm = larger(c, norm)
                size = size + c
            x = bound(k, norm, tolerance)
            found = smaller(x, found) if k < order else x
        return exponential(found), size

    return length


def _proof(form, ends):
    @njit(**INTERNAL)
    def advance(rows, room, words, x, inner):
        """Store the states at x, their rounding errors, and the slopes of the series."""
        n = words[N_VECTORS]
        for i in range(n):
            low = vector_at(form, rows, (LOW * n + i) * words[WIDTH])
            low = low * 0.0 if inner else low
            value, rest, slope = ends(room, words[TABLES + i], words[STRIDE], x, low)
            keep_vector(form, room, _array(words, NOW, i), value)
            keep_vector(form, room, _array(words, LOW_NOW, i), rest)
            keep_vector(form, room, _array(words, PREDICTED, i), slope)

    @njit(**INTERNAL)
    def unproved(ask, room, words, t, scale, share):
        """The lanes in which function and series differ in slope, at the time t."""
        _store(form, room, words, TIMES, t)
        call(ask, 0.0, 0.0, room)
        total = t * 0.0
        for i in range(words[N_VECTORS]):
            slope = vector_at(form, room, _array(words, GIVEN, i)) * scale
            off = abs(slope - vector_at(form, room, _array(words, PREDICTED, i)))
            total = total + off * vector_at(form, room, _array(words, WEIGHTS, i))
        return ~(total * share < 1.0)

    return advance, unproved


def _distance(form, order):
    motion = motions(form, order - 1)

    @njit(**INTERNAL)
    def too_far(room, words, x):
        """The lanes in which a number moves too far on a step of length x."""
        table = words[WATCHED]
        first = TABLES + 2 * words[N_VECTORS]
        row = words[N_WATCHED] * words[WIDTH]
        worst = x * 0.0 - 1.0
        for u in range(words[N_WATCHED]):
            place = words[first + u]
            at = table + u * words[WIDTH]
            near = vector_at(form, room, at + SHARES * row) * abs(vector_at(form, room, place))
            near = larger(near, vector_at(form, room, at + WIDTHS * row))
            worst = larger(motion(room, place, words[STRIDE], abs(x)) - near, worst)
        return ~(worst < 0.0)

    return too_far


def _acceptance(form):
    @njit(**INTERNAL)
    def accept(rows, room, words, good):
        """Take the states in the good lanes."""
        n = words[N_VECTORS]
        for i in range(n):
            at = (Y * n + i) * words[WIDTH]
            low_at = (LOW * n + i) * words[WIDTH]
            y = vector_at(form, room, _array(words, NOW, i))
            keep_vector(form, rows, at, select(good, y, vector_at(form, rows, at)))
            low = vector_at(form, room, _array(words, LOW_NOW, i))
            keep_vector(form, rows, low_at, select(good, low, vector_at(form, rows, low_at)))

    return accept


def _series(form, order):
    @njit(**INTERNAL)
    def expand(series, rows, room, words, t, scale):
        """Compute the series at the states."""
        n = words[N_VECTORS]
        for i in range(n):
            y = vector_at(form, rows, (Y * n + i) * words[WIDTH])
            keep_vector(form, room, words[TABLES + i], y)
        _store(form, room, words, TIMES, t)
        _store(form, room, words, UNITS, scale)
        call(series, 0.0, 0.0, room)

    @njit(**INTERNAL)
    def write(rows, room, words):
        """Store the coefficients in the rows of `work`."""
        n = words[N_VECTORS]
        width = words[WIDTH]
        keep_vector(form, rows, SCALE * n * width, _of_lanes(form, room, words, UNITS))
        for i in range(n):
            place = words[TABLES + i]
            keep_vector(form, rows, (Y_OLD * n + i) * width, vector_at(form, room, place))
            for k in range(order + 1):
                c = vector_at(form, room, place + k * words[STRIDE])
                keep_vector(form, rows, ((K + k) * n + i) * width, c)

    return expand, write


def kernel(order, width):
    """``loop(state, lanes, work, block, n_steps, series, ask, room, words)`` of an order.

    The first arguments and the result are as in `lanes.adaptive`, the others as in `steps.kernel`.
    """
    form = Form(1, width)
    length, (advance, unproved) = _length(form, order), _proof(form, sums(form, order))
    too_far, accept, (expand, write) = (
        _distance(form, order), _acceptance(form), _series(form, order),
    )  # fmt: skip

    @njit(**INTERNAL)
    def loop(state, lanes, work, block, n_steps, series, ask, room, words):
        s, n, flags, rows = state[0], words[N_VECTORS], words[FLAGS], numbers_of(work)
        t, t_old, h = field(form, lanes, T), field(form, lanes, T_OLD), field(form, lanes, H)
        t_end = field(form, lanes, T_END)
        t_stop = field(form, lanes, T_STOP)
        live, limit = field(form, lanes, LIVE) > 0.0, field(form, lanes, LIMIT)
        accepted, tries = field(form, lanes, ACCEPTED), field(form, lanes, TRIES)
        rtol = vector_at(form, rows, RTOL * n * width)
        tolerance = logarithm(rtol + vector_at(form, rows, ATOL * n * width))
        taken, nothing = 0, t * 0.0
        while True:
            taken += 1
            scale = unit_of(h)
            expand(series, rows, room, words, t, scale)
            x, size = length(rows, room, words, tolerance)
            most = longest(t, s.t_start, s.h_first, s.h_max)
            most = select(tries > 0.0, smaller(h, most), most)
            again, wanted, short = retry(t, x, size, scale)
            h = allowed(x, size, scale, most)
            later, signed, _ = landed(t, h, t_end, s.direction)
            stuck, x = later == t, signed / scale
            share = abs(x) * (1.0 / (DOUBT * order))
            doubtful = again & ~again
            if flags & DECEPTIVE:
                advance(rows, room, words, x * WITHIN, True)
                doubtful = unproved(ask, room, words, signed * WITHIN + t, scale, share)
            advance(rows, room, words, x, False)
            doubtful = doubtful | unproved(ask, room, words, later, scale, share)
            tested = again, again & short, wanted, nothing
            if words[N_WATCHED] > 0:
                tested = _refuse(too_far(room, words, x), HALF, h, later, tested)
            if flags & MAY_RAISE:
                raised = _of_lanes(form, room, words, RAISES) != 0.0
                tested = _refuse(raised, AFTER_RAISING, h, later, tested)
            bad, failed, wanted, tries = _refuse(doubtful, SHORTER, h, later, tested)
            failed = failed | (~bad & stuck)
            good = ~bad & ~stuck
            accept(rows, room, words, good)
            t_old, t = t, select(good, later, t)
            h = select(good, h, wanted)
            accepted = accepted + select(good, nothing + 1.0, nothing)
            stops = (s.direction * (t - t_stop) >= 0.0) | (accepted >= limit)
            hand_back = live & ((stops & good) | failed)
            if taken >= n_steps or any_lane(hand_back):
                break
        status = select(t == t_end, nothing + float(FINISHED), nothing)
        status = select(failed, nothing + float(STEP_TOO_SMALL), status)
        leave(form, lanes, STATUS, select(hand_back, status, nothing + float(NOTHING)))
        leave(form, lanes, T, t)
        leave(form, lanes, T_OLD, t_old)
        leave(form, lanes, H, h)
        leave(form, lanes, ACCEPTED, accepted)
        leave(form, lanes, TRIES, tries)
        write(rows, room, words)
        return taken

    return loop
