"""The types of the arguments of the kernels that eliminate a sparse matrix."""

from fastdyn.kernels.algebra.sparse.factors import SparseFactors, SparsePattern

from .signatures import ROW, WORDS, kernel_of

FACTORS = SparseFactors(*[WORDS] * 4, ROW, ROW)
SPARSE_FACTORS = kernel_of(SparsePattern(*[WORDS] * 3), ROW, FACTORS, ROW)
SPARSE_SOLUTION = kernel_of(WORDS, FACTORS, ROW, ROW)
