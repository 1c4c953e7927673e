"""Philox 4x32-10: four random words of 32 bits from a counter of four words and a key of two.

Source: Salmon, Moraes, Dror, Shaw, Parallel random numbers: as easy as 1, 2, 3, Proceedings of SC11
(2011), https://doi.org/10.1145/2063384.2063405, section 3.3 and table 2.  A number depends on its
counter and on the key alone, so that paths can be computed in any order.  A lane of 64 bits holds
one word of 32 bits, because the product of two words has 64.
"""

from ..vector.emit import Lanes

MULTIPLIERS = 0xD2511F53, 0xCD9E8D57
WEYL = 0x9E3779B9, 0xBB67AE85  # what the rounds add to the key: golden ratio, sqrt(3) - 1
ROUNDS = 10
LOW = 0xFFFFFFFF


def _product(word, multiplier):
    """The 64 bits of a product of words of 32 bits; the upper half of `word` is ignored."""
    return (word & LOW) * multiplier


def philox(counter, key):
    """Four words, whose upper halves are arbitrary, from four and from two words as Lanes."""
    first, second, third, fourth = counter
    left, right = key
    for _ in range(ROUNDS):
        one = _product(first, MULTIPLIERS[0])
        other = _product(third, MULTIPLIERS[1])
        first = (other >> 32) ^ second ^ left
        second = other
        third = (one >> 32) ^ fourth ^ right
        fourth = one
        left = left + WEYL[0]
        right = right + WEYL[1]
    return first, second, third, fourth


def doubled(high, low) -> Lanes:
    """A word of 64 bits from two words of 32 bits with arbitrary upper halves."""
    return (high << 32) | (low & LOW)
