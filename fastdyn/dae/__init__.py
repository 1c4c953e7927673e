"""Differential-algebraic equations F(t, y, y') = 0."""

from .structure.reduction import Reduction, reduce_index

__all__ = ["Reduction", "reduce_index"]
