"""Delay equations: solve_dde."""

from .solve import METHODS, solve_dde

__all__ = ["METHODS", "solve_dde"]
