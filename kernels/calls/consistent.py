"""Consistent states and derivatives of M y' = f, by `algebra/consistent_states.py`.

The argument `mass` of each function is the address of the words of M, the word MASS of the block.
"""

from ..jit.options import INTERNAL, njit
from .block import CHANGE, EVALUATIONS, PENCIL, SETTLE
from .user_function import call_function, call_with, raised, words_at


@njit(**INTERNAL)
def rates_of(mass, t, y, out):
    """Write the derivative y' of M y' = f to `out`."""
    call_function(words_at(mass)[PENCIL], t, y, out)


@njit(**INTERNAL)
def made_consistent(mass, t, y):
    """Replace a state by a consistent state; False if no consistent state was found."""
    pencil = words_at(mass)[PENCIL]
    call_with(words_at(pencil)[SETTLE], pencil, t, y, y)
    return not raised(pencil)


@njit(**INTERNAL)
def is_consistent(mass, t, y, scratch):
    """Whether a start fulfils the algebraic equations to within the tolerance."""
    pencil = words_at(mass)[PENCIL]
    call_with(words_at(pencil)[CHANGE], pencil, t, y, scratch)
    return not raised(pencil)


@njit(**INTERNAL)
def evaluations_since(mass):
    """The evaluations of the equations since the last call."""
    words = words_at(words_at(mass)[PENCIL])
    found = words[EVALUATIONS]
    words[EVALUATIONS] = 0
    return found
