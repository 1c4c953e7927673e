"""The state at an earlier time, which a delay equation reads.

"past" has no number as its value: "of_past" is one component.  The operands of "past" are the time,
and the first number of the array that names the solve's dense output.
"""

import numpy as np

from .record import Operation, add

PAST = "fastdyn_past"  # symbol of the kernel


def _unknown(data, t, _):
    """The state before, which no graph knows: NaN."""
    return np.full((*np.shape(t), data[0]), np.nan)


add(
    Operation("past", _unknown, inner=True, cost=60, c=None, js=None, words="a state in the past"),
    Operation("of_past", lambda i, found: found[..., i], c=None, js=None, words="a past state"),
)
