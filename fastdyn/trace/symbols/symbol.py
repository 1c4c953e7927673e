"""The class of all numbers and arrays that depend on the state or on parameters."""

import functools
import threading
from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np

from ..graph.refusal import Refusal
from ..graph.rows import ID, PAIR

DTYPES = {kind: np.dtype(of) for kind, of in zip("bifc", (bool, int, float, complex), strict=True)}
PYTHON = dict(zip("bifc", (bool, int, float, complex), strict=True))
NUMPY: Any = dict(zip("bifc", (np.bool_, np.int64, np.float64, np.complex128), strict=True))
MAX_INDEX = 8  # a symbol as a plain index gets paths for 0, ..., MAX_INDEX - 1 and -1
STATE, AN_ARRAY = "the state that it is given", "an array"  # if a function changes them
HANDLERS: dict[str, Callable] = {}  # NumPy's calls and operators, registered by other files


class _Now(threading.local):
    """The graph of the run in this thread; None outside a run."""

    g: Any = None


NOW = _Now()


def refuse(why, **flags) -> NoReturn:
    """Refuse to trace the user's function; `flags` are the keywords of Refusal."""
    raise Refusal(why, **flags)


def of_numpy(method):
    """A property that Python's numbers lack."""

    @functools.wraps(method)
    def read(self):
        if self.py:
            raise AttributeError  # Python then calls `Symbol.__getattr__`, whose message is better
        return method(self)

    return property(read)


def _moved(name: str) -> Any:
    """The method of an array that only moves elements: the ids' own."""

    def method(self, *args, **kwargs):
        if not self.many:
            return getattr(self.view_of(_zero_d(self.ids)), name)(*args, **kwargs)
        return self.view_of(getattr(self.ids, name)(*args, **kwargs))

    return method


