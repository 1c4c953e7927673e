"""scipy.signal.convolve2d, written out as operations of the graph."""

import numpy as np

from ..symbols.arrays import Array
from ..symbols.complex_pair import product, total
from ..symbols.symbolic import check_operations, is_symbolic, refuse


def convolved_2d(in1, in2, mode="full", boundary="fill", fillvalue=0):
    """scipy.signal.convolve2d."""
    a, b = (np.asarray(Array.of(v)).view(np.ndarray) for v in (in1, in2))
    if a.ndim != 2 or b.ndim != 2:
        raise ValueError("convolve2d inputs must both be 2-D arrays")
    if mode == "valid" and all(m < n for m, n in zip(a.shape, b.shape, strict=True)):
        a, b = b, a
    known = mode in ("full", "same", "valid") and boundary in ("fill", "wrap", "symm")
    if not known or is_symbolic(fillvalue) or a.shape[0] < b.shape[0] or a.shape[1] < b.shape[1]:
        refuse("convolve2d in this way", final=True)
    first = [{"full": 0, "same": (n - 1) // 2, "valid": n - 1}[mode] for n in b.shape]
    more = {"full": 1, "same": 0, "valid": -1}[mode]
    shape = [m + more * (n - 1) for m, n in zip(a.shape, b.shape, strict=True)]
    check_operations(6 * int(np.prod(shape)) * b.size)
    wide = _extended(a, b.shape, boundary, fillvalue)
    result = np.empty(shape, dtype=object)
    for i, j in np.ndindex(*shape):
        part = wide[first[0] + i :, first[1] + j :][: b.shape[0], : b.shape[1]]
        result[i, j] = total(map(product, part[::-1, ::-1].flat, b.flat))
    return result.view(Array)


def _extended(a, by, boundary, fillvalue):
    """An array extended at its boundaries, as `boundary` says."""
    places = [np.arange(1 - n, m + n - 1) for m, n in zip(a.shape, by, strict=True)]
    if boundary == "symm":
        folded = [np.where(p < 0, -1 - p, p) for p in places]
        sizes = zip(folded, a.shape, strict=True)
        places = [np.where(p >= m, 2 * m - 1 - p, p) for p, m in sizes]
    inner = [p % m for p, m in zip(places, a.shape, strict=True)]
    wide = a[np.ix_(*inner)].copy()
    if boundary == "fill":
        for axis, (p, m) in enumerate(zip(places, a.shape, strict=True)):
            np.moveaxis(wide, axis, 0)[(p < 0) | (p >= m)] = fillvalue
    return wide
