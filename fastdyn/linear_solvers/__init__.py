"""Routines that solve small systems of equations and narrow bands, in straight-line code."""

from fastdyn.kernels.algebra.linear import solve_linear

__all__ = ["solve_linear"]
