"""NumPy's calls on long complex arrays, each by those on their real and imaginary parts."""

from itertools import product as all_of
from typing import Any

import numpy as np

from ...islands.calls import apart
from ...numpy.calls import WITH_EFFECTS
from ...numpy.of_numbers import of_numbers
from ...symbols.complex_pair import Pair, parts
from ...symbols.symbolic import Batched, refuse
from ..columns import Columns
from ..formulas import elementwise
from ..library import OWN, TRAPEZOID
from ..products import matmul, sparse
from ..structure import JOINING, STRUCTURE
from .columns import ComplexColumns, as_complex, is_of_complexes, joint, kept, parts_of

ONE_BY_ONE = {  # linear functions, which act on the real and on the imaginary part
    np.sum, np.mean, np.cumsum, np.diff, np.gradient, TRAPEZOID,
}  # fmt: skip


def call_ufunc(table, ufunc, method, args, options, out, where) -> Any:
    """``ufunc(*args)`` of arrays, some of them complex."""
    if where is not True:
        refuse(f"np.{ufunc.__name__} of chosen complex numbers")
    if method == "reduce" and ufunc is np.add:
        result = linear(table, OWN[np.sum], *args, **options)
    elif method != "__call__" or options:
        refuse(f"np.{ufunc.__name__}.{method} of long complex arrays")
    elif ufunc is np.matmul:
        result = multilinear(table, _product, args)
    else:
        result = _elementwise(table, of_numbers(ufunc), args)
    return result if out is None else _stored(table, result, out)


def _stored(table, result, out):
    target = out[0] if isinstance(out, tuple) else out
    if not isinstance(target, ComplexColumns):
        refuse("complex numbers are stored in an array of real ones")
    target[...] = result
    return target


def _elementwise(table, function, values):
    """Apply a function of numbers to the elements; a complex element is given as two parts."""
    pairs = [is_of_complexes(v) for v in values]
    given = [p for v in values for p in parts_of(table, v)]

    def of_numbers(*numbers):
        both = zip(numbers[::2], numbers[1::2], strict=True)
        result = function(*[Pair(a, b) if c else a for (a, b), c in zip(both, pairs, strict=True)])
        return parts(result) if isinstance(result, Pair | complex) else result

    result = elementwise(table, of_numbers, given)
    return joint(*result) if isinstance(result, tuple) else result


def linear(table, function, array, *args, **kwargs):
    """Apply a function that is linear in its first argument and has real further arguments."""
    if any(map(is_of_complexes, (*args, *kwargs.values()))):
        refuse("complex numbers beside a long array, in this way")
    if kwargs.get("dtype") in (complex, np.complex128):
        del kwargs["dtype"]
    return as_complex(table, array).both(lambda part: function(table, part, *args, **kwargs))


def multilinear(table, function, arrays, *args):
    """A function that is linear in each of some arrays: the sum over products of parts."""
    real, imag = None, None
    for chosen in all_of((0, 1), repeat=len(arrays)):
        terms = [parts_of(table, a)[i] for a, i in zip(arrays, chosen, strict=True)]
        if any(_is_zero(term) for term in terms):
            continue
        value = function(table, *terms, *args)
        if sum(chosen) >= 2:
            value = -value
        if sum(chosen) % 2:
            imag = value if imag is None else imag + value
        else:
            real = value if real is None else real + value
    if real is None or imag is None:
        found: Any = imag if real is None else real
        zero = np.zeros_like(found) if isinstance(found, Batched) else 0.0
        real, imag = (zero, found) if real is None else (found, zero)
    return joint(real, imag)


def _product(table, a, b):
    """A product of matrices, whose elements are first copied into contiguous batches."""
    if np.ndim(a) == 2 and np.ndim(b) == 2:
        a, b = (kept(v) if isinstance(v, Columns) else v for v in (a, b))
    return matmul(table, a, b)


def _is_zero(value):
    if isinstance(value, np.ndarray) and not isinstance(value, Batched) and value.dtype != object:
        return not value.any()
    return isinstance(value, float) and value == 0.0


PRODUCTS = {  # linear in each of their arrays
    np.dot: _product, np.matmul: _product, np.inner: OWN[np.inner], np.outer: OWN[np.outer],
    np.convolve: OWN[np.convolve],
}  # fmt: skip


