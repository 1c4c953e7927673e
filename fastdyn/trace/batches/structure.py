"""NumPy's functions that only move elements: they act on node numbers."""

import numpy as np

from ..symbols.symbolic import is_symbolic, refuse
from .columns import Columns, ids_and_kind, ids_of, joint
from .columns import joined as joined_ids
from .formulas import as_columns

JOINING = {
    np.concatenate, np.stack, np.hstack, np.vstack, np.dstack, np.column_stack,
}  # fmt: skip

STRUCTURE = {
    np.roll, np.reshape, np.ravel, np.transpose, np.swapaxes, np.moveaxis, np.take, np.flip,
    np.flipud, np.fliplr, np.repeat, np.tile, np.broadcast_to, np.squeeze, np.expand_dims,
    np.split, np.array_split, np.hsplit, np.vsplit, np.rot90, np.atleast_1d, np.atleast_2d,
    np.diagonal, np.rollaxis, np.copy, np.delete, np.resize, np.diag, np.atleast_3d, np.dsplit,
    np.ascontiguousarray, np.asfortranarray, np.asarray, np.asanyarray, np.array, np.require,
}  # fmt: skip
TYPED = {np.ascontiguousarray, np.asfortranarray, np.asarray, np.asanyarray, np.array, np.require}


def structured(table, function, args, kwargs):
    """Apply a function of STRUCTURE to an array; the result is a view where NumPy's is a view."""
    first, *others = args
    array = as_columns(table, first)
    if isinstance(first, np.ndarray) and array is not first:
        array.forbid_stores()
    if function in TYPED:
        dtype = others.pop(0) if others else kwargs.get("dtype")
        kwargs = {name: value for name, value in kwargs.items() if name != "dtype"}
        array = array if dtype is None else array.astype(dtype, copy=False)
    if any(is_symbolic(a) for a in (*others, *kwargs.values())):
        refuse(f"np.{function.__name__} by numbers that depend on the state")
    if function is np.diag and array.ndim == 1:
        refuse("np.diag of a long array")
    found = function(array.ids, *others, **kwargs)
    if isinstance(found, list | tuple):
        return type(found)(array.view_of(ids) for ids in found)
    if found is array.ids:
        return array
    if np.may_share_memory(found, array.ids):
        return array.view_of(found)
    return Columns(table, np.asarray(found), kind=array.kind)


def joined(table, function, arrays, *args, **kwargs):
    """Apply a function of JOINING to arrays of numbers, or to arrays of truth values."""
    if kwargs.get("out") is not None:
        refuse(f"np.{function.__name__} with an array for its result")
    found = [ids_and_kind(table, a) for a in arrays]
    ids, kind = joined_ids(table, function, found, *args, **kwargs)
    return Columns(table, ids, kind=kind)


def padded(table, array, pad_width, mode="constant", constant_values=0.0, **more):
    array = as_columns(table, array)
    if array.kind == "c":
        given = pad_width, mode, constant_values
        return joint(*(padded(table, part, *given, **more) for part in array.parts()))
    if mode == "constant":
        ids = ids_of(table, constant_values, array.kind)
        if np.ndim(ids):
            refuse("np.pad with several constants")
        more["constant_values"] = int(ids)
    elif mode not in ("edge", "wrap", "reflect", "symmetric") or more:
        refuse(f"np.pad with mode {mode}")
    return Columns(table, np.pad(array.ids, pad_width, mode, **more), kind=array.kind)
