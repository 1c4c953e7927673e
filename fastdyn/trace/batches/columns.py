"""The array type of long arrays: an ndarray of node numbers that acts as an array of numbers."""

import operator
from typing import Any

import numpy as np

from ..symbols.complex_pair import Pair, is_complex, parts
from ..symbols.conditions import Condition, kind_of_number
from ..symbols.masks import Masked, chosen
from ..symbols.operators import by_function
from ..symbols.real import Symbol
from ..symbols.symbolic import Batched, kind_of, refuse
from ..symbols.symbolic_indices import plain_key
from .table import ID, PAIR, PARTS, common_kind, numbers, paired

DTYPES = {kind: np.dtype(of) for kind, of in zip("bifc", (bool, int, float, complex), strict=True)}


class Columns(Batched):
    """An array whose elements are node numbers; a complex element is a pair of node numbers.

    If an array equals a whole batch in order, the array stores the batch, and makes the node
    numbers on demand.  A complex array stores two batches.  The node numbers lie in memory as the
    elements of NumPy's array do, and views share them as views of NumPy's arrays share memory.
    `kind` is "b" for truth values, "i" for whole numbers, "f" for real numbers and "c" for complex
    numbers.
    """

    __slots__ = ("_batch", "_ids", "_shape", "_written", "kind", "table")
    _called = "long array"

    def __init__(self, table, ids, batch: Any = None, written=None, kind="f"):
        self.table, self._ids, self._batch = table, ids, batch
        self._written: Any = written or [False]  # one list, shared by all views
        if ids is not None:
            self._shape, self.kind = ids.shape, kind
        elif isinstance(batch, tuple):
            self._shape, self.kind = batch[0].shape, "c"
        else:
            self._shape, self.kind = batch.shape, "b" if batch.truth else kind

    g = property(lambda self: self.table.g)
    shape: Any = property(
        lambda self: self._shape, lambda *_: refuse("it changes the shape of an array")
    )
    ndim = property(lambda self: len(self.shape))
    size = property(lambda self: int(np.prod(self.shape, dtype=np.int64)))
    truth = property(lambda self: self.kind == "b")
    dtype = property(lambda self: DTYPES[self.kind])
    itemsize = property(lambda self: self.dtype.itemsize)
    nbytes = property(lambda self: self.itemsize * self.size)
    real = property(lambda self: self._part(0), lambda self, new: self._store_part(0, new))
    imag = property(lambda self: self._part(1), lambda self, new: self._store_part(1, new))

    @property
    def ids(self):
        if self._ids is None:
            whole, many = self._batch, isinstance(self._batch, tuple)
            self._ids = paired(*map(numbers, whole)) if many else numbers(whole)
        return self._ids

    def whole(self):
        """The batch that this array equals in order; two batches for a complex array; else None.

        After a write to the array, the result is None, too.
        """
        return None if self._written[0] else self._batch

    def written(self):
        return self._written[0]

    def forbid_stores(self):
        """Refuse stores in this array and its views: another array has the same memory."""
        self._written[0] = None

    def in_order(self):
        """Whether the elements lie in C order."""
        return self._ids is None or self._ids.flags.c_contiguous

    def relabelled(self, dtype):
        """The array itself, as real numbers of another type: NumPy's for whole numbers."""
        if dtype == self.dtype:
            return self
        if dtype not in (int, float) or self.kind not in "if":
            refuse(f"an array of {dtype}", typed=True)
        self.kind = np.dtype(dtype).kind
        return self

    def laid_out(self, like):
        """A copy that lies in memory as the array `like`."""
        ids = np.empty_like(like.view(np.ndarray), self.ids.dtype)
        ids[...] = self.ids
        return Columns(self.table, ids, self.whole(), kind=self.kind)

    def view_of(self, ids):
        """A view with these node numbers; a symbol if `ids` is one number."""
        if isinstance(ids, np.ndarray):
            return Columns(self.table, ids, None, self._written, self.kind)
        if self.kind == "c":
            return Pair(*map(self.table.symbol, ids))
        return self.table.symbol(ids)

    # -- complex numbers

    def _part(self, i):
        """A view of the real (0) or of the imaginary part (1)."""
        if self.kind != "c":
            return np.zeros_like(self) if i else self
        batch = self._batch and self._batch[i]
        return Columns(self.table, self.ids[PARTS[i]], batch, self._written)

    def _store_part(self, i, new):
        if i and self.kind != "c":
            raise TypeError("array does not have imaginary part to set")
        self._part(i)[...] = new

    def parts(self):
        """(real part, imaginary part), to be read only; a real array gives (the array,)."""
        if self.kind != "c":
            return (self,)
        if self.whole() is None:
            return tuple(Columns(self.table, self.ids[name].copy()) for name in PARTS)
        return tuple(Columns(self.table, None, batch) for batch in self._batch)

    # -- elements

    def __len__(self):
        if not self.shape:
            raise TypeError("len() of unsized object")
        return self.shape[0]

    def __getitem__(self, key) -> Any:
        if isinstance(key, Batched) and key.truth:
            if self.kind == "c":
                refuse("a selection of complex numbers by a mask of the state")
            return Masked(self, key)
        return self.view_of(self.ids[plain_key(key)])

    def __setitem__(self, key: Any, value: Any):
        ids = self.ids
        if isinstance(key, Batched) and key.truth:
            if key.shape != self.shape:
                refuse("a mask of the state of another shape than the array")
            mask: Any = key
            key, value = ..., np.where(mask, chosen(mask, value), self.copy())
        given = ids_of(self.table, value, self.kind)
        if self._written[0] is None:
            refuse("it changes an array", effect=True)
        self._written[0] = True
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
        if not at and self.size != 1:
            raise ValueError("can only convert an array of size 1 to a Python scalar")
        return self.view_of(self.ids.item(*at))

    def tolist(self):
        return [v.tolist() if isinstance(v, Columns) else v for v in self]

    # -- conversions that keep the elements

    def copy(self, order: Any = "C"):
        if self.whole() is not None and (order == "C" or (order != "F" and self.in_order())):
            return Columns(self.table, None, self._batch, kind=self.kind)
        return Columns(self.table, self.ids.copy(order), kind=self.kind)

    def reshape(self, *shape, order: Any = "C"):
        return self.view_of(self.ids.reshape(*shape, order=order))

    def transpose(self, *axes):
        return self.view_of(self.ids.transpose(*axes))

    def astype(self, dtype, order: Any = "K", casting="unsafe", subok=True, copy=True):
        kind: Any = kind_of(dtype)
        if kind == self.kind:
            same = not copy and np.array(self.ids, order=order, copy=None) is self.ids
            return self if same else self.copy(order)
        if casting != "unsafe" or kind not in "bifc":
            refuse(f"a conversion to {dtype} in this way")
        if kind == "b" and self.kind != "c":
            found: Any = self != 0
        else:
            found = Columns(self.table, of_kind(self.table, self.ids, self.kind, kind), kind=kind)
        return found if order == "K" else found.copy(order)

    def view(self, dtype=None):
        """A complex array as alternating real and imaginary parts, or the reverse; a view."""
        kind: Any = None if dtype is None else kind_of(dtype)
        if {kind, self.kind} != {"f", "c"}:
            refuse("a view of a long array in this way")
        ids = self.ids.view(PAIR if kind == "c" else ID)
        return Columns(self.table, ids, None, self._written, kind)


