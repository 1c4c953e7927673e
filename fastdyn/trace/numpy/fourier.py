"""Fourier transforms as operations of the graph: transforms of the factors of the length."""

from typing import Any

import numpy as np

from ..symbols.arrays import Array
from ..symbols.complex_pair import Pair, parts
from ..symbols.symbolic import check_operations, refuse

LARGEST_FACTOR = 32  # a prime length takes its square: 1000 products


def transform(name):
    """The transform `name` of np.fft or scipy.fft, for arrays that hold symbols."""

    def function(a, n=None, axis=-1, norm=None, out=None, **more):
        if out is not None or any(v not in (None, False) for v in more.values()):
            refuse(f"{name} with options")
        rows = np.moveaxis(Array.of(a), axis, -1).view(np.ndarray)
        if rows.ndim == 0 or rows.shape[-1] == 0:
            refuse(f"{name} of nothing")
        size = 2 * (rows.shape[-1] - 1) if n is None and name == "irfft" else n
        size = rows.shape[-1] if size is None else int(size)
        count = int(np.prod(rows.shape[:-1]))
        # 3 transforms, because most functions also transform back
        check_operations(3 * count * 5 * size * max(1, size.bit_length() - 1))
        results = [_of_row(name, list(row), size, norm) for row in rows.reshape(count, -1)]
        found = np.empty((count, len(results[0])), dtype=object)
        for i, row in enumerate(results):
            found[i] = row
        return np.moveaxis(found.reshape(*rows.shape[:-1], -1), -1, axis).view(Array)

    return function


def _of_row(name, row: list, n, norm):
    inverse = name in ("ifft", "irfft")
    if name == "irfft":
        row = _whole_spectrum(row, n)
    elif name == "rfft":
        row = [parts(v)[0] for v in row]
    row = row[:n] + [0.0] * (n - len(row))
    found = _transformed([parts(v) for v in row], 1.0 if inverse else -1.0)
    if norm not in (None, "backward", "forward", "ortho"):
        raise ValueError(f"Invalid norm value {norm}")
    scaled = {"ortho": np.sqrt(n), "forward": 1.0 if inverse else n}.get(norm or "", None)
    scale = 1.0 / (scaled if scaled is not None else n if inverse else 1.0)
    if scale != 1.0:
        found = [(scale * a, scale * b) for a, b in found]
    if name == "irfft":
        return [a for a, _ in found]
    return [Pair(a, b) for a, b in (found[: n // 2 + 1] if name == "rfft" else found)]


def _whole_spectrum(half, n):
    """The n values of a Hermitian spectrum, from the values 0 to n / 2."""
    m = n // 2 + 1
    half = (half + [0.0] * m)[:m]
    half[0] = parts(half[0])[0]
    if n % 2 == 0:
        half[-1] = parts(half[-1])[0]
    rest: Any = half[1 : (n + 1) // 2]
    return half + [Pair(a, -1.0 * b) for a, b in map(parts, reversed(rest))]


def _transformed(x, sign) -> list:
    """The sum over k of x[k] exp(sign 2 pi i j k / n), for all j; numbers are (real, imag)."""
    n = len(x)
    p = next((p for p in (4, 2, *range(3, LARGEST_FACTOR, 2)) if n % p == 0), n)
    if p == n:
        return _slowly(x, sign)
    m = n // p
    inner = [_transformed(x[k::p], sign) for k in range(p)]
    result: list = [None] * n
    for j in range(m):
        column = [_turned(inner[k][j], sign * j * k / n) for k in range(p)]
        for r, value in enumerate(_slowly(column, sign)):
            result[j + r * m] = value
    return result


def _slowly(x, sign) -> list:
    n = len(x)
    if n > LARGEST_FACTOR:
        refuse("a Fourier transform of a length with a large prime factor")
    if n == 2:
        (a, b), (c, d) = x
        return [(a + c, b + d), (a - c, b - d)]
    if n == 4:
        (a, b), (c, d) = _slowly(x[::2], sign), _slowly(x[1::2], sign)
        turned = _turned(d, sign / 4)
        return [_sum(a, c), _sum(b, turned), _sum(a, c, -1.0), _sum(b, turned, -1.0)]
    sums = []
    for j in range(n):
        terms = [_turned(x[k], sign * (j * k % n) / n) for k in range(n)]
        sums.append(_added(terms))
    return sums


def _added(terms):
    total = terms[0]
    for term in terms[1:]:
        total = _sum(total, term)
    return total


def _sum(a, b, sign=1.0):
    return (a[0] + b[0], a[1] + b[1]) if sign > 0 else (a[0] - b[0], a[1] - b[1])


def _turned(z, turns):
    """z exp(2 pi i turns); quarter turns are exact."""
    quarters = 4 * (turns % 1.0)
    a, b = z
    if quarters == int(quarters):
        return [(a, b), (-1.0 * b, a), (-1.0 * a, -1.0 * b), (b, -1.0 * a)][int(quarters)]
    c, s = float(np.cos(2 * np.pi * turns)), float(np.sin(2 * np.pi * turns))
    return c * a - s * b, s * a + c * b
