"""Differential-algebraic equations F(t, y, y') = 0."""

from .solve import solve_dae

__all__ = ["solve_dae"]
