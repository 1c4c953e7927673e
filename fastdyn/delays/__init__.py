"""Delay equations: solve_dde, prepare_dde, solve_dde_ensemble."""

from .ensemble import DelayTrajectories, solve_dde_ensemble
from .equation import METHODS
from .prepare import PreparedDelays, prepare_dde
from .solve import solve_dde

__all__ = [
    "METHODS", "DelayTrajectories", "PreparedDelays", "prepare_dde", "solve_dde",
    "solve_dde_ensemble",
]  # fmt: skip