class Symbol:
    """A number or an array, real or complex.

    Attributes
    ----------
    g : Rows
        The graph.
    ids : int, (int, int) or ndarray
        The id of a number; two for a complex one.  For an array, an array of ids, or of pairs of
        ids; views of the array share memory as views of NumPy's arrays do.
    kind : str
        NumPy's kind: "b" for truth values, "i" for whole, "f" for real, "c" for complex numbers.
    py : bool
        Whether Python's rules hold: a division by zero then raises.
    """

    __slots__ = ("g", "ids", "kind", "py")
    __array_priority__ = 1000.0

    def __init__(self, g, ids, kind="f", py=False):
        self.g, self.ids, self.kind, self.py = g, ids, kind, py

    # -- what the symbol is

    @property
    def many(self):
        """Whether the symbol is an array."""
        return isinstance(self.ids, np.ndarray)

    @property
    def node(self):
        """The node of a real number."""
        return self.g.node(self.ids)

    @property
    def varies(self):
        """Whether the values depend on t, on y, or on parameters that vary."""
        return any(self.g.varies(part) for part in parts_of(self.ids))

    __class__: Any = property(
        lambda self: np.ndarray if self.many else (PYTHON if self.py else NUMPY)[self.kind]
    )

    @of_numpy
    def shape(self):
        return np.shape(self.ids) if self.many else ()

    @shape.setter
    def shape(self, new):
        self.ids.shape = new

    dtype = of_numpy(lambda self: DTYPES[self.kind])
    ndim = of_numpy(lambda self: len(self.shape))
    size = of_numpy(lambda self: self.ids.size if self.many else 1)
    itemsize = of_numpy(lambda self: self.dtype.itemsize)
    nbytes = of_numpy(lambda self: self.itemsize * self.size)
    flags = of_numpy(lambda self: np.asarray(self.ids).flags)
    T = of_numpy(lambda self: self.transpose() if self.many else self)

    def view_of(self, ids):
        """A symbol of the same kind with other ids; views of ids stay views."""
        return wrap(self.g, ids, self.kind)

    def part(self, i):
        """The real (0) or imaginary part (1); a view for arrays."""
        if self.kind != "c":
            return self if i == 0 else constant(self.g, 0.0, self.ids, self.py)
        return wrap(
            self.g, self.ids[("real", "imag")[i]] if self.many else self.ids[i], "f", self.py
        )

    def _set_part(self, i, value):
        if not self.many or (i and self.kind != "c"):
            raise TypeError("array does not have imaginary part to set")
        self.part(i)[...] = value

    real = property(lambda self: self.part(0), lambda self, new: self._set_part(0, new))
    imag = property(lambda self: self.part(1), lambda self, new: self._set_part(1, new))

    # -- as a plain number: if parameters determine the value, the code assumes the value

    def plain(self) -> Any:
        """The value as a plain number, or plain array, on which the code then relies."""
        if self.varies:
            refuse("a value that depends on t or y is needed as a plain number")
        if self.many:
            flat = [self.view_of(v).plain() for v in self.ids.ravel()]
            return np.array(flat, DTYPES[self.kind]).reshape(self.ids.shape)
        if self.kind == "c":
            return complex(*(self.part(i).plain() for i in (0, 1)))
        node = self.node
        self.g.assume(node)
        return PYTHON[self.kind](node.value)

    def single(self):
        """The element of an array of one element; a number stays."""
        if not self.many:
            return self
        if self.ids.size != 1:
            raise TypeError("only length-1 arrays can be converted to Python scalars")
        return self.view_of(self.ids.reshape(-1)[0])

    def __float__(self):
        return float(self.single().plain())

    def __int__(self):
        return int(self.single().plain())

    def __complex__(self):
        return complex(self.single().plain())

    def __hash__(self):
        if self.many:
            raise TypeError("unhashable type: 'numpy.ndarray'")
        return hash(self.plain())

    def __index__(self):
        if self.many:
            if self.ids.size != 1 or self.ids.ndim:
                raise TypeError("only integer scalar arrays can be converted to a scalar index")
            return self.single().__index__()
        if self.kind != "i" and not (self.kind == "b" and self.py):
            raise TypeError("'float' object cannot be interpreted as an integer")
        if not self.varies:
            return int(self.plain())
        for value in (*range(MAX_INDEX), -1):  # one path for each value
            if self == value:
                return value
        return self.g.abandon("a whole number that depends on t or y is needed as a plain one")

    def __bool__(self):
        if self.many:
            if self.ids.size != 1:
                raise ValueError(
                    "The truth value of an array with more than one element is ambiguous. "
                    "Use a.any() or a.all()"
                )
            return bool(self.single())
        truth = self if self.kind == "b" else self != 0
        if not isinstance(truth, Symbol):
            return bool(truth)
        node = truth.node
        if not node.varies:
            self.g.assume(node)
            return bool(node.value)
        return self.g.decide(node)

    def __repr__(self):
        return repr(self.plain()) if not self.varies and not self.many else self.g.as_text()

    def __format__(self, spec):
        if not self.varies and not self.many:
            return format(self.plain(), spec)
        return self.g.as_text()

    def __iter__(self):
        if not self.many or not self.ids.ndim:
            raise TypeError(f"'{self._name}' object is not iterable")
        return (self[i] for i in range(len(self)))

    def __len__(self):
        if not self.many or not self.ids.ndim:
            raise TypeError(f"object of type '{self._name}' has no len()")
        return len(self.ids)

    _name = property(lambda self: self.__class__.__name__)

    def __contains__(self: Any, value):
        return bool((self == value).any())

    def is_integer(self: Any):
        return (self == np.floor(self)) & (abs(self) < np.inf)

    # -- elements

    def __getitem__(self, key):
        if not self.many:
            if self.py:
                raise TypeError(f"'{self._name}' object is not subscriptable")
            return self.view_of(_zero_d(self.ids))[key]
        if not is_plain(key):
            return HANDLERS["item"](self, key)
        return self.view_of(self.ids[key])

    def __setitem__(self, key, value):
        if not self.many:
            raise TypeError(f"'{self._name}' object does not support item assignment")
        if not is_plain(key):
            return HANDLERS["store"](self, key, value)
        self.put(key, HANDLERS["cast"](self.g, value, self.kind, "unsafe"))

    def put(self, key, ids):
        """Store ids in the array; a store to an array from outside ends with a refusal."""
        if not self.ids.flags.writeable:
            self.g.unlock(self.ids)
        self.ids[key] = ids

    def item(self, *at):
        if not self.many:
            return wrap(self.g, self.ids, self.kind, True)
        if not at and self.ids.size != 1:
            raise ValueError("can only convert an array of size 1 to a Python scalar")
        return wrap(self.g, self.ids.item(*at), self.kind, True)

    def tolist(self):
        if not self.many or not self.ids.ndim:
            return self.item()
        return [self[i].tolist() for i in range(len(self))]

    flat = property(
        lambda self: HANDLERS["flat"](self), lambda *_: refuse("it writes to `flat` of an array")
    )

    def fill(self, value):
        self[...] = value

    # -- conversions that keep the elements

    def copy(self, order: Any = "C"):
        return self.view_of(self.ids.copy(order)) if self.many else self

    reshape, transpose, ravel, flatten = map(_moved, ("reshape", "transpose", "ravel", "flatten"))
    squeeze, swapaxes, diagonal = map(_moved, ("squeeze", "swapaxes", "diagonal"))
    take, repeat, resize = map(_moved, ("take", "repeat", "resize"))

    def astype(self, dtype, order: Any = "K", casting="unsafe", subok=True, copy=True):
        kind = kind_of(dtype)
        if not self.many:
            return wrap(self.g, HANDLERS["cast"](self.g, self, kind, casting), kind)
        if kind == self.kind:
            same = not copy and np.array(self.ids, order=order, copy=None) is self.ids
            return self if same else self.copy(order)
        ids = HANDLERS["cast"](self.g, self, kind, casting)
        moved = np.empty_like(self.ids, ids.dtype, order)
        moved[...] = ids
        return wrap(self.g, moved, kind)

    def view(self, dtype=None, *_):
        """The array itself, or a complex array as alternating real and imaginary parts."""
        kind = self.kind if dtype is None or dtype is np.ndarray else kind_of(dtype)
        if kind == self.kind:
            return self.view_of(self.ids.view())
        if {kind, self.kind} != {"f", "c"}:
            refuse("a view of an array in this way")
        return wrap(self.g, self.ids.view(PAIR if kind == "c" else ID), kind)

    def __copy__(self):
        return self.copy()

    def __deepcopy__(self, memo):
        return self.copy()

    # -- protocols

    def __array_ufunc__(self, ufunc, method, *args, **kwargs) -> Any:
        return HANDLERS["ufunc"](ufunc, method, args, kwargs)

    def __array_function__(self, function, types, args, kwargs) -> Any:
        return HANDLERS["function"](function, args, kwargs)

    def __array__(self, *_, **__):
        refuse("an array of the state is made one of plain numbers")

    def __reduce__(self):
        refuse("a value that depends on the state is pickled")

    def __getattr__(self, name):
        like = np.ndarray if self.many else (PYTHON if self.py else NUMPY)[self.kind]
        if name.startswith("__") or not hasattr(like, name):
            raise AttributeError(f"'{self._name}' object has no attribute '{name}'")
        return refuse(f"`{name}` of what depends on the state")


