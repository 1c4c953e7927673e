"""Sums and extremes along axes of long arrays."""

from typing import Any

import numpy as np

from ..symbols.symbolic import refuse
from .columns import Columns, joint
from .formulas import as_columns, operand_of

SHORT = 8  # terms that are added without a loop


def reduce(table, op, value, axis=None, keepdims=False) -> Any:
    """The sum ("sum"), maximum ("top") or minimum ("low") over `axis`."""
    array: Any = as_columns(table, value)
    if array.truth:
        array = np.where(array, 1.0, 0.0)
    if array.kind == "c":
        if op != "sum":
            refuse("the largest or the smallest of complex numbers")
        return joint(*(reduce(table, op, part, axis, keepdims) for part in array.parts()))
    axes = range(array.ndim) if axis is None else [int(a) % array.ndim for a in np.atleast_1d(axis)]
    if len(axes) == 1 and array.shape[axes[0]] <= SHORT and array.ndim > 1:
        return _of_few(op, array, axes[0], keepdims)
    kept = [i for i in range(array.ndim) if i not in axes]
    shape, count = tuple(array.shape[i] for i in kept), 1
    for i in axes:
        count *= array.shape[i]
    if count == 0:
        refuse("a sum over nothing")
    if kept != list(range(len(kept))):
        array = array.transpose([*kept, *axes])
    operand = operand_of(array, array.shape)
    if not isinstance(operand, int) and operand.ndim == 0:
        operand = operand.reshape(1)
    batch = table.make(op, count, shape, [operand])
    if keepdims:
        whole = tuple(1 if i in axes else n for i, n in enumerate(np.shape(value)))
        return Columns(table, None, batch).reshape(whole)
    return Columns(table, None, batch) if shape else table.symbol(batch.first)


def _of_few(op, array, axis, keepdims):
    """Unroll a sum or an extreme of few terms."""
    lead = (slice(None),) * axis
    combine = {"sum": np.add, "top": np.maximum, "low": np.minimum}[op]
    total: Any = array[(*lead, 0)]
    for i in range(1, array.shape[axis]):
        total = combine(total, array[(*lead, i)])
    return np.expand_dims(total, axis) if keepdims else total
