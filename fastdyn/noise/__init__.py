"""Equations with noise: solve_sde and solve_langevin, on many paths at once."""

from .paths import Paths
from .reductions import Histogram, Quantiles
from .solve import solve_langevin, solve_sde

__all__ = ["Histogram", "Paths", "Quantiles", "solve_langevin", "solve_sde"]
