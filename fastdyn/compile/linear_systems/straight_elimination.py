"""Routines with LAPACK's interface for small matrices of one structure, in straight-line code."""

import functools

from fastdyn.kernels.algebra import straight_line
from fastdyn.kernels.algebra.elimination_structure import structure

from .straight_routines import Column, Matrix, Notes, has_exchanges, routines

# Most products of a factorisation.  The routines of a full matrix of 8 rows (168 products) compile
# for 0.11 CPU s, those of 10 rows (330) for 0.25, of 12 rows (572) for 0.44.
MOST_PRODUCTS = 200
FULL = 8  # most rows of a full matrix: 9 rows have 240 products


def _factorise(numbers, found, arguments):
    """Emit ?getrf; `info` is not 0 if the matrix is singular."""
    _, _, matrix, _, pivots, info = arguments
    n = len(found.below)
    notes = Notes(numbers)
    a = Matrix(numbers, found, n, matrix, pivots)
    exchanged = straight_line.factorise(numbers, a)
    notes.take(exchanged, [a[k, k] for k in range(n)])
    notes.put(a, n - 1, info)


def _solve(numbers, found, arguments):
    """Emit ?getrs for one right-hand side."""
    _, _, _, matrix, _, pivots, side, _, _ = arguments
    builder = numbers.builder
    n = len(found.below)
    side = Column(numbers, side)
    a = Matrix(numbers, found, n, matrix, pivots)
    with builder.if_else(has_exchanges(numbers, a, n - 1)) as (then, otherwise):
        with then:
            straight_line.forward(numbers, a, side, a.exchange_in(side))
            straight_line.backward(numbers, a, side)
        with otherwise:
            values = [side[i] for i in range(n)]
            straight_line.forward(numbers, a, values)
            straight_line.backward(numbers, a, values)
            for i, value in enumerate(values):
                side[i] = value


ROUTINES = {"getrf": (_factorise, 6), "getrs": (_solve, 9)}


@functools.lru_cache(256)
def straight_routines(n, places, complex_too):
    """The addresses of routines for matrices of n rows: dgetrf, dgetrs, zgetrf, zgetrs.

    Parameters
    ----------
    n : int
    places : tuple of (int, int), optional
        The row and the column of each element that may differ from zero; elements of the diagonal
        may be left out.  None: all elements may differ from zero.
    complex_too : bool

    Returns
    -------
    Routines or None
        None if the code would be too long to pay.
    """
    if places is None:
        if n > FULL:
            return None
        places = [(i, j) for i in range(n) for j in range(n)]
    found = structure(places, n)
    if found.n_products > MOST_PRODUCTS:
        return None
    return routines(ROUTINES, (found,), complex_too, scheduled=True)
