"""The formulas of LSODA: Adams-Moulton of orders 1 to 12, BDF of orders 1 to 5, as polynomials.

K. Radhakrishnan and A. C. Hindmarsh, "Description and use of LSODE", NASA RP-1327 (1993), chapters
2 and 3: corrections of the Nordsieck array from products of polynomials, and tests of the error.
L. Petzold, "Automatic selection of methods for solving stiff and nonstiff systems of ordinary
differential equations", SIAM J. Sci. Stat. Comput. 4 (1983): the bounds of h L.
"""

import math
from fractions import Fraction

import numpy as np

ADAMS = 0
BDF = 1
HIGHEST = 12, 5  # orders of the two families


def product(order):
    """Coefficients of (x + 1) (x + 2) ... (x + order), constant first."""
    found = [1]
    for root in range(1, order + 1):
        found = [root * a + b for a, b in zip([*found, 0], [0, *found], strict=True)]
    return found


def correction(family, order):
    """The changes of the terms of the Nordsieck array if h y' changes by 1.

    For BDF the changes are the coefficients of the polynomial that is zero at -1 to -order; for
    Adams' formulas, of the integral from -1 of the polynomial that is zero at -1 to 1 - order.
    Both have a slope of 1 at zero.
    """
    if family == BDF:
        found = product(order)
        return [Fraction(a, found[1]) for a in found]
    slope = [Fraction(a, math.factorial(order - 1)) for a in product(order - 1)]
    rising = [a / (j + 1) for j, a in enumerate(slope)]
    return [sum(a * (-1) ** j for j, a in enumerate(rising)), *rising]


def constant(family, order):
    """The factor of h^(order + 1) y^(order + 1) in the error; for BDF with the factor 1 of h y'."""
    if family == BDF:
        return Fraction(1, order + 1)
    moment = sum(a * Fraction((-1) ** j, j + 2) for j, a in enumerate(product(order - 1)))
    return moment / math.factorial(order)


def _by_order(number):
    """The array [family, order] of the numbers ``number(family, order)``."""
    table = np.zeros((2, HIGHEST[ADAMS] + 1))
    for family, highest in enumerate(HIGHEST):
        for order in range(1, highest + 1):
            table[family, order] = number(family, order)
    return table


def _per_correction(family, order, errors_of):
    """1 / the error of order `errors_of` of a step whose correction, or change, is 1.

    The correction times its last coefficient is the change of h^order y^(order) / order!.
    """
    last = correction(family, order)[-1] * math.factorial(order)
    return 1 / (constant(family, errors_of) * last)


CORRECTION = np.zeros((2, HIGHEST[ADAMS] + 1, HIGHEST[ADAMS] + 1))
for _family, _highest in enumerate(HIGHEST):
    for _order in range(1, _highest + 1):
        CORRECTION[_family, _order, : _order + 1] = correction(_family, _order)
CONSTANT = _by_order(constant)
# Divisors that turn the norm of a row into the norm of an error.  SAME: from a correction to the
# error of its order.  HIGHER: from the change between two corrections to the error one order above.
# LOWER: from the last term of the Nordsieck array to the error one order below.
SAME = _by_order(lambda family, order: _per_correction(family, order, order))
HIGHER = _by_order(lambda family, order: _per_correction(family, order, order + 1))
LOWER = _by_order(
    lambda family, order: (
        1 / (constant(family, order - 1) * math.factorial(order)) if order > 1 else 0
    )
)
ORDERS = np.array(HIGHEST)
# The longest stable h L of Adams' formulas as LSODA iterates them, by order.
STABLE = np.array([0, 0.5, 0.575, 0.55, 0.45, 0.35, 0.25, 0.2, 0.15, 0.1, 0.075, 0.05, 0.025])
