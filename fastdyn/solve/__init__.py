"""The public solvers of one trajectory."""

from .halves import solve_second_order, solve_separable
from .time_transform import time_transformed

__all__ = ["solve_second_order", "solve_separable", "time_transformed"]
