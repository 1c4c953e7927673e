"""SciPy's functions and objects on symbols: dispatch, interpolators, sparse matrices, rotations."""

import functools
import types
from typing import Any

import numpy as np

from ..islands import apart, or_apart
from ..numpy.fourier import TRANSFORMS, transform
from ..numpy.linear_algebra import determinant, inverse, linear_in_first, norm, solution
from ..numpy.plain_arrays import lowered, raised
from ..reads.reads import STABLE
from ..symbols.arrays import Array
from ..symbols.complex_pair import product, total
from ..symbols.lazy import complete
from ..symbols.symbolic import BATCHES, Batched, Unwritten, in_batches, is_symbolic, refuse
from .convolution import convolved_2d
from .distances import DISTANCES
from .functions import logsumexp, sawtooth, softmax, square
from .interpolators import Interpolator, evaluated, maker_of, numbers_in
from .rotation import Rotations

FILTERS = {
    "convolve", "convolve1d", "correlate", "correlate1d", "laplace", "gaussian_filter",
    "gaussian_filter1d", "gaussian_laplace", "uniform_filter", "uniform_filter1d", "sobel",
}  # fmt: skip
CONTENTS = {  # attributes of sparse matrices, by format
    **dict.fromkeys(("csr", "csc", "bsr"), ("data", "indices", "indptr", "shape")),
    "dia": ("data", "offsets", "shape"),
    "coo": ("data", "coords", "shape"),
}
ALONG_AN_AXIS = {f.__name__ for f in TRANSFORMS}
OF_FFT = {"dct", "idct", "dst", "idst", "diff", "hilbert"}
LINEAR = {"scipy.fft": OF_FFT, "scipy.fftpack": OF_FFT, "scipy.ndimage": FILTERS}
LIBRARIES = {f"scipy.{name}" for name in "fft fftpack linalg ndimage signal special".split()}
WITH_EFFECTS = {"set_workers", "set_backend", "set_global_backend", "register_backend"}
WRITTEN_OUT: dict[str, dict[str, Any]] = {
    "scipy.interpolate": {"splev": evaluated},
    "scipy.linalg": {"solve": solution, "inv": inverse, "det": determinant, "norm": norm},
    "scipy.signal": {"square": square, "sawtooth": sawtooth, "convolve2d": convolved_2d},
    "scipy.spatial": DISTANCES,
    "scipy.special": {"softmax": softmax, "logsumexp": logsumexp},
}
OF_BOTH = {"scipy.spatial"}  # packages whose formulas also take long arrays


def stand_in_of(value):
    """The stand-in of a SciPy function or class; None for any other value."""
    module = getattr(value, "__module__", None) or ""
    if not module.startswith("scipy."):
        return None
    name = getattr(value, "__name__", "")
    if name == "Rotation" and isinstance(value, type):
        return Rotations()
    if isinstance(value, type) and module.startswith("scipy.interpolate"):
        return maker_of(value)
    if not isinstance(value, types.FunctionType) and type(value).__module__ != "uarray":
        return None
    package = ".".join(module.split(".")[:2])
    if package == "scipy.optimize":
        return _of_constants(value)
    written_out = WRITTEN_OUT.get(package, {}).get(name)
    of_both = package in OF_BOTH and written_out is not None
    if package == "scipy.fft" and name in ALONG_AN_AXIS:
        written_out, of_both = transform(value), True
    elif name in LINEAR.get(package, ()):
        written_out = functools.partial(linear_in_first, value)
    elif written_out is None and package in LIBRARIES and name not in WITH_EFFECTS:
        written_out = lambda *args, **kwargs: apart(value, args, kwargs)  # noqa: E731
    return written_out and _beside(value, written_out, of_both)


def _of_constants(solver):
    """A solver of scipy.optimize that refuses symbols, because its C code would print errors."""

    def function(*args, **kwargs):
        given = [*args, *kwargs.values()]
        for f in [f for f in given if isinstance(f, types.FunctionType)]:
            given += [*(f.__defaults__ or ()), *(c.cell_contents for c in f.__closure__ or ())]
        if is_symbolic(given):
            refuse(f"{solver.__name__} of a function that depends on the state")
        return solver(*args, **kwargs)

    return function


