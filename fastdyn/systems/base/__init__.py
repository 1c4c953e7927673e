"""The base of the systems: declaration, solution, results."""

from .declare import State, constraint, derived, event, initial, invariant, parameter, quantity
from .system import System

__all__ = [
    "State", "System", "constraint", "derived", "event", "initial", "invariant", "parameter",
    "quantity",
]  # fmt: skip
