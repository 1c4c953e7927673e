"""The order and the accuracy of the steps, measured on the problems of bench/problems."""

import math

import numpy as np

# Time at equal error over the time of each problem's best order, mean over the problems:
#     error    9    13    17    21    25    29    33
#     1e-4   1.5   1.2   1.1   1.2   1.2   1.4   1.5
#     1e-8   2.7   1.4   1.1   1.1   1.1   1.2   1.3
#     1e-12  5.0   2.0   1.4   1.1   1.0   1.1   1.1
ORDERS = ((1e-5, 13), (1e-8, 17), (0.0, 25))  # (tolerance, order for tolerances above)
# The largest last terms, in units of the tolerance, with which the errors equal DOP853's errors at
# equal tolerances, in the geometric mean.
ALLOWANCE = {13: 2.0, 17: 6.0, 25: 6.0}
# Near rounding, the truncation error, which has one sign in all steps, is kept below rounding.
ROUND_OFF, BELOW = 1e-15, 1.0 / 64.0
# Near rounding, each step is shortened by another share, at most DITHER.  Otherwise the steps
# lock in with a periodic orbit (67 phases of Kepler's orbit at e = 0.4), and equal rounding errors
# return with each period and add up.
DITHER, GOLDEN = 1.0 / 32.0, (math.sqrt(5.0) - 1.0) / 2.0


def order_for(rtol, atol, y0):
    """The order with the least cost for these tolerances."""
    size = max(map(abs, y0.tolist())) or 1.0
    if rtol.__class__ is float is atol.__class__:
        tolerance = rtol + atol / size
    else:
        tolerance = float(np.min(np.add(rtol, np.divide(atol, size))))
    return next(order for least, order in ORDERS if not tolerance <= least or not least)


def order_of_many(rtol, atol):
    """The order for an ensemble, independent of the initial states: blocks must agree."""
    return order_for(rtol, atol, np.ones(1))