def _beside(plain, of_symbols, of_both=False):
    """A function that calls `of_symbols` for symbols, and the SciPy function `plain` for numbers.

    Where `of_symbols` refuses, compiled code calls the SciPy function as an island.  `of_both`
    tells whether `of_symbols` takes long arrays, too.
    """
    of_long = of_symbols if of_both else None
    of_symbols = or_apart(plain, of_symbols)
    in_a_batch = or_apart(plain, lambda *a, **k: BATCHES["scipy"](plain, of_long, a, k))

    def function(*args, **kwargs):
        if in_batches(args):
            return in_a_batch(*args, **kwargs)
        args, kwargs = complete(args), {name: complete(v) for name, v in kwargs.items()}
        if is_symbolic([*args, *kwargs.values()]):
            return of_symbols(*args, **kwargs)
        named = {name: lowered(v) for name, v in kwargs.items()}
        return raised(plain(*map(lowered, args), **named))

    return function


def is_of_scipy(kind):
    """Whether a type is one of SciPy."""
    return (kind.__module__ or "").startswith("scipy")


def _content_of_polynomial(value):
    if isinstance(value, np.poly1d):
        return ("coeffs",)
    of_series = type(value).__module__.startswith("numpy.polynomial")
    return ("coef", "domain", "window") if of_series and hasattr(value, "coef") else None


def content_of(value):
    """The names of the attributes that determine an object of SciPy; None if unknown."""
    if getattr(value, "format", None) and type(value).__module__.startswith("scipy.sparse"):
        return CONTENTS.get(str(value.format))
    if type(value).__module__.startswith("numpy"):
        return _content_of_polynomial(value)
    return () if type(value).__name__ == "Rotation" else numbers_in(value)


def expect_content(reads, value, row):
    """Let later calls check that an object has the current content."""
    names = content_of(value)
    if names is None:
        reads.lasting = False  # a later call cannot check the content
    for name in names or ():
        _expect(reads, getattr(value, name), reads.step(row, "member", name))


def _expect(reads, part, where):
    if where not in (None, STABLE) and reads.rows[where].check is not None:
        return
    if isinstance(part, np.ndarray):
        reads.expect(where, "content", part.copy())
    elif type(part) is tuple:
        reads.expect(where, "length", (tuple, len(part)))
        for i, each in enumerate(part):
            _expect(reads, each, reads.step(where, "item", i))
    elif content_of(part) is not None:
        reads.expect(where, "same", part)
        expect_content(reads, part, where)
    else:
        reads.expect(where, "equal" if part == part else "same", part)


def copy_of(value):
    """The stand-in of an object of SciPy."""
    if type(value).__name__ == "Rotation" and value.single:
        return Rotations().from_quat(value.as_quat())
    if hasattr(value, "tocsr") and hasattr(value, "nnz"):
        return Sparse(value)
    if content_of(value) is None:
        refuse(f"it uses an object of type {type(value).__name__}", final=True)
    return Interpolator(value)


class Sparse(Unwritten):
    """The stand-in of a constant sparse matrix, times a factor; the stand-in multiplies vectors."""

    def __init__(self, matrix, factor=1.0):
        vars(self).update(_matrix=matrix.tocsr(), _factor=factor, shape=matrix.shape)

    def _scaled(self, factor):
        return Sparse(self._matrix, self._factor * factor)

    def __rmul__(self, factor):
        return self._scaled(factor)

    def __neg__(self):
        return self._scaled(-1.0)

    def __array_ufunc__(self, ufunc, method, *args, **kwargs):
        if ufunc is np.multiply and np.ndim(args[0]) == 0:  # a NumPy number on the left
            return self._scaled(args[0])
        return refuse(f"np.{ufunc.__name__} of a sparse matrix")

    def __matmul__(self, y):
        if np.ndim(y) == 0:
            return self._scaled(y)
        if not is_symbolic([y, self._factor]):
            return raised(self._factor * (self._matrix @ lowered(y)))
        if isinstance(y, Batched):
            found = BATCHES["sparse"](y.table, self._matrix, y)
            plain = not is_symbolic(self._factor) and self._factor == 1.0
            return found if plain else self._factor * found
        y, m = Array.of(y), self._matrix
        if y.ndim != 1:
            refuse("a sparse matrix times a matrix that depends on the state")
        data = m.data.astype(complex if m.dtype.kind == "c" else float)
        rows = [range(*pair) for pair in zip(m.indptr, m.indptr[1:], strict=False)]
        products = Array.of([total(product(data[k], y[m.indices[k]]) for k in r) for r in rows])
        plain = not is_symbolic(self._factor) and self._factor == 1.0
        return products if plain else self._factor * products

    __mul__ = dot = __matmul__

    def __getattr__(self, name):
        refuse(f"it uses `{name}` of a sparse matrix", final=True)
