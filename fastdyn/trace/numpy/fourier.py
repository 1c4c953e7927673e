"""Fourier transforms as operations on arrays: each factor of the length gives one pass.

The passes are those of Stockham's algorithm, which needs no bit reversal: C. Van Loan,
"Computational frameworks for the fast Fourier transform" (1992), section 1.7.
"""

from typing import Any

import numpy as np

from ..symbols.arrays import Array
from ..symbols.complex_pair import any_complex
from ..symbols.symbolic import BATCHES, Batched, refuse

FACTORS = 4, 2, 3, 5, 7
LONGEST = 2048, 128  # of long arrays, and of numbers; beyond, compiled code calls the library
FORWARD = {None: 0, "backward": 0, "ortho": 0.5, "forward": 1}  # exponents of 1 / n


def transform(function):
    """The stand-in of `fft`, `ifft`, `rfft` or `irfft` of NumPy or SciPy."""
    name = function.__name__
    inverse = "i" in name

    def of_symbols(a, n=None, axis=-1, norm=None):
        array: Any = a if isinstance(a, Batched) else Array.of(a)
        z: Any = np.moveaxis(array, axis, -1)
        n = int(n or (2 * z.shape[-1] - 2 if name == "irfft" else z.shape[-1]))
        if name == "rfft" and any_complex(z):
            refuse("rfft of complex numbers")
        m = n // 2 + 1 if name == "irfft" else n
        rest = np.zeros((*z.shape[:-1], max(0, m - z.shape[-1])))
        z = np.concatenate([z[..., :m], rest], axis=-1) if rest.size else z[..., :m]
        if name == "irfft":  # the whole spectrum of a real signal
            ends, inner = np.real(z), z[..., 1 : (n + 1) // 2]
            both = ends[..., :1], inner, ends[..., (n + 1) // 2 :], np.conj(inner)[..., ::-1]
            z = np.concatenate(both, axis=-1)
        z = _transformed(z, 1.0 if inverse else -1.0)
        scale = n ** -float(1 - FORWARD[norm] if inverse else FORWARD[norm])
        z = z if scale == 1.0 else scale * z
        z = np.real(z) if name == "irfft" else z[..., : n // 2 + 1] if name == "rfft" else z
        return np.moveaxis(z, -1, axis)

    return of_symbols


def _transformed(z: Any, sign):
    """The sum over k of z[..., k] exp(sign 2 pi i j k / n), for all j."""
    n, rows, m = z.shape[-1], z.shape[:-1], 1  # transforms of length m are done
    z = z.reshape(*rows, 1, n)
    for p in _factors(n, LONGEST[0] if isinstance(z, Batched) else LONGEST[1]):
        q = n // (m * p)
        pieces = [(k, z[..., None, :, k * q : (k + 1) * q]) for k in range(p)]
        inner, outer = np.arange(m).reshape(m, 1), np.arange(p).reshape(p, 1, 1)
        if isinstance(z, Batched):  # one product with p turns, else products by 1, i, -1, -i
            turned = [_turned(v, k * (inner + m * outer), p * m, sign) for k, v in pieces]
        else:
            turned = [
                _turned(_turned(v, k * inner, p * m, sign), k * outer, p, sign) for k, v in pieces
            ]
        z, m = sum(turned[1:], turned[0]), m * p
        z = (BATCHES["side by side"](z) if isinstance(z, Batched) else z).reshape(*rows, m, q)
    return z.reshape(*rows, n)


def _factors(n, most):
    """The factors of a length, from FACTORS."""
    found, left = [], n
    for p in FACTORS:
        while left % p == 0:
            found.append(p)
            left //= p
    if left > 1 or not 1 < n <= most:
        refuse(f"a Fourier transform of {n} numbers", final=n > most)
    return found


def _turned(z, k, n, sign):
    """z exp(sign 2 pi i k / n); exact where k / n is a multiple of 1 / 4."""
    if not np.any(k):
        return z
    turn, exact = np.exp(sign * 2j * np.pi * (k % n) / n), 4 * k % n == 0
    turn[exact] = np.round(turn[exact])
    return z * turn


TRANSFORMS = {f: transform(f) for f in (np.fft.fft, np.fft.ifft, np.fft.rfft, np.fft.irfft)}
