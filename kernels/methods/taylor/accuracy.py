"""The order and the accuracy of the steps, measured on the problems of bench/problems."""

import math

import numpy as np

# Time at equal error over the time of each problem's best order, mean over the problems:
#     error    9    13    17    21    25    29    33
#     1e-4   1.5   1.2   1.1   1.2   1.2   1.4   1.5
#     1e-8   2.7   1.4   1.1   1.1   1.1   1.2   1.3
#     1e-12  5.0   2.0   1.4   1.1   1.0   1.1   1.1
ORDERS = ((1e-4, 13), (2e-9, 17), (0.0, 25))  # (tolerance, the order for larger tolerances)
SMALLEST = {13: 1e-4, 17: 2e-9, 25: 1e-15}  # smallest tolerance with this order
# The largest last terms, in units of the tolerance.  With these limits, the error at the end of a
# solve, in units of the tolerance, is below 1 for more than half, and below 10 for nine tenths of
# the problems of the DETEST set and of bench/problems, with each order: see
# tests/compile/taylor/test_tolerances.py.
ALLOWANCE = {13: 0.02, 17: 0.025, 25: 0.015}
# For an rtol up to FINE, the kernel avoids rounding errors of one sign: see `order.Order`.
FINE = 1e-14
# Near rounding, each step is shortened by another share, at most DITHER.  Without this, steps
# repeat with the period of an orbit (67 phases of Kepler's orbit at e = 0.4), and equal rounding
# errors add up.  With DITHER = 1 / 32, the steps on a circle still repeat.
# A step has 26 bits, so that its square is exact.  The times at its ends are multiples of their
# last place, and so is the step: late in a run it has few bits, m of them odd, and m * m leaves the
# remainder 1 by 8.  Its rounding then has one sign in all steps: on a circle, the energy drifted by
# 3.6e-16 an orbit from orbit 10^7 to orbit 2 10^7, and by 5.5e-9 in all.
ROUND_OFF = 1e-15
DITHER = 1.0 / 16.0
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def order_for(rtol, atol, y0):
    """The order with the least cost for these tolerances."""
    size = max(map(abs, y0.tolist())) or 1.0
    if rtol.__class__ is float is atol.__class__:
        tolerance = rtol + atol / size
    else:
        tolerance = float(np.min(np.add(rtol, np.divide(atol, size))))
    return next(order for least, order in ORDERS if not tolerance <= least or not least)


def is_fine(rtol):
    """True if a tolerance is near rounding."""
    return (rtol if rtol.__class__ is float else float(np.min(rtol))) <= FINE


def order_of_many(rtol, atol):
    """The order for an ensemble, the same for all initial states, so that all blocks agree."""
    return order_for(rtol, atol, np.ones(1))
