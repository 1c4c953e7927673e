"""Two functions of the user, q' = velocity(t, p) and p' = force(t, q), for a state [q, p].

The words VELOCITY and FORCE of the block of a pair are the addresses of the two functions' blocks.
"""

from numba import carray

from ..jit.options import INLINED, INTERNAL, njit
from ..state.elementwise import halves, join
from .block import FORCE, RAISED_WORD, VELOCITY, WORDS_OF_PAIR
from .user_function import call_function, inlined, raised


@njit(**INLINED)
def _noted(block, part):
    """Mark a pair as raised if one of its functions raised."""
    if raised(block[part]):
        block[RAISED_WORD] = 1


def _part_by_pointer(part):
    """A function of a pair, called by address: ``(t, x, block, out)`` fills the row `out`."""

    @njit(**INTERNAL)
    def one(t, x, block, out):
        call_function(block[part], t, x, out)
        _noted(block, part)
        return out

    return one


velocity_by_pointer, force_by_pointer = map(_part_by_pointer, (VELOCITY, FORCE))


@njit(**INTERNAL)
def both_by_pointer(t, y, n, block, out):
    """The derivative of [q, p], in the common form of the user's functions."""
    m = n // 2
    words = carray(block, WORDS_OF_PAIR)
    state = carray(y, n)
    slope = carray(out, n)
    velocity_by_pointer(t, state[m:], words, slope[:m])
    force_by_pointer(t, state[:m], words, slope[m:])


def part_inlined(function, part):
    """A function of a pair, inlined: ``(t, x, block, place)`` gives a tuple."""

    @njit(**INTERNAL)
    def one(t, x, block, place):
        value = inlined(function, t, x, block[part])
        _noted(block, part)
        return value

    return one


def both_inlined(velocity, force):
    """The derivative of [q, p] from two functions of `part_inlined`."""

    @njit(**INTERNAL)
    def both(t, y, block, place):
        q, p = halves(y)
        return join(place, velocity(t, p, block, place), force(t, q, block, place))

    return both
