"""The loop over Taylor steps of one trajectory, around the series of a function.

The proof of a step: function and series must have equal slopes at the end of the step.  The next
step computes the slope at this point anyway, as the coefficient of order 1.  If the slopes differ,
the step before is taken back.  After the last step of a call, the function is called for its slope.
A series describes the function near one point.  A saturated tanh or a pulse looks constant at this
point: for such functions, slopes are also compared inside the step (see
`fastdyn/compile/taylor/recurrences/deceptive.py`).

Close to a zero of a root's argument (an emptied tank) the series reaches no farther than the zero,
and at the zero there is no series.  If the step of the series is shorter than SHARE of the time
behind or ahead, the step goes along the tangent instead, as far as the slope stays constant within
the tolerance.

LLVM, because Numba calls no C function with numbers at an address, and joins no lanes of a vector.
"""

import math

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ...calls.block import RAISED_WORD
from ...calls.user_function import address_of, call_function
from ...jit_options import INLINED, INTERNAL, njit
from ...state.elementwise import ROW, data_of
from ...state.layout import Form
from ...state.record import (
    ATOL,
    FINISHED,
    RAISED,
    RTOL,
    RUNNING,
    STAGE,
    STEP_TOO_SMALL,
    Y_OLD,
    K,
    Y,
)
from ...state.rows import keep_vector, slot, vector_at
from ...state.series import HIGHEST, LOW, SCALE
from .accuracy import ALLOWANCE, DITHER, GOLDEN, ROUND_OFF, SMALLEST
from .description import (
    ABSOLUTE,
    ARRAYS,
    BEFORE,
    CHOSEN,
    DECEPTIVE,
    FINE,
    FLAGS,
    GIVEN,
    INSIDE,
    INSIDE_PREDICTED,
    JUMPS,
    LOW_BEFORE,
    LOW_NOW,
    MAY_RAISE,
    N_VECTORS,
    N_WATCHED,
    NOW,
    PREDICTED,
    RELATIVE,
    ROOTED,
    STRIDE,
    TABLES,
    WATCHED,
    WEIGHTS,
)
from .kinks import kinks
from .lengths import (
    LAST,
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
from .polynomials import sums

IRREGULAR = 64.0  # ratio of earlier terms to those of exp, above which a series has gaps
AT_REST = 2.0**-40  # steps shorter than this share of the time count as steps at a jump
DOUBT = 40.0  # largest error of the slope times the step, in units of order times tolerance
WITHIN = 0.4375  # place of the inner evaluation, as a share of the step
SHORTER = 0.25  # factor of the length after a step without proof
SHARE = 2.0**-30  # least step of the series, as a share of the time behind or ahead
MOST = 2.0**-10  # longest tangent step, which detects no kinks, as a share of this time
GAIN = 4.0  # least ratio of the tangent step to the step of the series
FINER = 4.0  # ratio of the tolerance to the allowed error of the slope, for a tangent step


@intrinsic
def call(typingctx, series, t, scale, room):
    """Call the code of a series: see `description.py`."""

    def codegen(context, builder, signature, args):
        kind = ir.FunctionType(
            ir.IntType(64), [ir.DoubleType(), ir.DoubleType(), ir.DoubleType().as_pointer()]
        )
        code = builder.inttoptr(args[0], kind.as_pointer())
        return builder.call(code, [*args[1:3], data_of(context, builder, ROW, args[3])])

    return types.int64(types.int64, types.float64, types.float64, room), codegen


def _across(join):
    """A function that joins the lanes of a vector to one number."""

    @intrinsic
    def across(typingctx, vector):
        def codegen(context, builder, signature, args):
            lanes = [
                builder.extract_element(args[0], ir.IntType(32)(i)) for i in range(vector.width)
            ]
            while len(lanes) > 1:
                lanes = [join(builder, *pair) for pair in zip(lanes[::2], lanes[1::2], strict=True)]
            return lanes[0]

        return types.float64(vector), codegen

    return across


_largest = _across(lambda b, x, y: b.select(b.fcmp_ordered("<", x, y), y, x))
_total = _across(lambda b, x, y: b.fadd(x, y))


def kernel(order, width):
    """``loop(state, work, block, n_steps, series, room, words)`` for series of an order.

    The first arguments and the result are as in `adaptive.kernel`; `series` is the address of the
    code of the series, whose vectors have `width` lanes, and `room` and `words` are as in
    `description.py`.
    """
    form, least = Form(1, width), order - LAST + 1
    ends, bound, (decided, limited) = sums(form, order), bounds(order), kinks(form, width, order)
    ratio = math.e * SMALLEST[order] ** (-1.0 / least)
    regular = ratio**-least / ALLOWANCE[order] / IRREGULAR

    @njit(**INLINED)
    def row(words, name):
        """The place of an array."""
        return words[ARRAYS] + name * words[N_VECTORS] * width

    @njit(**INTERNAL)
    def read(work, index, room, words, name):
        """Copy a row of `work` into an array."""
        for lane in range(words[N_VECTORS] * width):
            i = words[TABLES + words[N_VECTORS] + lane]
            room[row(words, name) + lane] = work[index, i] if i >= 0 else 0.0

    @njit(**INTERNAL)
    def write(room, words, name, work, index):
        """Copy an array into a row of `work`."""
        for lane in range(words[N_VECTORS] * width):
            i = words[TABLES + words[N_VECTORS] + lane]
            if i >= 0:
                work[index, i] = room[row(words, name) + lane]

    @njit(**INTERNAL)
    def write_series(room, words, work):
        for lane in range(words[N_VECTORS] * width):
            i, place = words[TABLES + words[N_VECTORS] + lane], words[TABLES + lane // width]
            if i >= 0:
                work[Y_OLD, i] = room[place + lane % width]
                for k in range(HIGHEST + 1):
                    at = place + k * words[STRIDE] + lane % width
                    work[K + k, i] = room[at] if k <= order else 0.0

    @njit(**INTERNAL)
    def asked(block, t, room, words, work, name):
        """Call the function at a state; whether it raises.  The derivative goes to GIVEN."""
        write(room, words, name, work, Y)
        call_function(address_of(block), t, slot(None, work, Y), slot(None, work, STAGE))
        read(work, STAGE, room, words, GIVEN)
        return block[RAISED_WORD] != 0

    @njit(**INTERNAL)
    def copy(room, words, source, target):
        for i in range(words[N_VECTORS] * width):
            room[row(words, target) + i] = room[row(words, source) + i]

    @njit(**INLINED)
    def excess(room, words, given, factor, predicted, share):
        """The distance of slopes from predicted slopes, in units of the allowed distance.

        The slopes are those of the series times `factor`, or GIVEN if `given`.
        """
        at, n = words[ARRAYS], words[N_VECTORS] * width
        worst = vector_at(form, room, at) * 0.0
        total = worst
        for u in range(words[N_VECTORS]):
            i = at + u * width
            if given:
                slope = vector_at(form, room, i + GIVEN * n)
            else:
                slope = vector_at(form, room, words[TABLES + u] + words[STRIDE]) * factor
            off = abs(slope - vector_at(form, room, i + predicted * n))
            off = off * vector_at(form, room, i + WEIGHTS * n)
            worst, total = larger(off, worst), total + off
        total = _total(total)
        return _largest(worst) * share + (total - total)  # NaN if a slope is

    @njit(**INTERNAL)
    def off(room, words, predicted, share):
        """Whether the slopes GIVEN differ from predicted slopes; `share` is 0 if none are."""
        return share > 0.0 and not excess(room, words, True, 1.0, predicted, share) < 1.0

    @njit(**INTERNAL)
    def with_gaps(room, words, tolerance):
        """The length from the last TERMS terms, and the sum of all these terms."""
        found, size, at = math.inf, 0.0, row(words, WEIGHTS)
        for k in range(order, order - TERMS, -1):
            norm = vector_at(form, room, at) * 0.0
            total = norm
            for u in range(words[N_VECTORS]):
                c = abs(vector_at(form, room, words[TABLES + u] + k * words[STRIDE]))
                c = c * vector_at(form, room, at + u * width)
                norm, total = larger(c, norm), total + c
            size += _total(total)
            found = smaller(bound(k, _largest(norm), tolerance), found)
        return exponential(found), size

    @njit(**INLINED)
    def weigh(room, words, u, y, slope):
        """Store the `weight` of a vector of components."""
        i = u * width
        rtol = vector_at(form, room, row(words, RELATIVE) + i)
        atol = vector_at(form, room, row(words, ABSOLUTE) + i)
        found = weight(y, slope, rtol, atol)
        keep_vector(form, room, row(words, WEIGHTS) + i, found)
        return found

    @njit(**INLINED)
    def length(room, words, tolerance):
        """The length of a step in the unit of the series, and the sum of all examined terms.

        The sum is finite if the series is.  Stores the weights.
        """
        at, n, stride = words[ARRAYS], words[N_VECTORS] * width, words[STRIDE]
        last = vector_at(form, room, at) * 0.0
        before, total = last, last
        for u in range(words[N_VECTORS]):
            place = words[TABLES + u]
            y, slope = vector_at(form, room, place), vector_at(form, room, place + stride)
            w = weigh(room, words, u, y, slope)
            a = abs(vector_at(form, room, place + order * stride)) * w
            b = abs(vector_at(form, room, place + (order - 1) * stride)) * w
            last, before, total = larger(a, last), larger(b, before), total + (a + b)
        size = _total(total)
        x = smaller(
            bound(order - 1, _largest(before), tolerance), bound(order, _largest(last), tolerance)
        )
        x = exponential(x)
        # The terms before the last terms, at x, in units of the largest terms of a regular series.
        # A regular series has geometric terms, with the last terms at the bound of the length for
        # the smallest tolerance of the order.
        at_ratio, total = x * ratio, last * 0.0
        for u in range(words[N_VECTORS]):
            place = words[TABLES + u]
            terms = abs(vector_at(form, room, place + (order - LAST) * stride))
            for k in range(order - LAST - 1, order - TERMS, -1):
                terms = terms * at_ratio + abs(vector_at(form, room, place + k * stride))
            total = total + terms * vector_at(form, room, at + u * width + WEIGHTS * n)
        power = at_ratio ** (order - TERMS + 1)
        if _total(total) * (power * regular) <= 1.0 and size > 0.0:
            return x, size
        return with_gaps(room, words, tolerance)

    @njit(**INTERNAL)
    def look(room, words, x, inverse):
        """Store the state and the slope inside a step of length x."""
        for u in range(words[N_VECTORS]):
            i = u * width
            place = words[TABLES + u]
            low = vector_at(form, room, place) * 0.0
            y, _, slope = ends(room, place, words[STRIDE], x * WITHIN, low)
            keep_vector(form, room, row(words, INSIDE) + i, y)
            keep_vector(form, room, row(words, INSIDE_PREDICTED) + i, slope * inverse)

    @njit(**INTERNAL)
    def span(s, t):
        """The time behind, or the time ahead if that is longer and finite."""
        behind, ahead = abs(t - s.t_start), abs(t - s.t_end)
        behind = behind if behind < math.inf else 0.0
        return ahead if behind < ahead < math.inf else behind

    @njit(**INTERNAL)
    def tangent(room, words, unit):
        """Store the coefficients of a step along the tangent, from the slopes GIVEN."""
        for u in range(words[N_VECTORS]):
            place, i = words[TABLES + u], u * width
            slope = vector_at(form, room, row(words, GIVEN) + i) * unit
            keep_vector(form, room, place + words[STRIDE], slope)
            for k in range(2, order + 1):
                keep_vector(form, room, place + k * words[STRIDE], slope * 0.0)
            weigh(room, words, u, vector_at(form, room, place), slope)

    @njit(**INLINED)
    def advance(room, words, x, inverse):
        """Store the state at x, its rounding error and its slope; keep the state before."""
        at, n = words[ARRAYS], words[N_VECTORS] * width
        for u in range(words[N_VECTORS]):
            place, i = words[TABLES + u], at + u * width
            low = vector_at(form, room, i + LOW_NOW * n)
            value, rest, slope = ends(room, place, words[STRIDE], x, low)
            keep_vector(form, room, i + BEFORE * n, vector_at(form, room, place))
            keep_vector(form, room, i + LOW_BEFORE * n, low)
            keep_vector(form, room, i + NOW * n, value)
            keep_vector(form, room, i + LOW_NOW * n, rest)
            keep_vector(form, room, i + PREDICTED * n, slope * inverse)

    @njit(**INTERNAL)
    def loop(state, work, block, n_steps, series, room, words):
        s, flags, watches = state[0], words[FLAGS], words[N_WATCHED] > 0
        direction, t_end, t_stop, h_short = s.direction, s.t_end, s.t_stop, s.h_short
        t, t_old, h = s.t, s.t_old, s.h
        if direction * (t - t_end) >= 0.0:
            return FINISHED
        for index, name in ((Y, NOW), (LOW, LOW_NOW), (RTOL, RELATIVE), (ATOL, ABSOLUTE)):
            read(work, index, room, words, name)
        tolerance = logarithm(work[RTOL, 0] + work[ATOL, 0])
        dithers = flags & FINE and work[RTOL, 0] <= ROUND_OFF
        cap, pending, scale, taken, refused, status = math.inf, 0.0, 1.0, 0, 0, STEP_TOO_SMALL
        while True:
            scale, doubtful = unit_of(h), False
            inverse = 1.0 / scale
            for u in range(words[N_VECTORS]):
                y = vector_at(form, room, words[ARRAYS] + u * width)
                keep_vector(form, room, words[TABLES + u], y)
            for i in range(words[N_WATCHED] * width):
                room[words[WATCHED] + CHOSEN + i] = 0.0
            # 1. The series; the function is called if the series decides by rounded differences
            # that the function raises.
            raised = call(series, t, scale, room) and asked(block, t, room, words, work, NOW)
            while watches and not raised and not decided(room, words):
                raised = call(series, t, scale, room) and asked(block, t, room, words, work, NOW)
            if raised:
                break
            if pending > 0.0:
                doubtful = not excess(room, words, False, inverse, PREDICTED, pending) < 1.0
            # 2. The length.
            if not doubtful:
                x, size = length(room, words, tolerance)
                if dithers:
                    turns = (s.n_accepted + taken) * GOLDEN
                    x -= DITHER * (turns - math.floor(turns)) * x
                again, shorter, too_short = retry(t, x, size, scale)
                if again:
                    h = shorter
                    if not too_short:
                        pending = 0.0
                        continue
                    if not flags & ROOTED:
                        break
                most = smaller(cap, longest(t, s.t_start, s.h_first, s.h_max))
                reached, cut, finer, hopeless = 0.0, False, 1.0, again
                if not again:
                    h = allowed(x, size, scale, most)
                    if watches:
                        x, cut = limited(room, words, h * inverse * direction, t, scale)
                        h = abs(x) * scale
                    later, signed, at_end = landed(t, h, t_end, direction)
                    reached = h if later != t else 0.0
                    hopeless = reached == 0.0
                    if flags & ROOTED:
                        hopeless = hopeless or h < span(s, t) * SHARE
                    elif hopeless:
                        break
                if hopeless:
                    short = smaller(most, span(s, t) * MOST)
                    ahead, along, last = landed(t, short, t_end, direction)
                    if abs(along) > reached * GAIN:
                        if asked(block, t, room, words, work, NOW):
                            break
                        later, signed, at_end, h, cut = ahead, along, last, abs(along), False
                        scale, finer = unit_of(h), FINER * DOUBT * order
                        inverse = 1.0 / scale
                        tangent(room, words, scale)
                    elif reached == 0.0:
                        break
                # 3. The step, and its proof.
                x = signed * inverse
                advance(room, words, x, inverse)
                cap, t_old, t = math.inf, t, later
                taken += 1
                if flags & JUMPS and h <= AT_REST * abs(t):
                    s.n_equal += 1
                share = h * (1.0 / (DOUBT * order)) * finer
                pending = 0.0 if cut else share
                if flags & DECEPTIVE or finer != 1.0:
                    look(room, words, x, inverse)
                    inside = signed * WITHIN + t_old
                    doubtful = asked(block, inside, room, words, work, INSIDE)
                    block[RAISED_WORD] = 0
                    doubtful = doubtful or off(room, words, INSIDE_PREDICTED, share)
                stops = at_end or direction * (t - t_stop) >= 0.0 or h < h_short
                stops = stops or taken >= n_steps
                if not doubtful and (stops or flags & MAY_RAISE):
                    raised = asked(block, t, room, words, work, NOW)
                    if raised and not flags & MAY_RAISE:
                        break
                    doubtful = raised or off(room, words, PREDICTED, pending)
                    if raised:
                        block[RAISED_WORD] = 0
                if stops and not doubtful:
                    status = FINISHED if at_end else RUNNING
                    break
            if doubtful:  # take the step back
                copy(room, words, BEFORE, NOW)
                copy(room, words, LOW_BEFORE, LOW_NOW)
                t, pending, cap = t_old, 0.0, h * SHORTER
                refused += 1
                taken -= 1
        write(room, words, NOW, work, Y)
        write(room, words, LOW_NOW, work, LOW)
        if status == STEP_TOO_SMALL:
            if asked(block, t, room, words, work, NOW):
                status = RAISED
            write(room, words, NOW, work, Y_OLD)
        else:
            write_series(room, words, work)
        work[SCALE, 0] = scale
        s.t, s.t_old, s.h = t, t_old, h
        s.n_accepted += taken
        s.n_rejected += refused
        return status

    return loop
