"""Converts arrays of objects to plain arrays for NumPy's code, and results back."""

from typing import Any

import numpy as np

from ..symbols.arrays import Array
from ..symbols.symbolic import BATCHES, NOW, Batched, graph_of, in_batches, is_symbolic
from .constants import Constants

EXACT = "float64", "complex128"  # types whose numbers symbols can be


def lowered(value) -> Any:
    """Convert an object array without symbols to a plain array, also in lists and tuples."""
    if isinstance(value, Array) and value.dtype == object and graph_of(value) is None:
        plain = np.array(value.tolist())
        return plain.reshape(value.shape) if plain.dtype != object else value.view(np.ndarray)
    if type(value) in (list, tuple):
        return _of_kind(value, map(lowered, value))
    return value


def raised(value) -> Any:
    """Convert NumPy's result to an array that can hold symbols."""
    if isinstance(value, Batched):
        return value
    if isinstance(value, np.ndarray) and not isinstance(value, Array):
        if NOW.table is not None and str(value.dtype) in EXACT and value.ndim:
            return BATCHES["raised"](NOW.table, value)
        if value.dtype == object or (str(value.dtype) in EXACT and value.size <= 4096):
            return Array.of(value) if value.ndim else value
        return value.view(Constants) if value.dtype.kind in "fib" and value.ndim else value
    if type(value) in (list, tuple):
        return _of_kind(value, map(raised, value))
    return value


def _of_kind(like, values):
    return tuple(values) if type(like) is tuple else list(values)


def number(value):
    """The element of an array of size 1; any other value unchanged."""
    return value.item() if isinstance(value, np.ndarray) and value.size == 1 else value


def as_array(value):
    """Convert a list or tuple with symbols to an Array; return any other value unchanged."""
    return Array.of(value) if isinstance(value, list | tuple) and is_symbolic(value) else value


def array_of(value) -> Any:
    """Convert an array-like to a long array if it holds a long array, else to an Array."""
    return BATCHES["raised"](NOW.table, value) if in_batches([value]) else Array.of(value)
