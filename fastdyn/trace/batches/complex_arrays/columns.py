"""Complex arrays of node numbers, as a traced function computes with them."""

import math
from typing import Any

import numpy as np

from ...symbols.complex_pair import Pair, is_complex, parts
from ...symbols.symbolic import BATCHES, Batched, Lazy, kind_of, refuse
from ..columns import Columns, Store, by_function, ids_of
from ..formulas import as_columns, filled
from ..products import whole
from ..table import ID


class ComplexColumns(Batched):
    """A complex array: `real` and `imag` are Columns of one shape, shared by all views."""

    __slots__ = ("imag", "real")
    _called = "long complex array"
    truth = False
    dtype = np.dtype(complex)

    def __init__(self, real, imag):
        self.real, self.imag = real, imag

    table = property(lambda self: self.real.table)
    g = property(lambda self: self.real.table.g)
    shape = property(lambda self: self.real.shape)
    ndim = property(lambda self: self.real.ndim)
    size = property(lambda self: self.real.size)
    nbytes = property(lambda self: 16 * self.size)

    def both(self, function):
        """The complex array of the results of a function for both parts."""
        return joint(function(self.real), function(self.imag))

    def written(self):
        return self.real.written() or self.imag.written()

    def __len__(self):
        return len(self.real)

    def __getitem__(self, key) -> Any:
        if isinstance(key, Batched):
            refuse("a selection of complex numbers by a mask of the state")
        return self.both(lambda part: part[key])

    def __setitem__(self, key, value):
        real, imag = parts_of(self.table, value)
        self.real[key], self.imag[key] = real, imag

    def _as_real(self, *_) -> Any:
        refuse("complex numbers are needed as real ones, or as a truth value")

    __bool__ = __float__ = __int__ = __index__ = __complex__ = __contains__ = _as_real

    def item(self, *at):
        return self.both(lambda part: part.item(*at))

    def tolist(self):
        return [v.tolist() if isinstance(v, ComplexColumns) else v for v in self]

    def copy(self, order="C"):
        return self.both(lambda part: part.copy())

    def conj(self):
        return np.conj(self)

    conjugate = conj

    def astype(self, dtype, *_, **__):
        if kind_of(dtype) != "c":
            refuse(f"a conversion of complex numbers to {dtype}")
        return self.copy()

    def view(self, dtype=None):
        """A view of real and imaginary parts in turn; both arrays refuse stores from now on."""
        if dtype is None or kind_of(dtype) != "f" or not self.ndim:
            refuse("a view of complex numbers in this way")
        for part in (self.real, self.imag):
            part.freeze()
        ids = np.stack([self.real.ids, self.imag.ids], -1)
        made = Columns(self.table, ids.reshape(*self.shape[:-1], -1), None, Store())
        made.freeze()
        return made


def _of_structure(name):
    def method(self, *args, **kwargs):
        return self.both(lambda part: getattr(part, name)(*args, **kwargs))

    return method


for _name in "reshape ravel transpose squeeze swapaxes take repeat diagonal".split():
    setattr(ComplexColumns, _name, _of_structure(_name))
for _name in "sum mean dot cumsum trace".split():
    setattr(ComplexColumns, _name, by_function(_name))


def joint(real: Any, imag: Any) -> Any:
    """A complex value from its real and imaginary part: arrays, numbers, or lists of either."""
    if isinstance(real, list | tuple):
        return type(real)([joint(*pair) for pair in zip(real, imag, strict=True)])
    return ComplexColumns(real, imag) if isinstance(real, Columns) else Pair(real, imag)


def is_of_complexes(value):
    """Whether a value is, or contains, complex numbers."""
    if isinstance(value, ComplexColumns) or is_complex(value):
        return True
    if isinstance(value, Columns | Lazy):
        return False
    if isinstance(value, np.ndarray):
        return value.dtype.kind == "c" or (
            value.dtype == object and any(map(is_complex, value.view(np.ndarray).flat))
        )
    return isinstance(value, list | tuple) and any(map(is_of_complexes, value))


def parts_of(table, value) -> tuple[Any, Any]:
    """Real and imaginary part of anything, arrays as Columns or plain arrays of numbers."""
    if isinstance(value, ComplexColumns):
        return value.real, value.imag
    if not is_of_complexes(value):
        return value, 0.0
    if not isinstance(value, np.ndarray | list | tuple):
        return parts(value)
    if isinstance(value, np.ndarray) and value.dtype != object:
        return np.ascontiguousarray(value.real), np.ascontiguousarray(value.imag)
    if isinstance(value, np.ndarray):
        return _of_objects(table, value.view(np.ndarray))
    found = [parts_of(table, v) for v in value]
    shape = np.broadcast_shapes(*[np.shape(real) for real, _ in found])
    real, imag = ([_spread(table, v, shape) for v in each] for each in zip(*found, strict=True))
    return as_columns(table, real), as_columns(table, imag)


def _spread(table, value, shape):
    return filled(table, shape, value) if shape and not np.ndim(value) else value


def _of_objects(table, value):
    """The parts of an array of objects: of plain numbers, of parameters, or of any numbers."""
    flat = list(map(parts, value.flat))
    real, imag = (_numbers(table, list(part), value.shape) for part in zip(*flat, strict=True))
    is_real = not isinstance(imag, Batched) and not imag.any()
    return real, 0.0 if is_real else imag


def _numbers(table, values, shape):
    """Numbers as an array of a shape."""
    nodes = [getattr(v, "node", None) for v in values]
    if not any(nodes):
        return np.array(values, float).reshape(shape)
    if all(node is not None and node.op == "neg" for node in nodes):
        inner = _of_parameters(table, [node.args[0] for node in nodes if node], shape)
        return Columns(table, ids_of(table, values).reshape(shape)) if inner is None else -inner
    found = _of_parameters(table, nodes, shape)
    return Columns(table, ids_of(table, values).reshape(shape)) if found is None else found


def _of_parameters(table, nodes, shape):
    """The Columns of parameters that lie in one array from outside; None for other nodes."""
    if any(node is None or node.op != "par" for node in nodes):
        return None
    reads, slots = table.g.reads, [node.data for node in nodes]
    group = reads.groups[reads.group(slots[0])]
    whole = range(group.first, group.first + (math.prod(group.shape) if group.shape else 1))
    if group.shape is None or min(slots) not in whole or max(slots) not in whole:
        return None
    first = table.of_slots(whole).first
    ids = np.array(slots, ID) + ID(first - group.first)
    return Columns(table, ids.reshape(shape))


def kept(part):
    """A copy of real numbers that lie side by side in memory."""
    table = part.table
    operand = whole(table, part)
    if table.batches[operand].op != "copy":
        operand = table.make("copy", None, part.shape, [operand]).number
    return Columns(table, None, table.batches[operand])


def as_complex(table, value):
    """Any array or number as ComplexColumns."""
    real, imag = parts_of(table, value)
    real = as_columns(table, real)
    imag = as_columns(table, imag) if np.ndim(imag) else filled(table, real.shape, imag)
    return ComplexColumns(real, imag)


def viewed(real):
    """A view of real numbers, alternately real and imaginary parts, as complex numbers."""
    if not real.ndim or real.shape[-1] % 2:
        raise ValueError("the last axis has no even number of real numbers")
    return ComplexColumns(real[..., 0::2], real[..., 1::2])


BATCHES.update(complex=as_complex, viewed=viewed, joint=ComplexColumns)
