"""The error that a residual of the interpolant makes, by the real matrix of a step of Radau."""

from ...output.past.residual_filter import filter_by
from .stages import ERROR, REAL, solve_real

filter_residual = filter_by(solve_real, ERROR, 1.0 / REAL)
