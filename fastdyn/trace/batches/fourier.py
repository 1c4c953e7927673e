"""Fourier transforms of long arrays: each factor of the length gives one pass over the array.

The passes are those of Stockham's algorithm, which needs no bit reversal: C. Van Loan,
"Computational frameworks for the fast Fourier transform" (1992), section 1.7.
"""

import sys
from typing import Any

import numpy as np

from ..islands.calls import apart
from ..symbols.symbolic import NOW, refuse
from .formulas import as_complex
from .products import side_by_side

FACTORS = 4, 2, 3, 5, 7
SHORTEST, LONGEST = 32, 2048  # for other lengths, compiled code calls the library
NORMS = {None: (0.0, 1.0), "backward": (0.0, 1.0), "ortho": (0.5, 0.5), "forward": (1.0, 0.0)}


def _factors(n):
    """The factors of a length, from FACTORS; an empty list if another prime factor is left."""
    found = []
    for p in FACTORS:
        while n % p == 0:
            found.append(p)
            n //= p
    return found if n == 1 else []


def transformed(z: Any, sign):
    """The sum over k of z[..., k] exp(sign 2 pi i j k / n), for all j."""
    n, rows = z.shape[-1], z.shape[:-1]
    z, m = z.reshape(*rows, 1, n), 1  # transforms of length m are done
    for p in _factors(n):
        q = n // (m * p)
        parts = [z[..., None, :, k * q : (k + 1) * q] for k in range(p)]
        places = np.arange(p * m).reshape(p, m, 1)
        terms = [part * _turn(k * places, p * m, sign) for k, part in enumerate(parts) if k]
        z = sum(terms, parts[0])
        m *= p
        z = side_by_side(z).reshape(*rows, m, q)
    return z.reshape(*rows, n)


def _turn(k, n, sign):
    """exp(sign 2 pi i k / n); exact where k / n is a multiple of 1 / 4."""
    found = np.exp(sign * 2j * np.pi * (k % n) / n)
    exact = 4 * k % n == 0
    found[exact] = np.round(found[exact])
    return found


def _of_rows(name, z: Any, n) -> Any:
    """The transform of length n along the last axis, without the factor of `norm`."""
    inverse = name[0] == "i"
    if name == "irfft":
        m = n // 2 + 1
        half = _resized(z, m)
        rest = np.conj(half[..., 1 : (n + 1) // 2])[..., ::-1]
        half = half.copy()
        half.imag[..., 0] = 0.0
        if n % 2 == 0:
            half.imag[..., -1] = 0.0
        z = np.concatenate([half, rest], axis=-1)
    found = transformed(_resized(z, n), 1.0 if inverse else -1.0)
    if name == "irfft":
        return found.real
    return found[..., : n // 2 + 1] if name == "rfft" else found


def _resized(z, n) -> Any:
    if z.shape[-1] >= n:
        return z[..., :n]
    zeros = np.zeros((*z.shape[:-1], n - z.shape[-1]))
    return np.concatenate([z, zeros], axis=-1)


def transform(function):
    """The stand-in of a transform along one axis.

    If a length is no product of FACTORS or is out of range, compiled code calls the library.
    """
    name = function.__name__

    def of_arrays(a, n=None, axis=-1, norm=None, **more):
        if any(v is not None and v is not False for v in more.values()):
            refuse(f"{name} with options")
        z = as_complex(NOW.table, a)
        size = z.shape[axis] if n is None else int(n)
        if n is None and name == "irfft":
            size = 2 * (size - 1)
        if not SHORTEST <= size <= LONGEST or not _factors(size) or norm not in NORMS:
            return apart(function, (a, n, axis, norm), {})
        found = _of_rows(name, _last(z, axis), size)
        scale = size ** -NORMS[norm][name[0] == "i"]
        return _last(found if scale == 1.0 else found * scale, axis, back=True)

    return of_arrays


def _last(array, axis, back=False):
    """An array with `axis` moved to the end, or the last axis moved back to `axis`."""
    if axis in (-1, array.ndim - 1):
        return array
    order = list(range(array.ndim))
    order.insert(axis % array.ndim, order.pop()) if back else order.append(order.pop(axis))
    return array.transpose(*order)


def over_axes(function, one):
    """The stand-in of a transform along several axes, made of the transform `one` along an axis."""
    of_one = transform(one)

    def of_arrays(a, s=None, axes=None, norm=None, **more):
        if any(v is not None and v is not False for v in more.values()):
            refuse(f"{function.__name__} with options")
        axes = (-2, -1) if axes is None and function.__name__.endswith("2") else axes
        if s is not None:
            return apart(function, (a, s, axes, norm), {})
        for axis in range(np.ndim(a)) if axes is None else axes:
            a = of_one(a, None, axis, norm)
        return a

    return of_arrays


ALONG_ONE = "fft", "ifft", "rfft", "irfft"
OVER_SEVERAL = {"fft2": "fft", "fftn": "fft", "ifft2": "ifft", "ifftn": "ifft"}


def fourier(function):
    """The stand-in of a Fourier transform on long arrays; None for any other function."""
    module, name = getattr(function, "__module__", ""), getattr(function, "__name__", "")
    library = {"numpy.fft": np.fft, "scipy.fft": sys.modules.get("scipy.fft")}
    known = next((m for start, m in library.items() if module.startswith(start)), None)
    if known is None:
        return None
    if name in ALONG_ONE:
        return transform(function)
    if name in OVER_SEVERAL:
        return over_axes(function, getattr(known, OVER_SEVERAL[name]))
    return None
