"""Calls of libraries on long arrays: one call is one batch, whose elements are the results."""

import numpy as np

from ..symbols.symbolic import BATCHES, refuse
from .columns import Columns, ids_and_truth
from .products import whole
from .table import ID


def island(table, parts, data):
    """The results of a library's call as one array.

    `parts` are the arguments: numbers, arrays and symbols.  `data` are the slot of the function's
    address, the number of inputs, and the number of results.  The batch has one more element, which
    tells whether the call failed.
    """
    found = [ids_and_truth(table, part) for part in parts]
    if any(truth for _, truth in found):
        refuse("truth values are given to a library")
    ids = np.concatenate([np.ravel(i) for i, _ in found]).astype(ID)
    given = whole(table, Columns(table, ids))
    return Columns(table, None, table.make("island", ("island", *data), (data[2] + 1,), [given]))


BATCHES["island"] = island
