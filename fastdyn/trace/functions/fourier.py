"""Fourier transforms of short arrays, by transforms of the factors of the length."""

import functools
import math
from typing import Any

import numpy as np

from ..symbols.lift import joint
from ..symbols.symbol import Symbol, constant, refuse
from .algebra import _sums
from .arrays import array_of
from .ufuncs import OF_ROWS

LONGEST = 256  # compiled code calls the library for longer arrays
LARGEST_FACTOR = 32  # a prime length takes its square: 1000 products


def transformed(z: Any, sign) -> Any:
    """The sum over k of z[..., k] exp(sign 2 pi i j k / n), for all j."""
    *rows, n = z.ids.shape
    z, m = z.reshape(*rows, 1, n), 1  # transforms of length m are done
    while m < n:
        p = next(p for p in range(2, n + 1) if n // m % p == 0)
        if p > LARGEST_FACTOR:
            refuse("a Fourier transform of a length with a large prime factor")
        q = n // (m * p)
        places = np.arange(p * m).reshape(p, m, 1)
        terms = [z[..., None, :, k * q : (k + 1) * q] for k in range(p)]
        turned = [_turned(terms[k], k * places, p * m, sign) for k in range(1, p)]
        z = _in_memory(sum(turned, terms[0])).reshape(*rows, m * p, q)
        m = m * p
    return z.reshape(*rows, n)


def _turned(z, k, n, sign) -> Any:
    """z exp(sign 2 pi i k / n); quarter turns are exact."""
    turns = np.exp(sign * 2j * np.pi * (k % n) / n)
    turns = np.where(4 * k % n, turns, np.round(turns))
    a = z.real
    b = z.imag
    c = turns.real
    d = turns.imag
    if z.g.few < math.inf:
        return z * turns
    return joint(_two_products(a, c, b, -d), _two_products(a, d, b, c))


def _two_products(a, c, b, d) -> Any:
    """a c + b d without the products by zero."""
    shape = np.broadcast_shapes(a.ids.shape, c.shape)
    pairs = [np.broadcast_to(array_of(v), shape) for v in (a, b, c, d)]
    return _sums(np.stack(pairs[:2], -1), np.stack(pairs[2:], -1), 2)


def _in_memory(z) -> Any:
    """A copy of a long array, so that the next pass does not compute the numbers anew."""
    g = z.g
    shape = z.ids.shape
    if z.ids.size <= g.few:
        return z
    parts = [np.ascontiguousarray(z.ids[name]).reshape(-1) for name in ("real", "imag")]
    return joint(*[Symbol(g, g.ids(g.row("copy", shape, (part,)))) for part in parts])


def _resized(z, n) -> Any:
    if z.ids.shape[-1] >= n:
        return z[..., :n]
    return np.concatenate([z, np.zeros((*z.ids.shape[:-1], n - z.ids.shape[-1]))], axis=-1)


def transform(name, given, factor, axes, out):
    """A ufunc behind np.fft, with the place of its factor, along the axis ``axes[0]``."""
    (axis,) = axes[0]
    (out,) = out
    z = np.moveaxis(array_of(given), axis, -1)
    m = out.shape[axis]
    size = {"rfft_n_even": 2 * (m - 1), "rfft_n_odd": 2 * m - 1}.get(name, m)
    if not z.ids.size or size > LONGEST:
        refuse(f"it calls {name} of so many numbers", final=True)
    # 3 transforms, because most functions also transform back
    z.g.check(15 * z.ids.size // z.ids.shape[-1] * size * size.bit_length())
    if z.kind != "c":
        z = z if z.kind == "f" else z + 0.0
        z = joint(z, constant(z.g, 0.0, z.ids))
    if name == "irfft":  # of a spectrum, whose other half is its conjugate
        z = _resized(z, size // 2 + 1).copy()
        z.imag[..., 0] = 0.0
        if size % 2 == 0:
            z.imag[..., -1] = 0.0
        z = np.concatenate([z, np.conj(z[..., 1 : (size + 1) // 2])[..., ::-1]], axis=-1)
    found: Any = transformed(_resized(z, size), 1.0 if name in ("ifft", "irfft") else -1.0)
    found = (found.real if name == "irfft" else found)[..., :m]
    out[...] = np.moveaxis(found if factor == 1 else found * factor, -1, axis)
    return out


for _name in ("fft", "ifft", "rfft_n_even", "rfft_n_odd", "irfft"):
    OF_ROWS[_name] = functools.partial(transform, _name)
