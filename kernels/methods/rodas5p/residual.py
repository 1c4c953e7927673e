"""The error that a residual of the interpolant makes, by the matrix of a step of Rodas5P."""

from ...algebra.matrices import matrix_rows, solve_sum
from ...jit.options import INLINED, njit
from ...output.past.residual_filter import filter_by
from .derivatives import FACTOR, PIVOTS, SUM, J
from .table import GAMMA


@njit(**INLINED)
def _solve(s, work, block, row):
    factors = J + matrix_rows(block, work.shape[1])
    solve_sum(s, work, block, J, factors, PIVOTS, row, FACTOR + 1)


filter_residual = filter_by(_solve, SUM, GAMMA)
