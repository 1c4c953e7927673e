"""Index reduction: F(t, y, y') = 0 of any index becomes ordinary differential equations."""

from .solve import reduce_index, solve_reduced

__all__ = ["reduce_index", "solve_reduced"]
