"""The storage of the Jacobian and of the matrices of an implicit method: full, band or sparse.

`kernels/algebra/matrices.py` describes the words of matrices, `kernels/calls/block.py` the words of
Jacobians.
"""

import ctypes
from typing import Any, NamedTuple

import numpy as np

from fastdyn.code_store.call import address_of
from fastdyn.compile.derivatives.jacobian_block import (
    entries_block,
    entries_of,
    is_exact,
    pattern_of_batches,
    with_groups,
)
from fastdyn.compile.linear_systems.straight_bands import are_short, band_routines
from fastdyn.compile.linear_systems.straight_elimination import straight_routines
from fastdyn.kernels.calls.block import (
    BAND,
    FIRST,
    FULL,
    GROUPS,
    JACOBIAN,
    MATRICES,
    ORDER,
    ORDERED,
    OUTSIDE,
    OWN,
    RARE,
    REAL,
)
from fastdyn.problem.lsoda import NAME as LSODA
from fastdyn.problem.lsoda import NO_BAND
from fastdyn.specialise import rare

from ..begin import jacobian_of
from ..enough_memory import check_full_matrices
from .check_jacobian import check_sparsity
from .residual import matrices_of_residual
from .sparse_solver import SparseSolver

SMALL = 32  # up to so many components, our elimination is as fast as LAPACK's
WIDE = 160  # from this bandwidth on, a sparse solver may be faster than a band solver
SPARSE = 0.1  # largest share of elements in a sparse matrix
GAIN = 2  # factor by which a new order of the components must narrow the band
N_ROUTINES = ORDERED - REAL
NONE = np.empty(0, np.int64)

_capsule_name = ctypes.PYFUNCTYPE(ctypes.c_char_p, ctypes.py_object)(
    ("PyCapsule_GetName", ctypes.pythonapi)
)
_capsule_pointer = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)(
    ("PyCapsule_GetPointer", ctypes.pythonapi)
)


class Matrices(NamedTuple):
    """The matrices of a solve: objects to keep alive, `rows` of a matrix, SparseSolver or None.

    The words contain the addresses of the `routines`.
    """

    jacobian: Any
    words: Any
    rows: int
    solver: Any
    routines: Any


class Layout(NamedTuple):
    """Places of elements: kind, rows of the work array, distance of columns, bandwidths, order."""

    kind: int
    rows: int
    ld: int
    lower: int
    upper: int
    order: np.ndarray  # the new index of each component, or empty

    def places(self, entries):
        """The place of each entry."""
        rows = entries.rows
        columns = entries.columns
        if len(self.order):
            rows = self.order[rows]
            columns = self.order[columns]
        return columns * self.ld + rows

    def words(self, routines):
        """The words for kernels."""
        base = self.lower + self.upper
        head = [self.kind, self.rows, self.ld, base, self.lower, self.upper, *routines]
        words = np.array([*head, len(self.order) > 0, *self.order], np.int64)
        assert len(words) == ORDER + len(self.order)
        return words


def matrices_of(problem, bound, block):
    """The Matrices of a problem; `block` is the block of the Jacobian, or None.

    Writes the addresses of the Jacobian and of the matrices into the block of the equations.
    """
    p = problem
    n = len(problem.y0)
    if p.mode.residual:
        return matrices_of_residual(p, bound, block, matrices_of)
    if not p.method.n_matrices:
        _name(bound, None, None)
        return Matrices(None, None, n, None, None)
    jacobian = block
    entries = entries_of(block, n)
    if p.sparsity is not None and p.jac is None:
        check_sparsity(p, bound, entries)
    sparsity = p.sparsity
    if jacobian is None and sparsity is None and not p.differences:
        sparsity = pattern_of_batches(bound.function, n)
    if jacobian is None and sparsity is not None:
        entries = sparsity
        jacobian = with_groups(entries_block(entries, n), entries, n)
    known = None if _takes_all(p, jacobian) else entries
    layout = layout_of(n, known, p.mass)
    words, routines = _straight_words(p, known)
    solver = None
    if layout is not None:
        check_full_matrices(p.method, p.band, n, layout.rows)
        if layout.kind == OUTSIDE:
            solver = SparseSolver(n, entries, p.mass, bound.block)
            routines = solver.addresses()
        else:
            routines = _routines(layout, p.method.complex_matrices)
        words = layout.words(routines)
    if layout is not None and jacobian is not None and entries is not None:
        if layout.kind != FULL and is_exact(jacobian):
            jacobian = with_groups(jacobian, entries, n)
        places = layout.places(entries)
        jacobian[FIRST : FIRST + len(places)] = places
    _name(bound, jacobian, words)
    return Matrices(jacobian, words, n if layout is None else layout.rows, solver, routines)


