"""The iteration matrix of a residual F(t, y, y'): its pattern, its storage, its block.

`kernels/methods/residual/matrix.py` describes the block.
"""

from typing import Any, NamedTuple

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.compile.derivatives.jacobian_block import (
    Entries,
    entries_block,
    entries_of,
    groups_of,
    pattern_of_batches,
)
from fastdyn.compile.mode import DERIVATIVE
from fastdyn.kernels.calls.block import (
    ABOVE,
    BELOW,
    FIRST,
    GROUPS,
    JACOBIAN,
    KIND,
    N_ENTRIES,
    N_RATE,
    N_STATE,
    OUTSIDE,
)

NOT_KNOWN: Any = None


class Pattern(NamedTuple):
    """The places of the elements of dF/dy + c dF/dy', and the entries of dF/dy and dF/dy'.

    `both` has the places of the entries in [dF/dy, dF/dy'].  `elements` has, for each entry, the
    index of the element to which the entry contributes.  The first `n_state` entries belong to
    dF/dy.  `rates` marks the components whose derivative occurs in F.
    """

    both: Entries
    entries: Entries
    elements: np.ndarray
    n_state: int
    rates: np.ndarray


def pattern_of_residual(bound, block, n):
    """The Pattern of a residual of n equations; None if the pattern is unknown.

    `block` is the block of the exact Jacobian with respect to y and y', or None.
    """
    both = entries_of(block, 2 * n)
    if both is None:
        both = pattern_of_batches(bound.function, 2 * n)
    if both is None:
        return None
    own = both.rows < n
    rows = both.rows[own]
    columns = both.columns[own]
    places, elements = np.unique(columns % n * n + rows, return_inverse=True)
    rates = np.zeros(n, bool)
    rates[columns[columns >= n] - n] = True
    entries = Entries(places % n, places // n)
    return Pattern(Entries(rows, columns), entries, elements, int(np.sum(columns < n)), rates)


def matrices_of_residual(problem, bound, block, matrices_of):
    """The Matrices of a problem of a residual.

    `block` is the block of the exact Jacobian, or None.  `matrices_of` makes the Matrices of
    equations with as many components as F.
    """
    n = len(problem.y0) // 2
    pattern = pattern_of_residual(bound, block, n)
    if pattern is None:
        columns, rows = np.divmod(np.arange(n * n), n)
        pattern = Pattern(
            NOT_KNOWN, Entries(rows, columns), np.empty(0, np.int64), 0, np.ones(n, bool)
        )
    entries = pattern.entries
    half = problem._replace(y0=problem.y0[:n], mode=DERIVATIVE)
    found = matrices_of(half, bound, entries_block(entries, n))
    m = len(entries.rows)
    words = found.words
    places = found.jacobian[FIRST : FIRST + m]
    far = entries.rows - entries.columns
    limits = [far.max(initial=0), -far.min(initial=0)]
    if words is not None and words[KIND] == OUTSIDE:
        places = np.arange(m)
    elif words is not None and n > 0 and len(words):
        limits = _limits(words, limits)
    group = groups_of(entries, n)
    begins = np.searchsorted(entries.columns, np.arange(n + 1))
    own = np.concatenate(
        [np.zeros(FIRST, np.int64), limits, places, entries.rows, begins, group,
         places[pattern.elements]]
    ).astype(np.int64)  # fmt: skip
    own[N_ENTRIES], own[GROUPS] = m, group.max(initial=-1) + 1
    if block is not None:
        own[0], own[N_STATE] = block[0], pattern.n_state
        own[N_RATE] = len(pattern.elements) - pattern.n_state
    bound.block[JACOBIAN] = address_of(own)
    return found._replace(jacobian=own, rows=-(-found.rows // 2))


def _limits(words, limits):
    """The bandwidths of the matrix, whose components may be in another order."""
    stored = words[BELOW], words[ABOVE]
    return stored if any(stored) else limits
