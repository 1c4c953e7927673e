"""Stand-ins of SciPy's objects: interpolators by their pieces, and sparse matrices.

Other objects, such as distributions and linear systems, have attributes, and methods of constants.
"""

import copy
import functools
from typing import Any

import numpy as np

from ..graph.rows import ID
from ..reads.reads import STABLE
from ..symbols.lift import joint, symbol
from ..symbols.symbol import NOW, Symbol, is_symbolic, refuse
from .algebra import _sum_of_products
from .arrays import array_of, fresh
from .interpolators import form_of, n_places
from .rotation import Rotations

METHODS = frozenset(  # methods whose value depends on the object and the arguments only
    "__call__ solve ev integral pdf logpdf cdf logcdf sf logsf ppf isf pmf logpmf mean var std "
    "median moment evaluate matvec derivative antiderivative partial_derivative integrate roots "
    "derivatives".split()
)
NUMBERS = bool | int | float | complex | str | np.generic | None
PACKAGES = (
    "builtins.SuperLU",
    *[f"scipy.{name}" for name in "interpolate stats sparse signal".split()],
)


def is_object(value):
    """Whether a value is an object of SciPy; the type of LU factors names no module of SciPy."""
    module = type(value).__module__ or ""
    name = type(value).__name__
    if not module.startswith("scipy.") and name != "SuperLU":
        return False  # a user's object may answer for any attribute
    return not isinstance(value, tuple | dict | type) and not hasattr(value, "__code__")


def wrapped(value) -> Any:
    """The result of a call of a library with plain values, with stand-ins for its objects."""
    return _stand_in(value) if is_object(value) else fresh(value)


def _stand_in(value, *of_outside):
    if type(value).__name__ == "Rotation" and value.single:
        return Rotations().from_quat(value.as_quat())
    if not f"{type(value).__module__}.{type(value).__name__}".startswith(PACKAGES):
        refuse(f"it uses an object of type {type(value).__name__}", final=True)
    return (Sparse if hasattr(value, "tocsr") else Object)(value, *of_outside)


def plain_of(value) -> Any:
    """The original of a value without symbols that depend on the state."""
    if isinstance(value, Object):
        return value._whole()
    if isinstance(value, list | tuple):
        return type(value)([plain_of(v) for v in value])
    if type(value) is dict:
        return {name: plain_of(v) for name, v in value.items()}
    return value.plain() if type(value) is Symbol else value


def attributes_of(value):
    """{name: content} of the attributes that hold numbers, arrays, or objects that hold them."""
    slots = [name for base in type(value).__mro__ for name in vars(base).get("__slots__", ())]
    found = {name: getattr(value, name, None) for name in slots} | getattr(value, "__dict__", {})
    return {name: part for name, part in found.items() if _holds_numbers(part)}


def _holds_numbers(part):
    if isinstance(part, tuple):
        return all(map(_holds_numbers, part))
    return isinstance(part, NUMBERS | np.ndarray) or type(part) is dict or is_object(part)


def expect_content(reads, value, row):
    """Let later calls check that an object has the current content."""
    for name, part in attributes_of(value).items():
        _expect(reads, part, reads.step(row, "attribute", name))


def _expect(reads, part, where):
    itself = reads.step(where, "itself")  # the row `where` may hold parameters
    if isinstance(part, np.ndarray) and part.dtype != object:
        reads.expect_elements(itself, part)
    elif isinstance(part, np.ndarray):
        reads.lasting = False
    elif isinstance(part, tuple):
        reads.expect(itself, "length", (type(part), len(part)))
        for i, each in enumerate(part):
            _expect(reads, each, reads.step(where, "item", i))
    elif is_object(part):
        reads.expect(itself, "same", part)
        expect_content(reads, part, where)
    else:
        reads.expect(itself, "equal" if part == part else "same", copy.copy(part))


