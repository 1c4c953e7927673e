"""Sparse matrices without a band, behind routines that kernels call.

Matrices of little fill are eliminated by our own loops, in an order that is fixed by the
pattern; others, and those whose diagonal is too small for a pivot, by SciPy's SuperLU.
"""

import ctypes
from typing import Any

import numpy as np

from fastdyn.compile.python_callback import numbers_at
from fastdyn.kernels.calls.block import RAISED_WORD

from .elimination import Elimination

POINTER = ctypes.c_void_p
FACTORISE, SOLVE, SOLVE_COMPLEX = (ctypes.CFUNCTYPE(None, *[POINTER] * k) for k in (3, 4, 5))
N_FACTORS = 3  # numbers a, b and c of a J + (b + i c) M
ALIKE = 0.5  # share of symmetric elements from which a symmetric ordering is used


class SparseSolver:
    """Factors of a J + (b + i c) M, and solutions.

    The kernel passes the entries of J and the numbers a, b, c with each request, so that another
    process that resumes a run can compute the factors again.

    Parameters
    ----------
    n : int
    entries : Entries
        The places of the elements of J.
    mass : ndarray, shape (n, n), or None for I
    block : array
        The block of the derivative.  After an exception, which `exception` keeps, the block is
        marked.
    """

    inside = False  # as in a `Callback`: no function of the user runs here

    def __init__(self, n, entries, mass, block):
        self._n = n
        self._block = block
        self.exception = None
        self.pending = None
        own = entries.columns * n + entries.rows
        diagonal = np.arange(n) * (n + 1)
        if mass is None:
            m_places = diagonal
            self._mass = np.ones(n)
        else:
            m_columns, m_rows = np.nonzero(mass.T)
            m_places = m_columns * n + m_rows
            self._mass = mass[m_rows, m_columns]
        places = np.unique(np.r_[own, m_places, diagonal])
        self._indices = (places % n).astype(np.int32)
        self._indptr = np.searchsorted(places, n * np.arange(n + 1)).astype(np.int32)
        self._of_jacobian = np.searchsorted(places, own)
        self._of_mass = np.searchsorted(places, m_places)
        self._count = len(own)
        self._entries = entries
        mirrored = places % n * n + places // n
        alike = np.isin(places, mirrored).mean() > ALIKE
        self._ordering = "MMD_AT_PLUS_A" if alike else "COLAMD"
        self._own: Any = Elimination(n, self._indptr, self._indices) if alike else None
        self._kept: dict = {}
        self._routines = (
            FACTORISE(self._factorise), SOLVE(self._solve), FACTORISE(self._factorise),
            SOLVE_COMPLEX(self._solve_complex), SOLVE(self._add_product),
        )  # fmt: skip

    def addresses(self):
        """The addresses of the routines, in the order of `kernels/algebra/matrices.py`."""
        return [ctypes.cast(routine, POINTER).value for routine in self._routines]

    def _numbers(self, address, count) -> Any:
        return numbers_at(address, count)

    def _factors(self, jacobian, given, anew=False):
        """The factors for the numbers at `given`; None for a singular matrix."""
        a, b, c = self._numbers(given, N_FACTORS)
        found = self._kept.get(given)
        if anew or found is None or found[0] != (a, b, c):
            found = self._kept[given] = (a, b, c), self._made(jacobian, a, b, c)
        return found[1]

    def _made(self, jacobian, a, b, c):
        from scipy.sparse import csc_matrix
        from scipy.sparse.linalg import splu

        data = np.zeros(len(self._indices), complex if c else float)
        data[self._of_jacobian] = a * self._numbers(jacobian, self._count)
        data[self._of_mass] += (b + 1j * c if c else b) * self._mass
        own = self._own and self._own.pays and self._own.factorised(data)
        if own:
            return own
        matrix = csc_matrix((data, self._indices, self._indptr), (self._n, self._n))
        try:
            return splu(matrix, permc_spec=self._ordering).solve
        except RuntimeError:
            return None

    def _factorise(self, jacobian, given, info):
        found = self._guarded(lambda: self._factors(jacobian, given, anew=True))
        ctypes.cast(info, ctypes.POINTER(ctypes.c_int32))[0] = found is None

    def _solve(self, jacobian, given, b, info):
        row = self._numbers(b, self._n)
        factors = self._guarded(lambda: self._factors(jacobian, given))
        row[:] = np.nan if factors is None else factors(row)

    def _solve_complex(self, jacobian, given, b, c, info):
        re = self._numbers(b, self._n)
        im = self._numbers(c, self._n)
        factors = self._guarded(lambda: self._factors(jacobian, given))
        x: Any = np.full(self._n, np.nan) if factors is None else factors(re + 1j * im)
        re[:], im[:] = x.real, x.imag

    def _add_product(self, jacobian, given, out, info):
        """out + J given."""
        rows, columns = self._entries
        x = self._numbers(given, self._n)
        total = self._numbers(out, self._n)
        numbers = self._numbers(jacobian, self._count)
        total += np.bincount(rows, numbers * x[columns], self._n)

    def _guarded(self, action):
        """The result of an action; None after an exception, which is kept for the caller."""
        try:
            if self.exception is not None:
                return None
            if self.pending is not None:
                self.pending()
            return action()
        except BaseException as error:
            self.exception = error
            self._block[RAISED_WORD] = 1
            return None
