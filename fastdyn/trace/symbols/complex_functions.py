"""Elementary functions of complex numbers, as formulas of real functions; principal values."""

import cmath
from typing import Any

import numpy as np

from .complex_pair import Pair, is_complex, parts
from .conditions import select
from .symbolic import is_symbolic, refuse


def _phase(z):
    return np.arctan2(z.imag, z.real)


def _exp(z):
    size = np.exp(z.real)
    return Pair(size * np.cos(z.imag), size * np.sin(z.imag))


def _log(z):
    return Pair(np.log(abs(z)), _phase(z))


def _sqrt(z):
    """The root with real part u >= 0, computed without cancellation."""
    u = np.sqrt((abs(z) + abs(z.real)) * 0.5)
    v = select(u == 0, 0.0, z.imag / (2.0 * u))
    right = z.real >= 0
    return Pair(select(right, u, abs(v)), select(right, v, np.copysign(u, z.imag)))


def _sinh(z):
    a, b = z.real, z.imag
    return Pair(np.sinh(a) * np.cos(b), np.cosh(a) * np.sin(b))


def _cosh(z):
    a, b = z.real, z.imag
    return Pair(np.cosh(a) * np.cos(b), np.sinh(a) * np.sin(b))


def _sin(z):
    a, b = z.real, z.imag
    return Pair(np.sin(a) * np.cosh(b), np.cos(a) * np.sinh(b))


def _cos(z):
    a, b = z.real, z.imag
    return Pair(np.cos(a) * np.cosh(b), -(np.sin(a) * np.sinh(b)))


def power(base, exponent):
    """base ** exponent for complex numbers; products for a small integer exponent."""
    if not is_complex(exponent) and not is_symbolic(exponent) and exponent == int(exponent):
        if abs(exponent) <= 16:
            result = Pair(1.0, 0.0)
            for _ in range(abs(int(exponent))):
                result = result * base
            return result if exponent >= 0 else 1.0 / result
    base = Pair(*parts(base))
    found = _exp(_log(base) * exponent)
    positive = parts(exponent)[0] > 0
    at_zero = (
        select(positive, 0.0, np.nan) if is_symbolic(positive) else 0.0 if positive else np.nan
    )
    zero = (base.real == 0) & (base.imag == 0)
    return Pair(*(select(zero, at_zero, part) for part in (found.real, found.imag)))


FUNCTIONS: dict[str, Any] = {  # by NumPy's names
    "absolute": abs, "abs": abs, "fabs": abs, "conjugate": Pair.conjugate, "conj": Pair.conjugate,
    "square": lambda z: z * z, "reciprocal": lambda z: 1.0 / z, "exp": _exp, "log": _log,
    "sqrt": _sqrt, "sin": _sin, "cos": _cos, "sinh": _sinh, "cosh": _cosh,
    "tan": lambda z: _sin(z) / _cos(z), "tanh": lambda z: _sinh(z) / _cosh(z),
    "log10": lambda z: _log(z) / np.log(10.0), "log2": lambda z: _log(z) / np.log(2.0),
    "exp2": lambda z: _exp(z * np.log(2.0)), "expm1": lambda z: _exp(z) - 1.0,
    "isnan": lambda z: np.isnan(z.real) | np.isnan(z.imag),
    "isfinite": lambda z: np.isfinite(z.real) & np.isfinite(z.imag),
}  # fmt: skip


def of_complex(name):
    """NumPy's function `name` of one complex number."""

    def function(z, *others):
        if others or name not in FUNCTIONS:
            refuse(f"{name} of complex numbers")
        return FUNCTIONS[name](Pair(*parts(z)))

    return function


def _of_cmath(name, plain):
    own = {"phase": _phase, "polar": lambda z: (abs(z), _phase(z))}.get(name)

    def function(*values):
        if not is_symbolic(values):
            return plain(*values)
        if name == "log" and len(values) == 2:
            return of_complex("log")(values[0]) / of_complex("log")(values[1])
        if name == "rect":
            size, angle = values
            return Pair(size * np.cos(angle), size * np.sin(angle))
        z = Pair(*parts(values[0]))
        return own(z) if own else of_complex(name)(z)

    return function


CMATH = {
    name: _of_cmath(name, function)
    for name, function in vars(cmath).items()
    if callable(function) and name[0] != "_"
}


def made(real: Any = 0.0, imag: Any = 0.0):
    """complex(real, imag), where the arguments may themselves be complex."""
    if not is_symbolic([real, imag]):
        return complex(real, imag)
    (a, b), (c, d) = parts(real), parts(imag)
    return Pair(a - d if is_complex(imag) else a, b + c if is_complex(real) else c)
