"""Stand-ins of pandas tables: numbers become parameters, labels constants of the code."""

from typing import Any

from ..reads.steps import labels_of
from ..symbols.symbolic import Symbolic, is_symbolic, refuse


def copy_of(outside, value, kind, row):
    """The stand-in of a Series or DataFrame; None for any other value."""
    stand_in = {"Series": Series, "DataFrame": Frame}.get(kind.__name__)
    if stand_in is None or not kind.__module__.startswith("pandas"):
        return None
    reads = outside.reads
    reads.expect(row, "type", kind)
    for which in stand_in.labels:
        if not getattr(value, which).is_unique:
            refuse("a table of pandas whose labels are not unique", final=True)
        reads.expect(reads.step(row, "labels", which), "equal", labels_of(value, which))
    return outside.keep(value, stand_in(outside, value, row))


class Labels:
    """The indexer `loc`, `at`, `iloc` or `iat` of a table."""

    def __init__(self, find):
        self._find = find

    def __getitem__(self, key) -> Any:
        return self._find(key)

    def __setitem__(self, key, value):
        refuse("it changes a table of pandas", effect=True)


class OfPandas:
    """The common part of Series and Frame.

    `labels` names the attributes that hold labels of the table.  `named` is the attribute whose
    labels are also attributes of the table.  ``_by_label(key)`` and ``_by_place(i)`` return parts
    of the table.
    """

    of_pandas = True
    labels: tuple = ("index",)
    named: str
    _by_label: Any
    _by_place: Any
    __getitem__: Any
    values: Any = property(lambda self: self._part("numbers of"))
    loc = at = property(lambda self: Labels(self._by_label))
    iloc = iat = property(lambda self: Labels(self._by_place))

    def __init__(self, outside, value, row):
        self._outside, self._value, self._row, self._parts = outside, value, row, {}

    def _part(self, step, key=None):
        """The copy of a part of the table; each part is copied once."""
        if (step, key) not in self._parts:
            self._parts[step, key] = self._outside.part(self._value, self._row, step, key)
        return self._parts[step, key]

    def __len__(self):
        return len(self._value)

    def __getattr__(self, name):
        names = () if name.startswith("_") else getattr(self._value, self.named)
        if name not in names or hasattr(type(self._value), name):
            refuse(f"`{name}` of a {type(self._value).__name__} of pandas", final=True)
        return self[name]

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

    named = "index"

    def _by_place(self, i):
        """The element at place i."""
        if self._value.dtype.kind in "fiub":
            return self.values[i]
        if is_symbolic(i):
            refuse("a Series of other things than numbers, at an index that depends on the state")
        return self._part("place", int(i))

    def _by_label(self, key):
        if isinstance(key, Symbolic) or isinstance(key, slice | list):
            refuse("a Series by labels that depend on the state, or by many")
        return self._by_place(self._value.index.get_loc(key))

    __getitem__ = _by_label

    def to_numpy(self):
        return self.values.copy()

    def get(self, key, default=None):
        return self._by_label(key) if key in self._value.index else default


class Frame(OfPandas):
    """The stand-in of a pandas DataFrame."""

    labels, named = ("index", "columns"), "columns"

    def _column(self, name):
        return self._part("column", name)

    def __getitem__(self, name):
        if isinstance(name, str | int) and name in self._value.columns:
            return self._column(name)
        return refuse("a DataFrame by anything but the name of a column", final=True)

    def _by_label(self, key):
        if isinstance(key, tuple):
            return self._column(key[1]).loc[key[0]]
        if is_symbolic(key) or isinstance(key, slice | list):
            refuse("a DataFrame by labels that depend on the state, or by many")
        return self._part("line", key)

    def _by_place(self, key):
        if isinstance(key, tuple):
            return self._column(self._value.columns[key[1]]).iloc[key[0]]
        if is_symbolic(key):
            return Line(self, key)
        if isinstance(key, slice | list):
            refuse("several lines of a DataFrame")
        return self._part("place", int(key))


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