def call_function(table, function, args, kwargs) -> Any:
    """A function of NumPy."""
    own = OF_COMPLEXES.get(function)
    if own is not None:
        return own(table, *args, **kwargs)
    if function in STRUCTURE:
        return as_complex(table, args[0]).both(lambda part: function(part, *args[1:], **kwargs))
    if function in JOINING:
        return _joined(table, function, *args, **kwargs)
    if function in ONE_BY_ONE:
        return linear(table, OWN[function], *args, **kwargs)
    if function in PRODUCTS:
        a, b, *more = [*args, *kwargs.values()]
        if function is not np.convolve:
            if any(v is not None for v in more):
                refuse(f"np.{function.__name__} with an array for its result")
            more = []
        return multilinear(table, PRODUCTS[function], (a, b), *more)
    if isinstance(function, np.ufunc):
        return function(*[as_complex(table, a) if np.ndim(a) else a for a in args], **kwargs)
    if function.__name__ in WITH_EFFECTS:
        refuse(f"np.{function.__name__} of a long array that depends on the state")
    return apart(function, args, kwargs)


def _joined(table, function, arrays, *args, **kwargs):
    arrays = list(arrays)
    found = [as_complex(table, a) if np.ndim(a) else parts_of(table, a) for a in arrays]
    both = [(a.real, a.imag) if isinstance(a, ComplexColumns) else a for a in found]
    return joint(*[function(list(part), *args, **kwargs) for part in zip(*both, strict=True)])


def _einsum(table, subscripts, *arrays, **_):
    function = OWN[np.einsum]
    return multilinear(table, lambda table, *a: function(table, subscripts, *a), arrays)


def _where(table, condition, a, b):
    if is_of_complexes(condition):
        refuse("the truth of complex numbers")
    (a, c), (b, d) = parts_of(table, a), parts_of(table, b)
    return joint(np.where(condition, a, b), np.where(condition, c, d))


def _array(table, a, dtype=None, *, copy=True, **more):
    if dtype not in (None, complex, np.complex128) or more.get("ndmin"):
        refuse("a conversion of complex numbers")
    found = as_complex(table, a)
    return found.copy() if copy and isinstance(a, ComplexColumns) else found


def _like(value):
    def function(table, a, dtype=None, *args, **more):
        if dtype in (None, complex, np.complex128):
            found = as_complex(table, a).both(lambda part: np.zeros_like(part, None, *args, **more))
            if value:
                found.real[...] = value
            return found
        return np.full_like(as_complex(table, a).real, value, dtype, *args, **more)

    return function


def _norm(table, x, ord=None, axis=None, keepdims=False):
    return np.linalg.norm(np.abs(x), ord, axis, keepdims)


def _vdot(table, a, b):
    return np.dot(np.conj(np.ravel(a)), np.ravel(b))


def _angle(table, z, deg=False):
    z = as_complex(table, z)
    found = np.arctan2(z.imag, z.real)
    return found * (180.0 / np.pi) if deg else found


def _shape(name):
    return lambda table, a, *args: getattr(np, name)(as_complex(table, a).real, *args)


def _trace(table, a, *args):
    return np.sum(np.diagonal(a, *args))


OF_COMPLEXES: dict[Any, Any] = {
    np.einsum: _einsum, np.where: _where, np.array: _array, np.linalg.norm: _norm,
    np.asarray: lambda table, a, dtype=None, **kw: _array(table, a, dtype, copy=False),
    np.asanyarray: lambda table, a, dtype=None, **kw: _array(table, a, dtype, copy=False),
    np.ascontiguousarray: lambda table, a, dtype=None, **kw: _array(table, a, dtype, copy=False),
    np.zeros_like: _like(0.0), np.empty_like: _like(0.0), np.ones_like: _like(1.0),
    np.vdot: _vdot, np.angle: _angle, np.trace: _trace,
    np.real: lambda table, a: as_complex(table, a).real,
    np.imag: lambda table, a: as_complex(table, a).imag,
    np.iscomplexobj: lambda table, a: True, np.isrealobj: lambda table, a: False,
    np.shape: _shape("shape"), np.ndim: _shape("ndim"), np.size: _shape("size"),
}  # fmt: skip


def by_sparse(table, matrix, x):
    """A constant sparse matrix times a vector; matrix, vector or both are complex."""
    if matrix.dtype.kind != "c" and not isinstance(x, ComplexColumns):
        return sparse(table, matrix, x)
    real = matrix if matrix.dtype.kind != "c" else matrix.real
    arrays = [(real, x)] if matrix.dtype.kind != "c" else [(real, x), (matrix.imag, x)]
    found = [as_complex(table, v).both(lambda part, m=m: sparse(table, m, part)) for m, v in arrays]
    return found[0] if len(found) == 1 else found[0] + 1j * found[1]
