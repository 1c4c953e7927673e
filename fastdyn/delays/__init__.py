"""Delay equations: solve_dde, prepare_dde."""

from .equation import METHODS
from .prepare import PreparedDelays, prepare_dde
from .solve import solve_dde

__all__ = ["METHODS", "PreparedDelays", "prepare_dde", "solve_dde"]
