"""SciPy's functions on symbols, written out."""

import functools
import math
import types
from typing import Any

import numpy as np

from ..symbols.arithmetic import call, where
from ..symbols.lift import symbol
from ..symbols.symbol import graph_of, refuse
from . import fourier  # noqa: F401  # registers the functions behind np.fft
from .arrays import array_of
from .grids import interpn
from .interpolators import evaluated
from .linear_systems import determinant, solution
from .objects import plain_of, wrapped
from .rotation import Rotations
from .ufuncs import as_numpy

MOST_WEIGHTS = 81
EDGES = {  # mode of scipy.ndimage, or boundary of scipy.signal: mode of np.pad
    "reflect": "symmetric", "grid-mirror": "symmetric", "constant": "constant",
    "grid-constant": "constant", "nearest": "edge", "mirror": "reflect", "wrap": "wrap",
    "grid-wrap": "wrap", "fill": "constant", "symm": "symmetric",
}  # fmt: skip

# -- waveforms, sums of exponentials


def _phase(t, share):
    """The place of t in a period of 2 pi, if the waveform has a known shape."""
    share = float(share)
    if not 0 <= share <= 1:
        refuse("a waveform whose shape changes")
    return call("remainder", as_numpy(symbol(graph_of(t), t)), 2 * math.pi), share


def square(t, duty=0.5):
    phase, share = _phase(t, duty)
    return where(phase < share * 2 * math.pi, 1.0, -1.0)


def sawtooth(t, width=1.0):
    phase, w = _phase(t, width)
    up = phase / (math.pi * w) - 1 if w else phase
    down = (math.pi * (w + 1) - phase) / (math.pi * (1 - w)) if w < 1 else phase
    return where(phase < w * 2 * math.pi, up, down)


def softmax(x, axis=None):
    x = array_of(x)
    powers = np.exp(x - np.max(x, axis=axis, keepdims=True))
    return powers / np.sum(powers, axis=axis, keepdims=True)


def logsumexp(a, axis=None):
    a = array_of(a)
    largest = np.max(a, axis=axis, keepdims=True)
    total = np.log(np.sum(np.exp(a - largest), axis=axis, keepdims=True)) + largest
    return np.squeeze(total, axis=axis) if axis is not None else total.reshape(-1)[0]


# -- distances

MEASURES: dict[str, Any] = {
    "euclidean": lambda d: np.sqrt(np.sum(d * d, axis=-1)),
    "sqeuclidean": lambda d: np.sum(d * d, axis=-1),
    "cityblock": lambda d: np.sum(np.abs(d), axis=-1),
    "chebyshev": lambda d: np.max(np.abs(d), axis=-1),
}


def _measured(metric, *points):
    points = [array_of(p) for p in points]
    if not isinstance(metric, str) or metric not in MEASURES or points[0].ids.ndim != 2:
        refuse("distances of another kind")
    return MEASURES[metric], *points


def cdist(XA, XB, metric="euclidean"):
    measure, a, b = _measured(metric, XA, XB)
    return measure(a[:, None, :] - b[None, :, :])


def pdist(X, metric="euclidean"):
    measure, x = _measured(metric, X)
    i, j = np.triu_indices(len(x), 1)
    return measure(x[i] - x[j])


def squareform(X, force="no", checks=True):
    x = array_of(X)
    n = math.isqrt(2 * x.ids.size) + 1
    if x.ids.ndim != 1 or force != "no" or n * (n - 1) != 2 * x.ids.size:
        refuse("squareform of this array")
    at = np.zeros((n, n), int)
    at[np.triu_indices(n, 1)] = np.arange(x.ids.size)
    return where(np.eye(n, dtype=bool), 0.0, x[at + at.T])


# -- filters and convolutions, as weighted sums of shifted arrays


