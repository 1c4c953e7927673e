"""Blocks of Jacobians: constant matrices, entries, and exact Jacobians of traces.

`kernels/calls/block.py` defines the words.
"""

import hashlib
from typing import NamedTuple

import numpy as np

from fastdyn.kernels.calls.block import FIRST, GROUPS, N_ENTRIES, OWN_BLOCK
from fastdyn.trace.graph.refusal import Untraceable

from ..functions import Function
from ..mode import CONSTANT
from .jacobian import jacobian

NONE = np.empty(0)
MANY = 1000  # columns; beyond this number, SciPy finds the groups faster


def constant_function(matrix):
    """The Function of a constant matrix; its key is the digest of the numbers."""
    digest = hashlib.sha256(matrix.tobytes()).hexdigest()
    return Function(f"constant {digest}", 0, 0, None, matrix, CONSTANT, seconds=0.0)


def constant_block(matrix):
    """The block of a constant Jacobian."""
    block = np.zeros(FIRST + matrix.size, np.int64)
    block[FIRST:] = np.ascontiguousarray(matrix).view(np.int64).reshape(-1)
    return block


class Entries(NamedTuple):
    """The places of a matrix's elements that are not zero everywhere, column by column."""

    rows: np.ndarray
    columns: np.ndarray


def entries_block(entries, n, numbers=NONE, own=False):
    """The block of a Jacobian that is given by its entries.

    The words hold the entries' places in the full matrix, by columns.

    Parameters
    ----------
    entries : Entries
    n : int
    numbers : array of float, optional
        The entries of a constant Jacobian.
    own : bool
        Whether the Jacobian's function takes this block instead of the derivative's block.
    """
    places = entries.columns * n + entries.rows
    numbers = np.ascontiguousarray(numbers).view(np.int64)
    block = np.concatenate([np.zeros(FIRST, np.int64), places, numbers])
    block[N_ENTRIES] = len(places)
    block[OWN_BLOCK] = own
    return block


def with_groups(block, entries, n):
    """A block with groups of columns: a finite difference computes all entries of a group."""
    group = groups_of(entries, n)
    begins = np.searchsorted(entries.columns, np.arange(n + 1))
    block = np.concatenate([block[: FIRST + len(entries.rows)], entries.rows, begins, group])
    block[GROUPS] = group.max(initial=-1) + 1
    return block


def entries_of(block, n):
    """The Entries of a block that stores places in the full matrix; None without entries."""
    if block is None or block[N_ENTRIES] == 0:
        return None
    columns, rows = np.divmod(block[FIRST : FIRST + block[N_ENTRIES]], n)
    return Entries(rows, columns)


def is_exact(block):
    """Whether a block belongs to an exact Jacobian."""
    return block[0] != 0 and block[N_ENTRIES] > 0 and block[OWN_BLOCK] == 0


def pattern_of_batches(function, n):
    """The Entries of a function traced in batches; None if dense, or if not traced in batches."""
    traced = None if function is None else function.traced
    found = traced.pattern if traced is not None and traced.n_stored == n else None
    return None if found is None else Entries(*found)


def groups_of(entries, n):
    """The group of each column: the first group without a common row with the column."""
    if n > MANY:
        from scipy.optimize._numdiff import group_columns
        from scipy.sparse import csc_matrix

        at = entries.rows, entries.columns
        pattern = csc_matrix((np.ones(len(entries.rows)), at), (n, n))
        return np.asarray(group_columns(pattern, np.arange(n)), np.int64)
    ends = np.searchsorted(entries.columns, np.arange(n + 1))
    taken: list = []
    group = np.zeros(n, np.int64)
    for j in range(n):
        rows = entries.rows[ends[j] : ends[j + 1]]
        free = [g for g, mine in enumerate(taken) if not mine[rows].any()]
        if not free:
            free = [len(taken)]
            taken.append(np.zeros(n, bool))
        group[j] = free[0]
        taken[free[0]][rows] = True
    return group


def exact_block(function, n, time=False):
    """The block of a compiled function's exact Jacobian; None if there is none.

    The words that are parameters in other blocks are the places of the entries.  With `time`, the
    Jacobian's function also writes df/dt, behind the entries.
    """
    if function is None or function.traced is None or function.traced.n != n:
        return None
    if function.traced.in_batches:
        return None
    try:
        found = jacobian(function, time)
    except Untraceable:
        return None
    if found is None or len(found.rows) == 0 or len(function.traced.stored) != n:
        return None
    block = entries_block(Entries(found.rows, found.columns), n)
    block[0] = found.function.address
    return block
