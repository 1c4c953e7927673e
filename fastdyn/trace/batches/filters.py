"""SciPy's filters with few weights, and convolutions, as weighted sums of shifted arrays."""

from typing import Any

import numpy as np

from ..symbols.symbolic import NOW, is_symbolic, refuse
from .formulas import as_columns
from .structure import padded

MOST_WEIGHTS = 81
EDGES = {  # mode of `scipy.ndimage`: mode of np.pad
    "reflect": "symmetric", "grid-mirror": "symmetric", "constant": "constant",
    "grid-constant": "constant", "nearest": "edge", "mirror": "reflect", "wrap": "wrap",
    "grid-wrap": "wrap",
}  # fmt: skip
BOUNDARIES = {"fill": "constant", "wrap": "wrap", "symm": "symmetric"}


def correlated(a, weights, mode="reflect", cval=0.0, origin=0, flipped=False) -> Any:
    """Correlate an array with weights that are centred on each element.

    Parameters
    ----------
    a : array
    weights : array
        At most 81 weights, in an array with as many axes as `a`.
    mode, cval
        As for `scipy.ndimage.correlate`.
    origin : int or sequence of int
        Must be 0.
    flipped : bool
        Whether to flip the weights, which makes the correlation a convolution.
    """
    a, weights = as_columns(NOW.table, a), _weights(weights)
    if weights.ndim != a.ndim or weights.size > MOST_WEIGHTS or np.any(np.asarray(origin) != 0):
        refuse("a filter of a long array in this way", said=False)
    before = [s // 2 for s in weights.shape]
    if flipped:
        weights = weights[(slice(None, None, -1),) * weights.ndim]
        before = [s - 1 - b for s, b in zip(weights.shape, before, strict=True)]
    after = [s - 1 - b for s, b in zip(weights.shape, before, strict=True)]
    wide = _around(a, list(zip(before, after, strict=True)), EDGES[mode], cval)
    return _summed(wide, weights, a.shape)


def _weights(weights):
    if is_symbolic(weights) and not isinstance(weights, np.ndarray):
        refuse("a filter with weights that depend on the state")
    return np.asarray(weights, object) if is_symbolic(weights) else np.asarray(weights, float)


def _around(a, widths, mode, value):
    given = {"constant_values": value} if mode == "constant" else {}
    return padded(NOW.table, a, widths, mode, **given)


def _summed(wide, weights, shape):
    total: Any = None
    for at in np.ndindex(weights.shape):
        weight = weights[at]
        if not is_symbolic(weight) and weight == 0.0:
            continue
        part = wide[tuple(slice(i, i + n) for i, n in zip(at, shape, strict=True))]
        term = part * weight
        total = term if total is None else total + term
    return wide[tuple(slice(0, n) for n in shape)] * 0.0 if total is None else total


def _along(a, weights, axis):
    """Reshape weights along one axis to an array with as many axes as `a`."""
    shape = [1] * np.ndim(a)
    shape[axis] = -1
    return _weights(weights).reshape(shape)


def correlate(input, weights, output=None, mode="reflect", cval=0.0, origin=0):
    return correlated(input, weights, mode, cval, origin) if output is None else _into(output)


def convolve(input, weights, output=None, mode="reflect", cval=0.0, origin=0):
    return correlated(input, weights, mode, cval, origin, True) if output is None else _into(output)


def correlate1d(input, weights, axis=-1, output=None, mode="reflect", cval=0.0, origin=0):
    return correlate(input, _along(input, weights, axis), output, mode, cval, origin)


def convolve1d(input, weights, axis=-1, output=None, mode="reflect", cval=0.0, origin=0):
    return convolve(input, _along(input, weights, axis), output, mode, cval, origin)


def laplace(input, output=None, mode="reflect", cval=0.0):
    total: Any = 0.0
    for axis in range(np.ndim(input)):
        total = total + correlate1d(input, [1.0, -2.0, 1.0], axis, output, mode, cval)
    return total


def _into(output):
    refuse("a filter with an array for its result")


def convolve2d(in1, in2, mode="full", boundary="fill", fillvalue=0.0):
    """scipy.signal.convolve2d."""
    a, weights = as_columns(NOW.table, in1), _weights(in2)
    if weights.ndim != 2 or a.ndim != 2 or weights.size > MOST_WEIGHTS:
        refuse("convolve2d of long arrays in this way", said=False)
    if any(m < n for m, n in zip(a.shape, weights.shape, strict=True)):
        refuse("convolve2d with a kernel larger than the array")
    wide = _around(a, [(s - 1, s - 1) for s in weights.shape], BOUNDARIES[boundary], fillvalue)
    shape = [m + n - 1 for m, n in zip(a.shape, weights.shape, strict=True)]
    whole = _summed(wide, weights[::-1, ::-1], shape)
    if mode == "full":
        return whole
    cut = [(n - 1) // 2 if mode == "same" else n - 1 for n in weights.shape]
    size = [m if mode == "same" else m - n + 1 for m, n in zip(a.shape, weights.shape, strict=True)]
    return whole[tuple(slice(c, c + s) for c, s in zip(cut, size, strict=True))]


def convolved(table, a, v, mode="full"):
    """numpy.convolve."""
    a, v = (as_columns(table, x) if is_symbolic(x) else np.asarray(x) for x in (a, v))
    if np.size(v) > np.size(a):
        a, v = v, a
    n, m = np.size(a), np.size(v)
    if m > MOST_WEIGHTS:
        refuse("np.convolve of two long arrays", said=False)
    whole = _summed(_around(a, m - 1, "constant", 0.0), v[::-1], (n + m - 1,))
    first, size = {"full": (0, n + m - 1), "same": ((m - 1) // 2, n), "valid": (m - 1, n - m + 1)}[
        mode
    ]
    return whole[first : first + size]


FILTERS = {
    f.__name__: f for f in (correlate, convolve, correlate1d, convolve1d, laplace, convolve2d)
}  # fmt: skip