def correlated(a, weights, mode="reflect", cval=0.0, origin=0, flipped=False) -> Any:
    """Correlate an array with weights that are centred on each element.

    `flipped` tells whether to flip the weights, which makes the correlation a convolution.
    """
    a = array_of(a)
    weights = array_of(weights)
    if weights.ids.ndim != a.ids.ndim or np.any(np.asarray(origin) != 0):
        refuse("a filter in this way")
    before = [n // 2 for n in weights.ids.shape]
    if flipped:
        weights = np.flip(weights)
        before = [n - 1 - b for n, b in zip(weights.ids.shape, before, strict=True)]
    widths = [(b, n - 1 - b) for n, b in zip(weights.ids.shape, before, strict=True)]
    return _weighted(a, widths, EDGES[mode], cval, weights, a.ids.shape)


def _weighted(a, widths, mode, value, weights, shape):
    """The sum of an extended array, shifted and weighted."""
    if weights.ids.size > MOST_WEIGHTS:
        refuse("a filter with many weights", said=False)
    a.g.check(6 * math.prod(shape) * weights.ids.size)
    wide = np.pad(a, widths, mode, **({"constant_values": value} if mode == "constant" else {}))
    total: Any = np.zeros_like(a, shape=shape)
    for at in np.ndindex(weights.ids.shape):
        weight = weights[at]
        if weight.kind == "c" or weight.node.op != "const" or weight.node.data != 0.0:
            part = wide[tuple(slice(i, i + n) for i, n in zip(at, shape, strict=True))]
            total = total + part * weight
    return total


def _filter(flipped, along=False) -> Any:
    """A filter of scipy.ndimage, with weights along one axis, or along all axes."""

    def along_all(input, weights, output=None, mode="reflect", cval=0.0, origin=0):
        if output is not None:
            refuse("a filter with an array for its result")
        return correlated(input, weights, mode, cval, origin, flipped)

    def along_one(input, weights, axis=-1, *more, **named):
        shape = [1] * array_of(input).ids.ndim
        shape[axis] = -1
        return along_all(input, array_of(weights).reshape(shape), *more, **named)

    return along_one if along else along_all


def laplace(input, output=None, mode="reflect", cval=0.0):
    axes = range(array_of(input).ids.ndim)
    second = _filter(False, along=True)
    return sum(second(input, [1.0, -2.0, 1.0], axis, output, mode, cval) for axis in axes)


def convolve2d(in1, in2, mode="full", boundary="fill", fillvalue=0):
    """scipy.signal.convolve2d."""
    return _convolved(array_of(in1), array_of(in2), mode, EDGES[boundary], fillvalue)


def _convolved(a, b, mode, edges="constant", value=0):
    """A convolution of two arrays of as many axes."""
    if mode == "valid" and all(m < n for m, n in zip(a.ids.shape, b.ids.shape, strict=True)):
        a, b = b, a
    sizes = list(zip(a.ids.shape, b.ids.shape, strict=True))
    if a.ids.ndim != b.ids.ndim or any(m < n for m, n in sizes):
        refuse("a convolution with a kernel larger than the array")
    shape = [m + n - 1 for m, n in sizes]
    whole = _weighted(a, [(n - 1, n - 1) for _, n in sizes], edges, value, np.flip(b), shape)
    if mode == "full":
        return whole
    cut = [(n - 1) // 2 if mode == "same" else n - 1 for _, n in sizes]
    size = [m if mode == "same" else m - n + 1 for m, n in sizes]
    return whole[tuple(slice(c, c + n) for c, n in zip(cut, size, strict=True))]


def convolve(a, v, mode="full"):
    """np.convolve."""
    a = array_of(a)
    v = array_of(v)
    return _convolved(*((v, a) if len(v) > len(a) else (a, v)), mode)


def _transform(name):
    """A Fourier transform of SciPy by NumPy's, whose name is the same."""

    def function(x, *more, overwrite_x=False, workers=None, **named):
        if overwrite_x or len(more) > 2:
            refuse(f"{name} in this way")
        return getattr(np.fft, name)(array_of(x), *more, **named)

    return function


# -- dispatch

TRANSFORMS = [f"{inverse}{real}fft{axes}" for inverse in ("", "i") for real in ("", "r")
              for axes in ("", "2", "n")]  # fmt: skip
WRITTEN_OUT: dict[str, dict[str, Any]] = {
    "numpy": {"convolve": convolve}, "scipy.fft": {name: _transform(name) for name in TRANSFORMS},
    "scipy.fftpack": {name: _transform(name) for name in ("fft", "ifft", "fft2", "ifft2")},
    "scipy.interpolate": {"splev": evaluated, "interpn": interpn},
    "scipy.linalg": {"solve": solution, "inv": lambda a: solution(a, np.eye(len(a))),
                     "det": determinant,
                     "norm": lambda a, *more, **named: np.linalg.norm(array_of(a), *more, **named)},
    "scipy.ndimage": {"correlate": _filter(False), "convolve": _filter(True),
                      "correlate1d": _filter(False, True), "convolve1d": _filter(True, True),
                      "laplace": laplace},
    "scipy.signal": {"square": square, "sawtooth": sawtooth, "convolve2d": convolve2d},
    "scipy.spatial": {"cdist": cdist, "pdist": pdist, "squareform": squareform},
    "scipy.special": {"softmax": softmax, "logsumexp": logsumexp},
}  # fmt: skip


def package_of(function):
    """The package of a function, such as "scipy.signal"."""
    return ".".join((getattr(function, "__module__", None) or "").split(".")[:2])


def written_out(function):
    """The form of a library function on symbols; None if there is none."""
    return WRITTEN_OUT.get(package_of(function), {}).get(getattr(function, "__name__", ""))


def stand_in_of(value, made):
    """The stand-in of a function or class of SciPy, ``made(value)``; None for any other value."""
    package = package_of(value)
    kind = type(value)
    if kind is np.ufunc:
        return made(value)
    if not package.startswith("scipy.") and kind.__module__ != "uarray":
        return None
    if isinstance(value, type):
        if issubclass(value, BaseException):
            return None
        return Rotations() if value.__name__ == "Rotation" else functools.partial(_new, value)
    if not isinstance(value, types.FunctionType) and kind.__module__ != "uarray":
        return None
    if package == "scipy.optimize":  # C code would print the errors of symbols
        return lambda *_, **__: refuse(f"it calls {value.__name__}")
    return made(value)


def _new(cls, *args, **kwargs):
    return wrapped(cls(*plain_of(args), **plain_of(kwargs)))