for _name in (
    "sum mean max min std var prod any all dot clip round ptp cumsum trace ravel squeeze swapaxes "
    "take repeat diagonal conj conjugate"
).split():
    setattr(Columns, _name, by_function(_name))


def joint(real: Any, imag: Any) -> Any:
    """A complex value from its real and imaginary part: long arrays, or numbers."""
    if not isinstance(real, Columns):
        return Pair(real, imag)
    whole = real.whole(), imag.whole()
    if None not in whole:
        return Columns(real.table, None, whole)
    return Columns(real.table, paired(real.ids, imag.ids), kind="c")


def ids_of(table, value, kind=None) -> Any:
    """The node numbers of an array-like, in the array's shape, converted to a kind of numbers."""
    found, its = ids_and_kind(table, value)
    return found if kind is None else of_kind(table, found, its, kind)


def of_kind(table, ids, before, kind):
    """Convert node numbers of numbers of the kind `before` to another kind of numbers."""
    if (before, kind) in ((kind, kind), ("i", "f")):
        return ids
    if before == "c":
        refuse("complex numbers are stored in an array of real ones")
    if (before, kind) == ("f", "i"):
        why = "a number is stored in an array of whole numbers, which cuts its fraction off"
        refuse(why, typed=True)
    if kind == "c":
        return paired(of_kind(table, ids, before, "f"), table.one(table.g.const(0.0)))
    if not np.size(ids):
        return ids
    given: Any = Columns(table, np.atleast_1d(np.asarray(ids, ID)), kind=before)
    chosen: Any = given != 0 if kind == "b" else np.where(given, 1.0, 0.0)
    return chosen.ids.reshape(np.shape(ids))


def ids_and_kind(table, value: Any) -> Any:
    if isinstance(value, Columns):
        return value.ids, value.kind
    if is_complex(value):
        return paired(*(ids_of(table, part) for part in parts(value))), "c"
    if isinstance(value, Symbol | Condition):
        return np.array(table.one(value.node), ID), kind_of_number(value)
    if isinstance(value, bool | np.bool_ | int | float | np.integer | np.floating):
        return np.array(table.one(table.g.const(value)), ID), kind_of_number(value)
    if isinstance(value, list | tuple):
        found = [ids_and_kind(table, v) for v in value]
        if len({np.shape(ids) for ids, _ in found}) > 1:
            raise ValueError("setting an array element with a sequence")
        return joined(table, np.array, found)
    return table.of_array(value)


def joined(table, function, found, *args, **kwargs):
    """Join the arrays `found`, pairs of (node numbers, kind), by a function such as np.concatenate.

    Returns the node numbers of the joined array, and the common kind.
    """
    kind = common_kind({kind for _, kind in found})
    arrays = [of_kind(table, ids, its, kind) for ids, its in found]
    if kind != "c":
        return np.asarray(function(arrays, *args, **kwargs), ID), kind
    both = ([np.asarray(ids)[name] for ids in arrays] for name in PARTS)
    return paired(*(function(part, *args, **kwargs) for part in both)), kind
