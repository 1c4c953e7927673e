"""The proof of a step: function and series must have equal slopes at the end of the step.

The next step computes the slope at this point anyway, as the coefficient of order 1.  If the slopes
differ, the step before is taken back.  After the last step of a call, the function is called for
its slope.  A series describes the function near one point.  A saturated tanh or a pulse looks
constant at this point: for such functions, slopes are also compared inside the step (see
`fastdyn/compile/taylor/recurrences/deceptive.py`).
"""

from ...calls.block import RAISED_WORD
from ...jit.options import INLINED, INTERNAL, njit
from ...state.rows import keep_vector, vector_at
from .description import (
    ARRAYS,
    BEFORE,
    FLAGS,
    GIVEN,
    INSIDE,
    INSIDE_PREDICTED,
    LOW_BEFORE,
    LOW_NOW,
    MAY_RAISE,
    N_VECTORS,
    NOW,
    PREDICTED,
    STRIDE,
    TABLES,
    WEIGHTS,
    WIDTH,
)
from .lanes_to_number import largest, total
from .lengths import larger
from .room import array, asked

DOUBT = 40.0  # largest error of the slope times the step, in units of order times tolerance
WITHIN = 0.4375  # place of the inner evaluation, as a share of the step
SHORTER = 0.25  # factor of the length after a step without proof


@njit(**INLINED)
def differ(form, room, words, given, factor, predicted, share):
    """Whether slopes differ from predicted slopes; `share` is 0 if no slopes are compared.

    The slopes are those of the series times `factor`, or GIVEN if `given`.  `share` scales their
    distance, in units of the tolerance, to 1 at the limit.
    """
    if not share > 0.0:
        return False
    n = words[N_VECTORS]
    width = words[WIDTH]
    worst = vector_at(form, room, words[ARRAYS]) * 0.0
    added = worst
    for u in range(n):
        at = words[ARRAYS] + u * width
        if given:
            slope = vector_at(form, room, at + GIVEN * n * width)
        else:
            slope = vector_at(form, room, words[TABLES + u] + words[STRIDE]) * factor
        off = abs(slope - vector_at(form, room, at + predicted * n * width))
        off = off * vector_at(form, room, at + WEIGHTS * n * width)
        worst = larger(off, worst)
        added = added + off
    finite = total(added)  # NaN if a slope is
    return not largest(worst) * share + (finite - finite) < 1.0


def proofs(form, ends):
    """(advance, inside, behind): functions that take a step, and compare slopes in it and behind.

    ``ends`` is from `polynomials.sums`.
    """

    @njit(**INLINED)
    def advance(room, words, x, inverse):
        """Store the state at x, its rounding error and its slope; keep the state before."""
        at = words[ARRAYS]
        n = words[N_VECTORS] * words[WIDTH]
        for u in range(words[N_VECTORS]):
            place = words[TABLES + u]
            i = at + u * words[WIDTH]
            low = vector_at(form, room, i + LOW_NOW * n)
            value, rest, slope = ends(room, place, words[STRIDE], x, low)
            keep_vector(form, room, i + BEFORE * n, vector_at(form, room, place))
            keep_vector(form, room, i + LOW_BEFORE * n, low)
            keep_vector(form, room, place, value)
            keep_vector(form, room, i + LOW_NOW * n, rest)
            keep_vector(form, room, i + PREDICTED * n, slope * inverse)

    @njit(**INTERNAL)
    def look(room, words, x, inverse):
        """Store the state and the slope inside a step of length x."""
        for u in range(words[N_VECTORS]):
            place = words[TABLES + u]
            i = u * words[WIDTH]
            low = vector_at(form, room, place) * 0.0
            y, _, slope = ends(room, place, words[STRIDE], x * WITHIN, low)
            keep_vector(form, room, array(words, INSIDE) + i, y)
            keep_vector(form, room, array(words, INSIDE_PREDICTED) + i, slope * inverse)

    @njit(**INTERNAL)
    def inside(block, room, words, work, t, x, inverse, share):
        """Whether function and series differ inside a step of length x, at the time t."""
        look(room, words, x, inverse)
        raised = asked(block, t, room, words, work, INSIDE)
        block[RAISED_WORD] = 0
        return raised or differ(form, room, words, True, 1.0, INSIDE_PREDICTED, share)

    @njit(**INTERNAL)
    def behind(block, room, words, work, t, pending):
        """(whether function and series differ at the end of a step, whether to stop there)."""
        if asked(block, t, room, words, work, NOW):
            if not words[FLAGS] & MAY_RAISE:
                return False, True
            block[RAISED_WORD] = 0
            return True, False
        return differ(form, room, words, True, 1.0, PREDICTED, pending), False

    return advance, inside, behind
