"""Sparse Jacobians from the user: constant matrices, and Python functions that return them."""

import numpy as np

from fastdyn.kernels.calls.block import FIRST

from ..functions import Bound, with_callback
from ..mode import CONSTANT, ENTRIES
from ..python_callback import Callback, Held, check_shape, is_sparse
from .jacobian_block import Entries, constant_function, entries_block


class WiderPattern(Exception):
    """Raised if a sparse Jacobian gets elements outside its pattern; `entries` has all elements."""

    def __init__(self, entries):
        super().__init__("the pattern of a sparse Jacobian changes")
        self.entries = entries


def pattern_of(matrix, n, name="jac"):
    """The Entries of a sparse matrix or an array; one entry if all elements are zero.

    Raises ValueError if the shape is not (n, n).
    """
    if not is_sparse(matrix):
        matrix = np.asarray(matrix)
    check_shape(matrix, n, name)
    if not is_sparse(matrix):
        columns, rows = np.nonzero(matrix.T)
    else:
        rows, columns, _ = _coordinates(matrix)
    return in_order(rows, columns, n) if len(rows) else Entries(*np.zeros((2, 1), np.int64))


def _coordinates(matrix):
    """Rows, columns and numbers of a sparse matrix, with duplicates summed."""
    matrix = matrix.tocsc(copy=True)
    matrix.sum_duplicates()
    matrix = matrix.tocoo()
    return matrix.row.astype(np.int64), matrix.col.astype(np.int64), matrix.data


def in_order(rows, columns, n):
    """The Entries of places in any order, without duplicates."""
    columns, rows = np.divmod(np.unique(columns * n + rows), n)
    return Entries(rows, columns)


def entries_of_matrix(matrix, entries, n):
    """The numbers of a sparse matrix at `entries`; raise WiderPattern if it has other elements."""
    check_shape(matrix, n)
    rows, columns, data = _coordinates(matrix)
    places = entries.columns * n + entries.rows
    own = columns * n + rows
    at = np.searchsorted(places, own)
    if len(own) and (at[-1] >= len(places) or (places[at] != own).any()):
        both = np.r_[places, own]
        raise WiderPattern(in_order(both % n, both // n, n))
    numbers = np.zeros(len(places))
    numbers[at] = data
    return numbers


def bind_sparse_matrix(matrix):
    """The Bound of a constant sparse Jacobian."""
    n = matrix.shape[0]
    entries = pattern_of(matrix, n)
    block = entries_block(entries, n, entries_of_matrix(matrix, entries, n))
    return Bound(
        constant_function(block), block, lambda t, y: matrix, Held(matrix), None, [], CONSTANT
    )


def bind_sparse_function(fun, args, n, entries):
    """The Bound of a function that returns sparse matrices within the pattern `entries`."""

    def as_entries(t, y):
        matrix = fun(t, y, *args)
        if not is_sparse(matrix):
            raise TypeError("`jac` returned a sparse matrix before, and an array now.")
        return entries_of_matrix(matrix, entries, n)

    callback = Callback(as_entries, ENTRIES, n, n_out=len(entries.rows))
    block = entries_block(entries, n, own=True)
    assert len(block) == FIRST + len(entries.rows)
    return with_callback(callback, lambda t, y: fun(t, y, *args), Held(fun, args), ENTRIES, block)
