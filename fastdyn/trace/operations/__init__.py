"""The operations of a graph, one record each: see `record.py`.  Imports NumPy only."""

from . import arithmetic, delays, functions, linear, special, tables
from .record import NAMES, OPERATIONS, Operation, add

__all__ = [
    "NAMES",
    "OPERATIONS",
    "Operation",
    "add",
    "arithmetic",
    "delays",
    "functions",
    "linear",
    "special",
    "tables",
]
