"""The problems of all groups: equations, initial states, spans, end states."""

from .collection import (
    BODIES,
    BUILDING,
    CHAIN,
    PENDULUM,
    PROBLEMS,
    SATELLITE,
    WORK,
    bodies_of,
    chain_of,
    course,
)
from .end_states import error, reference
from .problem import compiled, in_place

__all__ = [
    "BODIES", "BUILDING", "CHAIN", "PENDULUM", "PROBLEMS", "SATELLITE", "WORK", "bodies_of",
    "chain_of", "compiled", "course", "error", "in_place", "reference",
]  # fmt: skip
