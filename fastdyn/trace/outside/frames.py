"""pandas tables: their numbers are parameters, their labels constants of the code."""

from typing import Any

from ..reads.of_pandas import labels_of
from ..symbols.symbolic import Symbolic, is_symbolic, refuse

KINDS = "Series", "DataFrame"


def copy_of(outside, value, kind, row):
    """The stand-in of a Series or DataFrame; None for any other value."""
    name = kind.__name__
    if name not in KINDS or not kind.__module__.startswith("pandas"):
        return None
    reads = outside.reads
    reads.expect(row, "type", kind)
    _expect_labels(reads, value, "index", row)
    if name == "DataFrame":
        _expect_labels(reads, value, "columns", row)
        return outside.keep(value, Frame(outside, value, row))
    return outside.keep(value, Series(outside, value, row))


def _expect_labels(reads, value, which, row):
    labels = reads.step(row, "labels", which)
    if not getattr(value, which).is_unique:
        refuse("a table of pandas whose labels are not unique", final=True)
    reads.expect(labels, "equal", labels_of(value, which))


class Labels:
    """The indexer `loc`, `at`, `iloc` or `iat` of a table."""

    def __init__(self, find):
        self._find = find

    def __getitem__(self, key) -> Any:
        return self._find(key)

    def __setitem__(self, key, value):
        refuse("it changes a table of pandas", effect=True)


class OfPandas:
    """The common part of Series and Frame."""

    of_pandas = True

    def __init__(self, outside, value, row):
        self._outside, self._value, self._row, self._parts = outside, value, row, {}

    def _part(self, step, key=None):
        """The copy of a part of the table; each part is copied once."""
        if (step, key) not in self._parts:
            self._parts[step, key] = self._outside.part(self._value, self._row, step, key)
        return self._parts[step, key]

    def __len__(self):
        return len(self._value)

    def __setitem__(self, key, value):
        refuse("it changes a table of pandas", effect=True)

    def _refused(self, *_, **__) -> Any:
        refuse("arithmetic with a table of pandas", final=True)

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = _refused
    __rtruediv__ = __pow__ = __rpow__ = __neg__ = __abs__ = __matmul__ = __eq__ = _refused
    __lt__ = __le__ = __gt__ = __ge__ = __bool__ = __contains__ = __iter__ = _refused
    __array_ufunc__ = __array_function__ = __array__ = __float__ = __int__ = _refused
    __hash__: Any = object.__hash__


class Series(OfPandas):
    """The stand-in of a pandas Series."""

    def _single(self, i):
        """The element at place i."""
        if self._value.dtype.kind in "fiub":
            return self.values[i]
        if is_symbolic(i):
            refuse("a Series of other things than numbers, at an index that depends on the state")
        return self._part("place", int(i))

    def _by_label(self, key):
        if isinstance(key, Symbolic) or isinstance(key, slice | list):
            refuse("a Series by labels that depend on the state, or by many")
        return self._single(self._value.index.get_loc(key))

    __getitem__ = _by_label
    values = property(lambda self: self._part("numbers of"))
    loc = at = property(lambda self: Labels(self._by_label))
    iloc = iat = property(lambda self: Labels(self._single))

    def to_numpy(self):
        return self.values.copy()

    def get(self, key, default=None):
        return self._by_label(key) if key in self._value.index else default

    def __getattr__(self, name):
        if name.startswith("_") or name not in self._value.index:
            refuse(f"`{name}` of a Series of pandas", final=True)
        if hasattr(type(self._value), name):
            refuse(f"`{name}` of a Series of pandas", final=True)
        return self._by_label(name)


class Frame(OfPandas):
    """The stand-in of a pandas DataFrame."""

    def _column(self, name):
        return self._part("column", name)

    def __getitem__(self, name):
        if isinstance(name, str | int) and name in self._value.columns:
            return self._column(name)
        return refuse("a DataFrame by anything but the name of a column", final=True)

    def _by_labels(self, key):
        if isinstance(key, tuple):
            return self._column(key[1]).loc[key[0]]
        if is_symbolic(key) or isinstance(key, slice | list):
            refuse("a DataFrame by labels that depend on the state, or by many")
        return self._part("line", key)

    def _by_places(self, key):
        if isinstance(key, tuple):
            return self._column(self._value.columns[key[1]]).iloc[key[0]]
        if is_symbolic(key):
            return Line(self, key)
        if isinstance(key, slice | list):
            refuse("several lines of a DataFrame")
        return self._part("place", int(key))

    values = property(lambda self: self._part("numbers of"))
    loc = at = property(lambda self: Labels(self._by_labels))
    iloc = iat = property(lambda self: Labels(self._by_places))

    def __getattr__(self, name):
        if name.startswith("_") or name not in self._value.columns:
            refuse(f"`{name}` of a DataFrame of pandas", final=True)
        if hasattr(type(self._value), name):
            refuse(f"`{name}` of a DataFrame of pandas", final=True)
        return self._column(name)


class Line:
    """A row of a DataFrame at a place that depends on t or the state."""

    def __init__(self, frame, place):
        self._frame, self._place = frame, place

    def __getitem__(self, name):
        return self._frame[name].iloc[self._place]

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        return self._frame[name].iloc[self._place]