def matrices_of_member(problem, bound, others):
    """The Matrices of a solve in an ensemble, full but for those of residuals.

    Writes the addresses of the Jacobian and of the matrices into the block of the equations.
    """
    block = jacobian_of(problem, bound, others)
    n = len(problem.y0)
    if problem.mode.residual:
        return matrices_of_residual(problem, bound, block, matrices_of)
    known = None if _takes_all(problem, block) else entries_of(block, n)
    words, routines = _straight_words(problem, known)
    _name(bound, block, words)
    return Matrices(block, words, n, None, routines)


def _name(bound, *blocks):
    """Write the addresses of the Jacobian and of the matrices into the block of the equations."""
    bound.block[RARE] = rare.ADDRESS
    for word, block in zip((JACOBIAN, MATRICES), blocks, strict=True):
        bound.block[word] = 0 if block is None else address_of(block)


def _takes_all(problem, block):
    """True if the method reads all elements.

    LSODA takes the norm of the matrix: all elements, or those which the trace knows.
    """
    known = block is not None and (is_exact(block) or block[GROUPS] > 0)
    return problem.method.name == LSODA and not (known and problem.band == NO_BAND)


def layout_of(n, entries, mass):
    """The Layout of matrices with the given entries; `entries` None stands for all elements.

    Returns None for our own elimination of a full matrix.
    """
    if n <= SMALL:
        return None
    if entries is None:
        return _full(n)
    band = _band(n, entries, mass)
    if band.lower + band.upper < min(WIDE, n // GAIN):
        return band
    if len(entries.rows) < SPARSE * n * n:
        return Layout(OUTSIDE, -(-(len(entries.rows) + n) // n), 0, 0, 0, NONE)
    return _full(n)


def _full(n):
    return Layout(FULL, n, n, 0, 0, NONE)


def _straight_words(problem, entries):
    """The words and the routines of a small matrix that straight-line code eliminates.

    Returns (None, None) if loops eliminate the matrix.
    """
    n = len(problem.y0)
    places = None
    if n > SMALL or not problem.method.n_matrices:
        return None, None
    if entries is not None:
        places = set(zip(entries.rows.tolist(), entries.columns.tolist(), strict=True))
        if problem.mass is not None:
            places |= set(map(tuple, np.argwhere(problem.mass).tolist()))
        places = tuple(sorted(places))
    routines = straight_routines(n, places, problem.method.complex_matrices)
    return None if routines is None else _full(n).words(routines), routines


def _band(n, entries, mass):
    """The Layout of a band, with the components in another order if the band becomes narrower."""
    lower, upper = bandwidths(entries.rows, entries.columns)
    order = NONE
    if mass is not None:
        rows, columns = np.nonzero(mass)
        more = bandwidths(rows, columns)
        lower = max(lower, more[0])
        upper = max(upper, more[1])
    elif lower + upper > SMALL:
        found = narrow_order(n, entries.rows, entries.columns)
        narrower = bandwidths(found[entries.rows], found[entries.columns])
        if GAIN * sum(narrower) <= lower + upper:
            lower, upper = narrower
            order = found
    ld = 2 * lower + upper
    kind = BAND if are_short(lower, upper) else OWN
    return Layout(kind, ld + 1, ld, lower, upper, order)


def bandwidths(rows, columns):
    """The numbers of diagonals below and above the main diagonal with these entries."""
    far = rows - columns
    return max(0, int(far.max(initial=0))), max(0, int(-far.min(initial=0)))


def narrow_order(n, rows, columns):
    """The new index of each component by the reverse Cuthill-McKee ordering."""
    from scipy.sparse import csr_matrix
    from scipy.sparse.csgraph import reverse_cuthill_mckee

    pattern: Any = csr_matrix((np.ones(len(rows)), (rows, columns)), (n, n))
    found = reverse_cuthill_mckee(csr_matrix(pattern + pattern.T), symmetric_mode=True)
    order = np.empty(n, np.int64)
    order[found] = np.arange(n)
    return order


def _routines(layout, complex_too):
    """The words of routines: straight-line code for a band, LAPACK's for a full matrix."""
    if layout.kind == OWN:
        return [0] * N_ROUTINES
    if layout.kind == BAND:
        return band_routines(layout.lower, layout.upper, complex_too)
    import scipy.linalg.cython_lapack as cython_lapack

    capsules = cython_lapack.__pyx_capi__
    found = [capsules[f"{z}ge{does}"] for z in "dz" for does in ("trf", "trs")]
    return [*(_capsule_pointer(c, _capsule_name(c)) for c in found), 0]  # 0: own products
