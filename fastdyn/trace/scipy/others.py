"""Further objects of SciPy: matrix factors, distributions, interpolators of several variables.

Compiled code calls the methods of these objects as islands.
"""

import copy
import types

import numpy as np

from ..islands.calls import apart
from ..numpy.plain_arrays import lowered, raised
from ..symbols.lazy import complete
from ..symbols.symbolic import is_symbolic, refuse

PURE = frozenset(
    "__call__ solve ev integral pdf logpdf cdf logcdf sf logsf ppf isf pmf logpmf mean var std "
    "median moment evaluate matvec".split()
)
OF_SPLINES = frozenset("derivative antiderivative partial_derivative".split())
PACKAGES = "scipy.interpolate", "scipy.stats", "scipy.sparse.linalg"
NUMBERS = bool | int | float | complex | str | np.ndarray | np.generic | None


def is_known(value):
    """Whether the methods of an object can be islands."""
    module = type(value).__module__ or ""
    known = module.startswith(PACKAGES) or is_factor(type(value))
    return known and not isinstance(value, type | types.FunctionType)


def is_factor(kind):
    """Whether a type is SciPy's type of sparse LU factors."""
    return kind.__name__ == "SuperLU"


def content_of(value):
    """The names of an object's attributes that hold numbers, and so may change."""
    own = getattr(value, "__dict__", {})
    if _is_distribution(value):
        return ()
    return tuple(name for name, part in own.items() if _holds_numbers(part))


def _is_distribution(value):
    return hasattr(value, "rvs") and hasattr(value, "numargs")  # not a frozen one


def _holds_numbers(part):
    if isinstance(part, tuple):
        return all(map(_holds_numbers, part))
    return isinstance(part, NUMBERS) or type(part) is dict


def kept(part):
    """The current content of an object's part, for a later comparison."""
    return copy.copy(part) if type(part) is dict else part


class Object:
    """The stand-in of an object of SciPy."""

    def __init__(self, original):
        self._original = original

    def __call__(self, *args, **kwargs):
        return self._called("__call__", args, kwargs)

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        if name in PURE | OF_SPLINES:
            return lambda *args, **kwargs: self._called(name, args, kwargs)
        part = getattr(self._original, name)
        if name not in content_of(self._original):
            refuse(f"it uses `{name}` of an object of type {type(self._original).__name__}")
        return raised(np.copy(part) if isinstance(part, np.ndarray) else part)

    def _called(self, name, args, kwargs):
        args, kwargs = complete(args), {k: complete(v) for k, v in kwargs.items()}
        if not hasattr(type(self._original), name):
            getattr(self._original, name)  # raises AttributeError
        method = getattr(self._original, name)
        if is_symbolic([*args, *kwargs.values()]):
            if name in OF_SPLINES:
                refuse(f"{name} of a spline by what depends on the state")
            return apart(method, args, kwargs, name, (self._original, name))
        named = {k: lowered(v) for k, v in kwargs.items()}
        found = method(*map(lowered, args), **named)
        return Object(found) if name in OF_SPLINES else raised(found)
