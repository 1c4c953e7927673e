"""The operations of a graph, one record each: see `record.py`.  Imports NumPy only."""

from . import arithmetic, functions, linear, special, tables
from .record import NAMES, OPERATIONS, Operation, add

__all__ = [
    "NAMES",
    "OPERATIONS",
    "Operation",
    "add",
    "arithmetic",
    "functions",
    "linear",
    "special",
    "tables",
]
