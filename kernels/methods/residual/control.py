"""Order and size of the steps of the BDF of residuals.

K. E. Brenan, S. L. Campbell and L. R. Petzold, "Numerical Solution of Initial-Value Problems in
Differential-Algebraic Equations", SIAM 1996, section 5.2.  The terms h^k y^(k) of the Taylor series
are estimated for orders near the present order.  The order falls if the terms do not decrease.  The
order rises only after steps of equal size.
"""

import numpy as np

from ...jit.options import INLINED, INTERNAL, njit
from .past import (
    BETA,
    CLIMBS,
    MAX_ORDER,
    PHI,
    RISE,
    SIGMA,
    USED,
    WEIGHT,
    norm,
    remember,
)

DOUBLE, SLIGHTLY, LEAST = 2.0, 0.9, 0.5  # changes of the size after an accepted step
LEAST_AGAIN = 0.25  # least change of the size after a rejected step
OFFSET = 1e-4  # keeps the size finite where the error is 0


@njit(**INTERNAL)
def order_below(rows, order, v):
    """Choose between the present order and the order below.

    Returns (chosen order, error of the chosen order, term of `order`, error of order - 1, term of
    order - 1), with the terms of the Taylor series.
    """
    error = v[SIGMA + order] * norm(rows, RISE, RISE, 0.0, PHI)
    term = (order + 1) * error
    lower_error = 0.0
    lower_term = 0.0
    falls = False
    if order > 1:
        size = norm(rows, RISE, PHI + order, v[BETA + order], PHI)
        lower_error = v[SIGMA + order - 1] * size
        lower_term = order * lower_error
        if order == 2:
            falls = lower_term <= 0.5 * term
        else:
            falls = max(lower_term, _lowest_term(rows, order, v)) <= term
    if falls:
        return order - 1, lower_error, term, lower_error, lower_term
    return order, error, term, lower_error, lower_term


@njit(**INTERNAL)
def _lowest_term(rows, order, v):
    """The term of the series two orders below."""
    total = 0.0
    above = PHI + order
    for i in range(rows.shape[1]):
        x = rows[RISE, i] + v[BETA + order] * rows[above, i]
        x = (x + v[BETA + order - 1] * rows[above - 1, i]) * rows[WEIGHT, i]
        total += x * x
    return (order - 1) * v[SIGMA + order - 2] * np.sqrt(total / rows.shape[1])


@njit(**INLINED)
def _growth(error, order):
    """The factor of the size for which the error of the next step is half the tolerance."""
    return (2.0 * error + OFFSET) ** (-1.0 / (order + 1))


@njit(**INTERNAL)
def after_failures(s, below, n_failed):
    """Choose the order after rejected steps; return the factor of the size."""
    chosen = below[0]
    error = below[1]
    s.order = chosen if n_failed <= 2 else 1
    if n_failed > 1:
        return LEAST_AGAIN
    return max(LEAST_AGAIN, min(SLIGHTLY, SLIGHTLY * _growth(error, chosen)))


@njit(**INTERNAL)
def next_order_and_size(s, rows, below, v):
    """Choose order and size of the next step, and add the last step to the past."""
    order = s.order
    before = int(rows[USED, 0])
    chosen, error, term, lower_error, lower_term = below
    if chosen < order or order == MAX_ORDER:
        rows[CLIMBS, 0] = 0.0
    s.h = s.h_old
    if rows[CLIMBS, 0] != 0.0:
        if before > 0:
            s.order += 1
            s.h *= DOUBLE
        remember(rows, order, v)
        return
    if chosen == order and order < MAX_ORDER and s.n_equal > order + 1 and order - before != 1:
        higher_error = norm(rows, RISE, RISE, 0.0, PHI + order + 1) / (order + 2)
        higher_term = (order + 2) * higher_error
        if order > 1 and lower_term <= min(term, higher_term):
            chosen = order - 1
            error = lower_error
        elif higher_term < (0.5 * term if order == 1 else term):
            chosen = order + 1
            error = higher_error
    s.order = chosen
    growth = _growth(error, chosen)
    if growth >= DOUBLE:
        s.h *= DOUBLE
    elif growth <= 1.0:
        s.h *= max(LEAST, min(SLIGHTLY, growth))
    remember(rows, order, v)
