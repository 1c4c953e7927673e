"""The array type of long arrays: an ndarray of node numbers that acts as an array of numbers."""

import operator
from typing import Any

import numpy as np

from ..symbols.complex_pair import is_complex
from ..symbols.looking_up import plain_key
from ..symbols.masks import Masked
from ..symbols.symbolic import BATCHES, Batched, Symbolic, kind_of, refuse
from .table import ID, numbers


class Store:
    """Whether any view of an array was written to, and whether none may be (`frozen`)."""

    __slots__ = ("frozen", "written")

    def __init__(self):
        self.written = self.frozen = False


class Columns(Batched):
    """An array whose elements are node numbers.

    An array that is a whole batch in order stores the batch; its node numbers are made on demand.
    Views share their node numbers as views of NumPy's arrays share memory.
    """

    __slots__ = ("_batch", "_ids", "_store", "shape", "table", "truth")
    _called = "long array"

    def __init__(self, table, ids, batch: Any = None, store=None, truth=False):
        self.table, self._ids, self._batch = table, ids, batch
        self._store = store or Store()
        self.shape = batch.shape if ids is None else ids.shape
        self.truth = batch.truth if ids is None else truth

    g = property(lambda self: self.table.g)
    ndim = property(lambda self: len(self.shape))
    size = property(lambda self: int(np.prod(self.shape, dtype=np.int64)))
    dtype = property(lambda self: np.dtype(bool if self.truth else float))
    itemsize = property(lambda self: self.dtype.itemsize)
    nbytes = property(lambda self: self.itemsize * self.size)
    real = property(lambda self: self)

    @property
    def ids(self):
        if self._ids is None:
            self._ids = numbers(self._batch)
        return self._ids

    def whole(self):
        """The batch that this array equals, in order; None if it equals none or was written to."""
        return None if self._store.written else self._batch

    def written(self):
        return self._store.written

    def view_of(self, ids):
        """A view with these node numbers; a symbol if `ids` is one number."""
        if not isinstance(ids, np.ndarray):
            return self.table.symbol(ids)
        return Columns(self.table, ids, None, self._store, self.truth)

    # -- elements

    def __len__(self):
        if not self.shape:
            raise TypeError("len() of unsized object")
        return self.shape[0]

    def __getitem__(self, key) -> Any:
        if isinstance(key, Batched) and key.truth:
            return Masked(self, key)
        return self.view_of(self.ids[plain_key(key)])

    def __setitem__(self, key: Any, value: Any):
        ids = self.ids
        if isinstance(key, Batched) and key.truth:
            if isinstance(value, Masked):
                if value.mask is not key and not np.array_equal(value.mask.ids, key.ids):
                    refuse("two different masks of the state in one assignment")
                value = value.whole
            chosen: Any = key
            key, value = ..., np.where(chosen, value, self.copy())
        elif isinstance(value, Masked):
            refuse("a selection by a mask of the state")
        if is_complex(value) or (isinstance(value, Batched) and value.dtype.kind == "c"):
            refuse("complex numbers are stored in an array of real ones")
        given = ids_of(self.table, value, self.truth)
        if self._store.frozen:
            refuse("a store beside a view of another type")
        self._store.written = True
        ids[plain_key(key)] = given

    def __bool__(self):
        return bool(self.item())

    def __float__(self):
        return float(self.item())

    def __int__(self):
        return int(self.item())

    def __index__(self):
        return operator.index(self.item())

    def __contains__(self, value):
        return bool((self == value).any())

    def item(self, *at):
        if not at:
            if self.size != 1:
                raise ValueError("can only convert an array of size 1 to a Python scalar")
            return self.table.symbol(self.ids.reshape(-1)[0])
        return self.table.symbol(self.ids.item(*at))

    def tolist(self):
        return [v if isinstance(v, Symbolic) or not isinstance(v, Columns) else v.tolist()
                for v in self]  # fmt: skip

    # -- conversions that keep the elements

    def copy(self, order="C"):
        if self.whole() is not None:
            return Columns(self.table, None, self._batch)
        return Columns(self.table, self.ids.copy(), truth=self.truth)

    def conj(self):
        return self

    conjugate = conj

    def astype(self, dtype, *_, **__):
        kind = kind_of(dtype)
        if kind == "b":
            return self.copy() if self.truth else self != 0
        if kind == "c":
            return BATCHES["complex"](self.table, self.copy())
        if kind == "f" or (kind in "iu" and self.truth):
            return self.copy() if not self.truth else np.where(self, 1.0, 0.0)
        return refuse(f"a conversion to {dtype}")

    def freeze(self):
        """Refuse stores from now on: a view of another type has copies of these numbers."""
        self._store.frozen = True

    def view(self, dtype=None):
        if dtype is None or kind_of(dtype) != "c":
            refuse("a view of a long array in this way")
        return BATCHES["viewed"](self)


def _of_structure(name):
    def method(self, *args, **kwargs):
        return self.view_of(getattr(self.ids, name)(*args, **kwargs))

    return method


for _name in "reshape ravel transpose squeeze swapaxes take repeat diagonal".split():
    setattr(Columns, _name, _of_structure(_name))


def by_function(name):
    """The method of an array that calls the function of NumPy with this name."""

    def method(self, *args, **kwargs):
        return getattr(np, name)(self, *args, **kwargs)

    return method


for _name in "sum mean max min std var prod any all dot clip round ptp cumsum".split():
    setattr(Columns, _name, by_function(_name))


def ids_of(table, value, truth=None) -> Any:
    """The node numbers of an array-like, in its shape.

    If `truth` is True, numbers become truth values; if False, truth values become numbers.
    """
    found, is_truth = ids_and_truth(table, value)
    if truth is None or truth == is_truth or not np.size(found):
        return found
    given: Any = Columns(table, np.atleast_1d(np.asarray(found, ID)), truth=is_truth)
    chosen: Any = given != 0 if truth else np.where(given, 1.0, 0.0)
    return chosen.ids.reshape(np.shape(found))


def ids_and_truth(table, value) -> Any:
    if isinstance(value, Columns):
        return value.ids, value.truth
    if isinstance(value, Symbolic):
        return _of_single(table, value)
    if isinstance(value, bool | np.bool_):
        return np.array(table.one(table.g.const(bool(value))), ID), True
    if isinstance(value, int | float | np.integer | np.floating):
        return np.array(table.one(table.g.const(float(value))), ID), False
    if isinstance(value, list | tuple):
        parts = [ids_and_truth(table, v) for v in value]
        if len({np.shape(ids) for ids, _ in parts}) > 1:
            raise ValueError("setting an array element with a sequence")
        truths = {truth for _, truth in parts}
        if len(truths) > 1:
            refuse("truth values and numbers in one array")
        return np.array([ids for ids, _ in parts], ID), truths == {True}
    return table.of_array(value)


def _of_single(table, value):
    node = getattr(value, "node", None)
    if node is None:
        refuse("a complex number among long arrays")
    batch = table.one(node)
    return np.array(batch, ID), not hasattr(value, "kind")
