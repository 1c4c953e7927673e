"""The base classes of all symbolic objects; NumPy passes calls to these objects."""

import threading
from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np

from ..graph.expressions import MAX_NODES
from ..graph.refusal import Refusal

_handlers: dict[str, Callable] = {}


def hand_over(ufunc, function):
    """Register the functions that handle NumPy's calls on symbols; `numpy.calls` calls this.

    Parameters
    ----------
    ufunc : callable
        ``ufunc(ufunc, method, args, kwargs)``, as NumPy's `__array_ufunc__`.
    function : callable
        ``function(function, args, kwargs)``, as NumPy's `__array_function__`.
    """
    _handlers.update(ufunc=ufunc, function=function)


def refuse(why, **flags) -> NoReturn:
    """Refuse to trace the user's function; `flags` are the keywords of Refusal."""
    raise Refusal(why, **flags)


def check_operations(count):
    """Refuse an operation of `count` nodes, if so many do not fit into a graph."""
    if count > MAX_NODES:
        refuse("it takes too many operations", final=True, said=False)


class AnswersNumPy:
    """An object that receives NumPy's calls."""

    __slots__ = ()

    def __array_ufunc__(self, ufunc, method, *args, **kwargs) -> Any:
        return _handlers["ufunc"](ufunc, method, args, kwargs)

    def __array_function__(self, function, types, args, kwargs) -> Any:
        return _handlers["function"](function, args, kwargs)


class Symbolic(AnswersNumPy):
    """A number or a truth value that depends on t, y or the parameters."""

    __slots__ = ()
    g: Any  # the graph
    shape, ndim, size, dtype = (), 0, 1, np.dtype(object)
    __hash__: Any = object.__hash__

    def number(self) -> Any:
        """The value as a real number; None if the value is no real number."""
        return None

    def item(self):
        return self

    squeeze = copy = flatten = ravel = item

    def __copy__(self):
        return self

    def __deepcopy__(self, memo):
        return self

    def __repr__(self):
        return self.g.as_text()

    def __format__(self, spec):
        return self.g.as_text()

    def __reduce__(self) -> NoReturn:
        refuse("a value that depends on the state is pickled")


class Batched(np.lib.mixins.NDArrayOperatorsMixin):
    """A long array that depends on the state, in batches: see `trace.batches`.

    The class has the methods of an ndarray that `copy`, `ravel` and indexing suffice for.
    """

    __slots__ = ()
    __array_priority__ = 1000.0
    __hash__: Any = None
    __class__: Any = property(lambda self: np.ndarray)  # for isinstance(_, np.ndarray)
    T: Any = property(lambda self: self.transpose())
    flat: Any = property(lambda self: Flat(self), lambda *_: refuse("it writes to `flat`"))
    _called: str  # in messages
    copy: Callable
    ravel: Callable
    transpose: Callable
    __len__: Callable
    __getitem__: Callable
    __setitem__: Callable
    g: Any
    table: Any
    truth: Any
    dtype: Any
    ids: Any  # node numbers

    def __array_ufunc__(self, ufunc, method, *args, **kwargs) -> Any:
        return BATCHES["ufunc"](ufunc, method, args, kwargs)

    def __array_function__(self, function, types, args, kwargs) -> Any:
        return BATCHES["function"](function, args, kwargs)

    def __iter__(self):
        return (self[i] for i in range(len(self)))

    def __copy__(self):
        return self.copy()

    def __deepcopy__(self, memo):
        return self.copy()

    def flatten(self, order="C"):
        return self.ravel(order).copy()

    def fill(self, value):
        self[...] = value

    def __array__(self, *_, **__):
        refuse("an array of the state is made one of plain numbers")

    def __reduce__(self):
        refuse("an array that depends on the state is pickled")

    def __repr__(self):
        return self.g.as_text()

    def __format__(self, spec):
        return self.g.as_text()

    def __getattr__(self, name):
        if name.startswith("__") or not hasattr(np.ndarray, name):
            raise AttributeError(f"'numpy.ndarray' object has no attribute '{name}'")
        refuse(f"`{name}` of a {self._called} that depends on the state")


class Flat:
    """The elements of a long array, to be iterated over."""

    def __init__(self, array):
        self._array = array

    def __iter__(self):
        return iter(self._array.ravel())

    def _refused(self, *_) -> Any:
        refuse("`flat` of an array that depends on the state")

    __getitem__ = __setitem__ = __len__ = __array__ = __getattr__ = _refused


SHORT = 16  # arrays up to this length are traced element by element
BATCHES: dict[str, Callable] = {}  # functions that handle calls on long arrays


class _Now(threading.local):
    """The batch Table of the current trace, if it has one."""

    table: Any = None


NOW = _Now()


def in_batches(values):
    """Whether `trace.batches` handles a call with these arguments."""
    if NOW.table is None:
        return False
    if any(isinstance(v, Batched | Lazy) for v in values):
        return True
    return any(map(_is_long, values)) and any(map(is_symbolic, values))


def _is_long(value):
    if isinstance(value, np.ndarray):
        return value.ndim > 0 and value.size > SHORT
    return isinstance(value, list | tuple) and (
        len(value) > SHORT or any(isinstance(v, Batched) for v in value)
    )


class Unwritten:
    """The base of stand-ins of outside objects; refuses writes, because they would be lost."""

    def _written(self, *_) -> NoReturn:
        refuse("it changes an object", effect=True)

    __setattr__ = __delattr__ = __setitem__ = __delitem__ = _written
    __iadd__ = __isub__ = __imul__ = __itruediv__ = _written


class Lazy:
    """A long array, list or tuple whose elements are made on first use."""

    __slots__ = ()
    graph: Any = None  # the graph; None if all elements are made

    def filled(self) -> Any:
        """The array, list or tuple with all elements made."""
        raise NotImplementedError


def is_symbolic(value):
    """Whether a value is symbolic, or contains a symbolic value."""
    if isinstance(value, Symbolic | Batched):
        return True
    if isinstance(value, Lazy) and value.graph is not None:
        return True
    if isinstance(value, np.ndarray):
        return value.dtype == object and any(isinstance(v, Symbolic) for v in value.flat)
    return isinstance(value, list | tuple) and any(map(is_symbolic, value))


def graph_of(*values) -> Any:
    """The graph of the first symbolic value among `values`; None if there is none."""
    for value in values:
        if isinstance(value, Symbolic | Batched):
            if value.g is not None:
                return value.g
        elif isinstance(value, Lazy) and value.graph is not None:
            return value.graph
        elif isinstance(value, np.ndarray):
            if value.dtype == object:
                for v in value.flat:
                    if isinstance(v, Symbolic) and v.g is not None:
                        return v.g
        elif isinstance(value, list | tuple):
            found = graph_of(*value)
            if found is not None:
                return found
    return None


def kind_of(dtype):
    """NumPy's kind letter of a dtype, or of a stand-in for a type."""
    dtype = np.dtype(getattr(dtype, "plain", dtype))
    if dtype.kind in "iuf" and dtype not in (np.int64, float):
        refuse(f"a conversion to {dtype}")  # such a conversion rounds or wraps around
    return dtype.kind
