"""A constant mass matrix M of M y' = f(t, y), which may be singular, as a list of its entries.

The words of M are the number of entries, the numbers of diagonals below and above the main
diagonal, the address of the block of a pencil (see `pencil.py`), the place of each entry,
column * n + row, and the numbers.  The address 0 in place of the words stands for M = I.
"""

from ..calls.block import LOWER, PLACES, UPPER, N
from ..calls.user_function import numbers_at, words_at
from ..jit.options import INTERNAL, njit
from ..state.rows import after


@njit(**INTERNAL)
def widened(mass, lower, upper):
    """The bandwidths of the sum of M and a matrix with the given bandwidths."""
    if mass == 0:
        return lower, upper
    words = words_at(mass)
    return max(lower, words[LOWER]), max(upper, words[UPPER])


@njit(**INTERNAL)
def _entries(mass):
    """The number of entries, their places, and the numbers."""
    count = words_at(mass)[N]
    return count, words_at(mass + 8 * PLACES), numbers_at(mass + 8 * (PLACES + count))


@njit(**INTERNAL)
def add_mass(mass, factor, a, ld, n):
    """Add a multiple of M to a matrix as `factorise.py` stores it."""
    if mass == 0:
        for j in range(n):
            after(a, j * ld)[j] += factor
        return
    count, places, numbers = _entries(mass)
    for e in range(count):
        j, i = divmod(places[e], n)
        after(a, j * ld)[i] += factor * numbers[e]


@njit(**INTERNAL)
def add_mass_to_pairs(mass, b, c, pairs, base, ld, n):
    """Add (b + i c) M to a complex matrix, stored as pairs of numbers from pair `base` on."""
    if mass == 0:
        for j in range(n):
            place = 2 * (base + j * ld + j)
            pairs[place] += b
            pairs[place + 1] = c
        return
    count, places, numbers = _entries(mass)
    for e in range(count):
        j, i = divmod(places[e], n)
        place = 2 * (base + j * ld + i)
        pairs[place] += b * numbers[e]
        pairs[place + 1] += c * numbers[e]


@njit(**INTERNAL)
def add_product(mass, row, out):
    """out += M row."""
    n = len(row)
    if mass == 0:
        for i in range(n):
            out[i] += row[i]
        return
    count, places, numbers = _entries(mass)
    for e in range(count):
        out[places[e] % n] += numbers[e] * row[places[e] // n]
