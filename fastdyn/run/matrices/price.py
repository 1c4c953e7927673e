"""What the matrices of an implicit method cost, beside the evaluations of an explicit one.

Counts of operations decide, never the clock: the same solve is always told the same.
"""

from typing import Any

import numpy as np

from fastdyn.compile.derivatives.jacobian_block import pattern_of_batches
from fastdyn.kernels.calls.block import FULL, OUTSIDE

from .layouts import layout_of

FEWEST = 20  # factorisations of a stiff solve: BDF takes 42 for two periods of a Brusselator
SPARSE = 12  # time of an operation of SuperLU, in those of bands: 4.1e6 take 7 ms, 3.6e7 take 5
A_NUMBER = 5  # operations of an evaluation for each element of the Jacobian


def is_dear(bound, n, n_evaluations):
    """Whether the factorisations alone cost more than evaluations did.

    Told of functions traced in batches, whose Jacobians may be large; False for others.  Seconds
    of a processor for n = 2048, 2026-11-28, by Tsit5 and by BDF: a Brusselator of 32 x 32 places
    0.18 (20 000 evaluations) and 0.59, 0.45 (60 000) and 0.38; heat on 32 x 64 places 0.14 (20 000)
    and 0.10.
    """
    entries = pattern_of_batches(bound.function, n)
    if entries is None:
        return False
    return FEWEST * _factorisation(n, entries) > A_NUMBER * len(entries.rows) * n_evaluations


def _factorisation(n, entries):
    """Operations of one factorisation."""
    layout = layout_of(n, entries, None)
    if layout is None or layout.kind == FULL:
        return 2 * n**3 / 3
    if layout.kind == OUTSIDE:
        return _sparse(n, entries)
    return 2 * n * layout.lower * (layout.lower + layout.upper)


def _sparse(n, entries):
    """Operations of a factorisation by SuperLU, from the fill of its factors."""
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import splu

    ones: Any = -np.ones(len(entries.rows))
    pattern = csc_matrix((ones, (entries.rows, entries.columns)), (n, n))
    dominant = csc_matrix((np.full(n, 2.0 * n), (np.arange(n), np.arange(n))), (n, n))
    factors = splu(csc_matrix(pattern + dominant), permc_spec="MMD_AT_PLUS_A")
    of_l = np.diff(factors.L.indptr)
    of_u = np.bincount(factors.U.indices, minlength=n)
    return SPARSE * 2.0 * float(of_l @ of_u)
