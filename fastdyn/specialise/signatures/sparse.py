"""The types of the arguments of the kernels that eliminate a sparse matrix, real or complex."""

import numpy as np

from fastdyn.kernels.algebra.sparse.factors import SparseFactors, SparsePattern

from . import ROW, WORDS, kernel_of

COMPLEX = np.empty(0, complex)
PATTERN = SparsePattern(*[WORDS] * 3)
FACTORS, COMPLEX_FACTORS = (SparseFactors(*[WORDS] * 4, row, row) for row in (ROW, COMPLEX))
SPARSE_FACTORS = kernel_of(PATTERN, ROW, FACTORS, ROW)
SPARSE_SOLUTION = kernel_of(WORDS, FACTORS, ROW, ROW)
COMPLEX_SPARSE_FACTORS = kernel_of(PATTERN, COMPLEX, COMPLEX_FACTORS, COMPLEX)
COMPLEX_SPARSE_SOLUTION = kernel_of(WORDS, COMPLEX_FACTORS, COMPLEX, COMPLEX)
