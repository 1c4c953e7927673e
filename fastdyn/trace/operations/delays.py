"""The state at an earlier time, and its derivative, which a delay equation reads.

"past" has no number as its value: "of_past" is one component, "of_slope" that of a derivative.  The
operands of "past" are the time, the first number of the array that names the solve's dense output,
and the time of the equations; its data are the numbers of components and of words, and the order of
the derivative, 0 or 1, or WEIGHT, by how much the past moves with the present state.  Derivatives
by the time hold the solution so far fixed.
"""

import numpy as np

from .record import Operation, add
from .value import Value

PAST = "fastdyn_past"  # symbol of the kernel
PASTS = frozenset(("past", "of_past", "of_slope"))
WEIGHT = 2


def _unknown(data, t, _, now):
    """The state before, which no graph knows: NaN."""
    return np.full((*np.shape(t), data[0]), np.nan)


def _slope(result, past):
    """The derivative of a component by the time at which the past is read."""
    node = past.of
    n, n_words, _ = node.data
    slopes = result.g.make("past", node.args, (n, n_words, 1))
    return Value(result.g, result.g.make("of_slope", (slopes,), result.of.data))


add(
    Operation("past", _unknown, (1.0, 0.0, 0.0), inner=True, cost=60, c=None, js=None,
              words="a state in the past"),
    Operation("of_past", lambda i, found: found[..., i], (_slope,), c=None, js=None,
              words="a past state"),
    Operation("of_slope", lambda i, found: found[..., i], c=None, js=None,
              words="the derivative of a past state"),
)  # fmt: skip
