"""Index reduction: F(t, y, y') = 0 of any index becomes ordinary differential equations."""

from .reduction import reduce_index

__all__ = ["reduce_index"]
