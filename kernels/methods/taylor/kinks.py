"""Steps that end where a condition changes, so that each step has one series.

A condition compares two numbers.  Where their difference changes sign, the function may have a kink
or a jump.  The differences have Taylor series, too, and are watched; if a difference is zero at the
start of a step, the sign of its first coefficient that is not zero decides which side the step
takes.  The arguments of roots must not touch zero, and some numbers must not move too far: see
`fastdyn/compile/taylor/recurrences/deceptive.py`.
"""

from ...jit.options import INTERNAL, njit
from ...state.rows import keep_vector, vector_at
from ...vector.scalar_or_vector import any_lane, select
from .accuracy import SMALLEST
from .changes import BEYOND, REMAINDER, TAIL, VANISHING, first_change, first_sign, not_far
from .description import (
    FREE,
    HOLDS,
    MARKS,
    N_VECTORS,
    N_WATCHED,
    SHARES,
    SIGNED,
    STRIDE_OF_WATCHED,
    TABLES,
    TOUCHES,
    TOUCHING,
    WATCHED,
    WIDTHS,
)
from .lengths import larger
from .polynomials import motions

CLEAR = 1.0 - 2.0**-20  # share of the distance from zero that a difference may move


def kinks(form, width, order):
    """(decided, limited): functions that a step calls before and after its length is chosen.

    `order` is the order of the series of the states, one more than that of the watched numbers.
    """
    last = order - 1
    remainder = REMAINDER * SMALLEST[order]
    motion_of = motions(form, last)

    @njit(**INTERNAL)
    def decided(room, words):
        """Whether all sides were right; if not, the series must be computed again."""
        n = words[N_WATCHED]
        sides = words[WATCHED]
        right = True
        places = TABLES + words[N_VECTORS] * (width + 1)
        for i in range(n * width):
            place = words[places + i // width] + i % width
            if words[places + n + i] & SIGNED and room[sides + i] == 0.0 and room[place] == 0.0:
                room[sides + i] = first_sign(room, place, words[STRIDE_OF_WATCHED], last)
                right = right and room[sides + i] == 0.0
        return right

    @njit(**INTERNAL)
    def limited(room, words, x, t, scale):
        """The length x, or a shorter length that ends a little behind the first change.

        A number that must not move too far may shorten x, too.  A number that moves by less than
        its distance from a change is not searched.  Also returns whether x ends at a change.
        """
        n, stride, found, cut = words[N_WATCHED], words[STRIDE_OF_WATCHED], x, False
        places, row, size = TABLES + words[N_VECTORS] * (width + 1), n * width, abs(x)
        least = abs(t) / scale * (2.0 * BEYOND) + size * (BEYOND * BEYOND)
        power = size ** (last - 1)
        for u in range(n):
            place = words[places + u]
            at = words[WATCHED] + u * width
            first, motion = abs(vector_at(form, room, place)), motion_of(room, place, stride, size)
            before_last = abs(vector_at(form, room, place + (last - 1) * stride))
            tail = abs(vector_at(form, room, place + last * stride)) * size + before_last
            # also clear of the value that counts as zero
            touching = vector_at(form, room, at + TOUCHING * row)
            moved = motion + touching * (tail * (power * (2.0 * VANISHING * TAIL)))
            near = larger(
                vector_at(form, room, at + WIDTHS * row),
                vector_at(form, room, at + SHARES * row) * first,
            )
            clear = first * CLEAR + vector_at(form, room, at + FREE * row)
            calm = (motion <= near) & (moved < clear)
            if not any_lane(~calm):
                continue
            keep_vector(form, room, at + MARKS * row, select(calm, first * 0.0, 1.0))
            for i in range(width):
                if room[at + MARKS * row + i] == 0.0:
                    continue
                kind, here, before = words[places + n + u * width + i], place + i, found
                if kind & SIGNED:
                    found = first_change(room, here, stride, last, found, least, 0.0, remainder)
                if kind & TOUCHES:
                    found = first_change(
                        room, here, stride, last, found, least, VANISHING, remainder
                    )
                cut = cut or found != before
                if kind & HOLDS:
                    wide, share = room[at + WIDTHS * row + i], room[at + SHARES * row + i]
                    found = not_far(room, here, stride, last, found, wide, share)
        return found, cut

    return decided, limited