class Object:
    """The stand-in of an object of SciPy; attributes are copied from `outside` on first use."""

    _value: Any
    _outside: Any
    _row: Any

    def __init__(self, value, outside=None, row=STABLE):
        vars(self).update(_value=value, _outside=outside, _row=row)

    def __call__(self, *args, **kwargs):
        return self._called("__call__", args, kwargs)

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        if name in METHODS:
            getattr(self._value, name)  # raises AttributeError
            return functools.partial(self._by_name, name)
        if not {name, f"_{name}"} & attributes_of(self._value).keys():
            refuse(f"it uses `{name}` of an object of type {type(self._value).__name__}")
        if self._outside is None:
            return wrapped(getattr(self._value, name))
        return self._outside.part(self._value, self._row, "attribute", name)

    def __setattr__(self, name, value):
        refuse("it changes an attribute of an object", effect=True)

    def _by_name(self, name, *args, **kwargs):
        return self._called(name, args, kwargs)

    def _whole(self):
        """The object, on whose content the code then relies."""
        if self._outside is not None:
            expect_content(self._outside.reads, self._value, self._row)
        return self._value

    def _called(self, name, args, kwargs):
        n = n_places(self._value, name)
        places = args[:n]
        options = (args[n:], kwargs)
        symbolic = len(places) == n and is_symbolic(places)
        if symbolic and not any(map(_varies, [*options[0], *kwargs.values()])):
            known = NOW.g.kept
            key = ("form", id(self._value), name, repr(plain_of(options)))
            if key not in known:  # the object is kept, so that its id stays unique
                more, named = plain_of(options)
                known[key] = form_of(self._value, name, *more, **named), self._value
            if known[key][0]:
                self._whole()
                return known[key][0](*places)
        if any(map(_varies, [*args, *kwargs.values()])):
            refuse(f"it uses an object of type {type(self._value).__name__}", final=True)
        return wrapped(getattr(self._whole(), name)(*plain_of(args), **plain_of(kwargs)))


def _varies(value):
    if isinstance(value, list | tuple):
        return any(map(_varies, value))
    return type(value) is Symbol and value.varies


class Sparse(Object):
    """The stand-in of a sparse matrix, times a factor.

    The numbers of a matrix of rows are parameters; its pattern is part of the code.  In all but
    products with vectors and matrices, the numbers are part of the code, too.
    """

    __array_ufunc__ = None  # NumPy's numbers and arrays leave products to the matrix
    _factor: Any = None  # for 1
    _numbers: Any = None

    def __getattr__(self, name) -> Any:
        if name.startswith("__") or not hasattr(self._value, name):
            raise AttributeError(name)
        if name in ("shape", "nnz", "ndim", "format"):
            return getattr(super()._whole(), name)
        part = getattr(self._whole(), name)
        return functools.partial(self._by_name, name) if callable(part) else wrapped(part)

    def _whole(self):
        value = super()._whole()
        return value if self._factor is None else value * plain_of(self._factor)

    def _called(self, name, args, kwargs):
        return wrapped(getattr(self._whole(), name)(*plain_of(args), **plain_of(kwargs)))

    def _times(self, factor):
        new = Sparse(self._value, self._outside, self._row)
        product = factor if self._factor is None else factor * self._factor
        vars(new).update(vars(self), _factor=product)
        return new

    def multiplied(self, y):
        """The product with a vector or a matrix."""
        if isinstance(y, Sparse):
            return self._called("__matmul__", (y,), {})
        y = array_of(y)
        if self.shape[1] != y.ids.shape[0]:
            raise ValueError(f"shapes {self.shape} and {y.ids.shape} do not match in a product")
        columns = [y] if y.ids.ndim == 1 else [y[:, j] for j in range(y.ids.shape[1])]
        found = [_product(self._rows(), column) for column in columns]
        whole = found[0] if y.ids.ndim == 1 else np.stack(found, axis=1)
        return whole if self._factor is None else self._factor * whole

    def _rows(self):
        """(numbers, columns, beginning of each row) of the matrix."""
        if self._numbers is None:
            value = self._value
            outside = self._outside
            if outside is not None and value.format == "csr" and value.data.dtype == float:
                data = outside.part(value, self._row, "member", "data")
                for name in ("indices", "indptr", "shape"):
                    _expect(outside.reads, getattr(value, name),
                            outside.reads.step(self._row, "member", name))  # fmt: skip
            else:
                super()._whole()
                value = value.tocsr()
                data = symbol(NOW.g, value.data if value.dtype.kind == "c" else value.data + 0.0)
            vars(self)["_numbers"] = data, value.indices.copy(), value.indptr.copy()
        return self._numbers

    def __matmul__(self, other):
        if np.ndim(other) or isinstance(other, Sparse):
            return self.multiplied(other)
        raise ValueError("Scalar operands are not allowed, use '*' instead")

    dot = __matmul__

    def __rmatmul__(self, other):
        return self._called("transpose", (), {}).multiplied(np.transpose(other)).T

    def __mul__(self, other):
        if not isinstance(other, Sparse) and not np.ndim(other):
            return self._times(other)
        if not hasattr(self._value, "getrow"):  # the newer type: products of elements
            refuse("a sparse array times an array, element by element")
        return self.multiplied(other)

    __rmul__ = _times

    def __truediv__(self, other):
        return self._times(1.0 / other)

    def __neg__(self):
        return self._times(-1.0)

    def __add__(self, other):
        return self._called("__add__", (other,), {})

    def __sub__(self, other):
        return self._called("__sub__", (other,), {})

    def __getitem__(self, key):
        return self._called("__getitem__", (key,), {})