def _zero_d(ids):
    return np.array(ids, PAIR if isinstance(ids, tuple) else ID)


def parts_of(ids):
    """The parts of ids that are real: (ids,), or the ids of real and imaginary parts."""
    if isinstance(ids, tuple):
        return ids
    if isinstance(ids, np.ndarray) and ids.dtype == PAIR:
        return ids["real"], ids["imag"]
    return (ids,)


def wrap(g, ids, kind="f", py=False) -> Any:
    """The Symbol of ids that NumPy handed out."""
    if isinstance(ids, np.ndarray):
        return Symbol(g, ids, kind)
    if kind == "c":
        return Symbol(g, (int(ids[0]), int(ids[1])), "c", py)
    return Symbol(g, int(ids), kind, py)


def constant(g, value, like: Any = 0, py=False) -> Any:
    """A constant symbol, with the shape of the ids `like`."""
    i = g.const(value).key
    if isinstance(like, np.ndarray):
        return Symbol(g, np.full_like(like, i, ID))
    return Symbol(g, i, "f", py)


def kind_of(dtype):
    """NumPy's kind letter of a dtype, or of a stand-in for a type."""
    dtype = np.dtype(getattr(dtype, "plain", dtype))
    if dtype.kind in "iufc" and dtype not in (np.int64, float, complex):
        refuse(f"a conversion to {dtype}")  # such a conversion rounds or wraps around
    if dtype.kind not in "bifc":
        refuse(f"a conversion to {dtype}")
    return dtype.kind


def is_plain(key):
    """Whether an index key has no symbols."""
    if isinstance(key, tuple):
        return all(map(is_plain, key))
    if isinstance(key, slice):
        return not any(type(v) is Symbol for v in (key.start, key.stop, key.step))
    if isinstance(key, list):
        return not is_symbolic(key)
    return type(key) is not Symbol


def is_symbolic(value):
    """Whether a value is a symbol, or contains one."""
    return graph_of(value) is not None


def graph_of(*values) -> Any:
    """The graph of the first symbol among `values`; None if there is none."""
    for value in values:
        kind = type(value)
        if kind is Symbol:
            return value.g
        if kind in (list, tuple) or isinstance(value, list | tuple):
            found = graph_of(*value)
            if found is not None:
                return found
        elif hasattr(kind, "mask_of_state"):
            return value.whole.g
    return None
