"""The derivative of [y, t] with respect to another time s: y' dt/ds, and dt/ds."""

import numpy as np


def scaled(f, rate):
    """[rate * each component of f, rate]: the derivative of [y, t] with respect to the new time."""
    return [*(rate * float(x) for x in np.ravel(f)), rate]
