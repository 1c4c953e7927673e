"""The loop over Taylor steps of one trajectory, around the series of a function.

LLVM, because Numba calls no C function at an address.
"""

import math

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from ...jit.options import INLINED, INTERNAL, njit
from ...state.elementwise import ROW, data_of
from ...state.layout import Form
from ...state.record import ATOL, FINISHED, RAISED, RTOL, RUNNING, STEP_TOO_SMALL
from ...state.series import SCALE
from .accuracy import DITHER, GOLDEN, ROUND_OFF
from .description import (
    BEFORE,
    CHOSEN,
    DECEPTIVE,
    FINE,
    FLAGS,
    JUMPS,
    LOW_BEFORE,
    LOW_NOW,
    MAY_RAISE,
    N_WATCHED,
    NOW,
    PREDICTED,
    ROOTED,
    WATCHED,
    WIDTH,
)
from .kinks import kinks
from .lengths import (
    allowed,
    landed,
    lengths,
    logarithm,
    longest,
    retry,
    smaller,
    squarable,
    unit_of,
)
from .polynomials import sums
from .proof import DOUBT, SHORTER, WITHIN, differ, proofs
from .room import asked, copy, enter, leave
from .tangent import FINER, follow, short, tangent

AT_REST = 2.0**-40  # steps shorter than this share of the time count as steps at a jump


@intrinsic
def call(typingctx, code, t, scale, room):
    """Call the code of a series: see `description.py`."""

    def codegen(context, builder, signature, args):
        number = ir.DoubleType()
        kind = ir.FunctionType(ir.IntType(64), [number, number, number.as_pointer()])
        code = builder.inttoptr(args[0], kind.as_pointer())
        return builder.call(code, [*args[1:3], data_of(context, builder, ROW, args[3])])

    return types.int64(types.int64, types.float64, types.float64, room), codegen


def _expansion(decided):
    @njit(**INLINED)
    def expand(series, t, scale, room, words, work, block):
        """Compute the series at the state; whether the function raises there."""
        if words[FLAGS] & JUMPS:
            for i in range(words[N_WATCHED] * words[WIDTH]):
                room[words[WATCHED] + CHOSEN + i] = 0.0
        while True:
            # The function is called if the series decides by rounded differences that it raises.
            if call(series, t, scale, room) and asked(block, t, room, words, work, NOW):
                return True
            if not words[FLAGS] & JUMPS or decided(room, words):
                return False

    return expand


def _choice(limited):
    @njit(**INLINED)
    def choose(s, t, x, size, scale, most, room, words):
        """(time behind the step, length, allowed length, whether the step ends at a change)."""
        h = allowed(x, size, scale, most)
        cut = False
        if words[N_WATCHED] > 0:
            x, cut = limited(room, words, h * (1.0 / scale) * s.direction, t, scale)
            h = abs(x) * scale
        later, signed, _ = landed(t, h, s.t_end, s.direction)
        return later, signed, h, cut

    return choose


@njit(**INLINED)
def _dithered(x, n_steps):
    """The length x, varied from step to step, with an exact square: see `accuracy.py`."""
    turns = n_steps * GOLDEN
    return squarable(x - DITHER * (turns - math.floor(turns)) * x)


@njit(**INTERNAL)
def _take_back(room, words):
    copy(room, words, BEFORE, NOW)
    copy(room, words, LOW_BEFORE, LOW_NOW)


@njit(**INTERNAL)
def _enter(room, words, work):
    """Read the rows of `work`; returns the logarithm of the tolerance."""
    enter(room, words, work)
    return logarithm(work[RTOL, 0] + work[ATOL, 0])


@njit(**INTERNAL)
def _leave(status, scale, t, block, room, words, work, order):
    """Store the rows of `work`; returns the status."""
    if status == STEP_TOO_SMALL and asked(block, t, room, words, work, NOW):
        status = RAISED
    work[SCALE, 0] = scale
    leave(room, words, work, order, status == FINISHED or status == RUNNING)
    return status


@njit(**INLINED)
def _count(s, t, t_old, h, taken, refused):
    s.t = t
    s.t_old = t_old
    s.h = h
    s.n_accepted += taken
    s.n_rejected += refused


def kernel(order, width):
    """``loop(state, work, block, n_steps, series, room, words)`` for series of an order.

    The first arguments and the result are as in `adaptive.kernel`; `series` is the address of the
    code of the series, whose vectors have `width` lanes, and `room` and `words` are as in
    `description.py`.
    """
    form = Form(1, width)
    length, (decided, limited) = lengths(form, order), kinks(form, width, order)
    expand, choose = _expansion(decided), _choice(limited)
    advance, inside, behind = proofs(form, sums(form, order))

    @njit(**INTERNAL)
    def loop(state, work, block, n_steps, series, room, words):
        s, flags, t_end = state[0], words[FLAGS], state[0].t_end
        t, t_old, h = s.t, s.t_old, s.h
        if s.direction * (t - t_end) >= 0.0:
            return FINISHED
        tolerance = _enter(room, words, work)
        cap, pending, scale, taken, refused, status = math.inf, 0.0, 1.0, 0, 0, STEP_TOO_SMALL
        while True:
            scale, finer = unit_of(h), 1.0
            inverse = 1.0 / scale
            if expand(series, t, scale, room, words, work, block):
                break
            doubtful = differ(form, room, words, False, inverse, PREDICTED, pending)
            if not doubtful:
                pending = 0.0
                x, size = length(room, words, tolerance)
                if flags & FINE and work[RTOL, 0] <= ROUND_OFF:
                    x = _dithered(x, s.n_accepted + taken)
                again, shorter, too_short = retry(t, x, size, scale)
                if again and not too_short:
                    h = shorter
                    continue
                most = smaller(cap, longest(t, s.t_start, s.h_first, s.h_max))
                later, signed, h, cut = choose(s, t, x, size, scale, most, room, words)
                reached = 0.0 if again or later == t else h
                if flags & ROOTED and (reached == 0.0 or h < short(s, t)):
                    end, along = tangent(form, s, t, most, reached, block, room, words, work)
                    if along != 0.0:
                        later, signed, cut, reached = end, along, False, abs(along)
                        h, scale, finer = reached, unit_of(reached), FINER * DOUBT * order
                        inverse = 1.0 / scale
                        follow(form, room, words, scale, order)
                if not reached > 0.0:
                    break
                x, t_old, t = signed * inverse, t, later
                cap, share = math.inf, h * (1.0 / (DOUBT * order)) * finer
                if flags & DECEPTIVE or finer != 1.0:
                    at = signed * WITHIN + t_old
                    doubtful = inside(block, room, words, work, at, x, inverse, share)
                advance(room, words, x, inverse)
                taken += 1
                s.n_equal += flags & JUMPS != 0 and h <= AT_REST * abs(t)
                pending = 0.0 if cut else share
                stops = t == t_end or s.direction * (t - s.t_stop) >= 0.0
                stops = stops or h < s.h_short or taken >= n_steps
                if not doubtful and (stops or flags & MAY_RAISE):
                    doubtful, raised = behind(block, room, words, work, t, pending)
                    if raised:
                        break
                if stops and not doubtful:
                    status = FINISHED if t == t_end else RUNNING
                    break
            if doubtful:
                _take_back(room, words)
                t, pending, cap, refused, taken = t_old, 0.0, h * SHORTER, refused + 1, taken - 1
        status = _leave(status, scale, t, block, room, words, work, order)
        _count(s, t, t_old, h, taken, refused)
        return status

    return loop