def _product(rows, y):
    """A sparse matrix of rows times a vector: one row of a graph with rows, if it is long."""
    data, columns, begins = rows
    g: Any = data.g
    if data.kind == "c":
        return _product((data.part(0), *rows[1:]), y) + 1j * _product((data.part(1), *rows[1:]), y)
    if y.kind == "c":
        return joint(*[_product(rows, y.part(i)) for i in (0, 1)])
    y = y + 0.0 if y.kind in "bi" else y
    if len(columns) <= g.few:
        parts = zip(
            np.split(data.ids, begins[1:-1]), np.split(y.ids[columns], begins[1:-1]), strict=True
        )
        found = [_sum_of_products(g, a.tolist(), b.tolist()) for a, b in parts]
        return Symbol(g, np.array(found, ID))
    slots = [
        *[g.reads.held(part.astype(float)) for part in (begins, columns)],
        _slots(g, data.ids),
    ]
    n = len(begins) - 1
    vector = np.ascontiguousarray(y.ids).copy()
    return Symbol(g, g.ids(g.row("csr", (n,), (vector,), ("csr", n, *slots))))


def _slots(g, ids):
    """The slots of an array of parameters, or of constants, which are stored beside the code."""
    known = g.known(ids)
    first = g.row_of(int(ids[0])) if known is None else None
    if first is None:
        return g.reads.held(np.ascontiguousarray(known, float))
    begin = first.data.start + int(ids[0]) - first.first
    return range(begin, begin + ids.size)


def _value_at(series, x):
    """The value of a polynomial of numpy.polynomial, whose own `__call__` makes a plain array."""
    offset, scale = series.mapparms()
    return series._val(offset + scale * array_of(x)[()], series.coef)


def object_of(outside, value, row):
    """The stand-in of an object of SciPy, or of a series, from outside; None for another value."""
    kind = type(value)
    if kind.__module__.startswith("numpy.polynomial") and hasattr(value, "mapparms"):
        outside.reads.expect(row, "same", value)
        expect_content(outside.reads, value, row)
        copied = copy.deepcopy(value)
        copied.__class__ = type(kind.__name__, (kind,), {"__call__": _value_at})
        for part in (copied.coef, copied.domain, copied.window):
            outside.watch("an array", part)
        return outside.keep(value, copied, "an attribute", dict(vars(copied)))
    if not is_object(value):
        return None
    outside.reads.expect(row, "same", value)
    return outside.keep(value, _stand_in(value, outside, row))
