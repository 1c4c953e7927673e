"""Symplectic correctors for the splitting of Wisdom and Holman.

A step of the splitting A + B follows, to first order in B, the Hamiltonian A + f(a) B, where a is
the step times the Lie derivative of A: f = (a/2) / sinh(a/2) if the step drifts, kicks and drifts,
and f = (a/2) coth(a/2) if it kicks, drifts and kicks.  The corrector exp(w(a) B) with
a w(a) = f(a) - 1 before the first step, and its inverse at an output, take the difference away.  It
is made of drifts by +-a_i steps and kicks of size +-b_i, and then, in the opposite order, of the
same with -a_i and -b_i, whose sum is w = 4 (b_1 sinh(a_1 a) + b_2 sinh(a_2 a) + ...) to the order
of the corrector.

J. Wisdom, M. Holman and J. Touma, "Symplectic correctors", Fields Inst. Commun. 10 (1996);
J. Wisdom, "Symplectic correctors for canonical heliocentric n-body maps", Astron. J. 131 (2006),
table 1, with a_i = i sqrt(7/40) for the orders 3, 5, 7, 11 and 17.
"""

import math
from fractions import Fraction

PAIRS = {0: 0, 3: 1, 5: 2, 7: 3, 11: 5, 17: 8}  # order: number of (a_i, b_i)
ALPHA_SQUARED = Fraction(7, 40)


def bernoulli(n):
    """The Bernoulli numbers B_0, ..., B_n."""
    found = [Fraction(1)]
    for m in range(1, n + 1):
        total = sum((math.comb(m + 1, k) * found[k] for k in range(m)), Fraction(0))
        found.append(-total / (m + 1))
    return found


def wanted(n, kicks_first):
    """The coefficients of a, a^3, ..., a^(2 n - 1) in w(a)."""
    numbers = bernoulli(2 * n)
    series = []
    for k in range(1, n + 1):
        coth = numbers[2 * k] / math.factorial(2 * k)  # (a/2) coth(a/2)
        series.append(coth if kicks_first else -(1 - Fraction(1, 2 ** (2 * k - 1))) * coth)
    return series


def coefficients(order, kicks_first=True):
    """The (a_i, b_i) of the corrector of an order, to rounding; none for order 0.

    The b_i / sqrt(7/40) are rational: they solve a linear system exactly.
    """
    n = PAIRS[order]
    rows = []
    for k, c in enumerate(wanted(n, kicks_first)):
        factors = [4 * Fraction(i) ** (2 * k + 1) * ALPHA_SQUARED**k for i in range(1, n + 1)]
        rows.append([*factors, c * math.factorial(2 * k + 1)])
    for k in range(n):
        rows[k] = [value / rows[k][k] for value in rows[k]]
        for i in range(n):
            if i != k:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    alpha = math.sqrt(ALPHA_SQUARED)
    return [(i * alpha, float(row[n] / ALPHA_SQUARED) * alpha) for i, row in enumerate(rows, 1)]


def sequence(order):
    """The (a, b) of the corrector in the order in which they are used, and in the opposite one."""
    pairs = coefficients(order)
    return pairs + [(-a, -b) for a, b in reversed(pairs)]
