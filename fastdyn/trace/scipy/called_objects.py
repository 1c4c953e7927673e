"""Objects of SciPy whose methods compiled code calls, as islands.

The objects are matrix factors, distributions, linear systems, and interpolators of several
variables.
"""

import copy
import types
from typing import Any

import numpy as np

from ..islands.calls import apart
from ..numpy.plain_arrays import lowered, raised
from ..symbols.lazy import complete
from ..symbols.symbolic import Unwritten, is_symbolic, refuse
from .parts import NUMBERS, handed_out

PURE = frozenset(
    "__call__ solve ev integral pdf logpdf cdf logcdf sf logsf ppf isf pmf logpmf mean var std "
    "median moment evaluate matvec".split()
)
OF_SPLINES = frozenset("derivative antiderivative partial_derivative".split())
PACKAGES = "scipy.interpolate", "scipy.stats", "scipy.sparse.linalg", "scipy.signal"


def is_known(value):
    """Whether the methods of an object can be islands."""
    module = type(value).__module__ or ""
    known = module.startswith(PACKAGES) or is_factor(type(value))
    return known and not isinstance(value, type | types.FunctionType)


def is_factor(kind):
    """Whether a type is SciPy's type of sparse LU factors."""
    return kind.__name__ == "SuperLU"


def content_of(value):
    """The names of the attributes of an object that hold numbers; numbers may change."""
    own = getattr(value, "__dict__", {})
    if _is_distribution(value):
        return ()
    return tuple(name for name, part in own.items() if _holds_numbers(part))


def _is_distribution(value):
    return hasattr(value, "rvs") and hasattr(value, "numargs")  # not a frozen distribution


def _holds_numbers(part):
    if isinstance(part, tuple):
        return all(map(_holds_numbers, part))
    return isinstance(part, NUMBERS | np.ndarray) or type(part) is dict


def kept(part):
    """The current content of an attribute, for a later comparison; a dict is copied."""
    return copy.copy(part) if type(part) is dict else part


class Object(Unwritten):
    """The stand-in of an object of SciPy; `watched` collects the arrays that a run may change."""

    _original: Any
    _watched: Any

    def __init__(self, original, watched):
        vars(self).update(_original=original, _watched=watched)

    def __call__(self, *args, **kwargs):
        return self._called("__call__", args, kwargs)

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        if name in PURE | OF_SPLINES:
            return lambda *args, **kwargs: self._called(name, args, kwargs)
        part, content = getattr(self._original, name), content_of(self._original)
        returns_its_own = f"_{name}" in content and part is getattr(self._original, f"_{name}")
        if name not in content and not returns_its_own:
            refuse(f"it uses `{name}` of an object of type {type(self._original).__name__}")
        return handed_out(part, self._watched)

    def _called(self, name, args, kwargs):
        args, kwargs = complete(args), {k: complete(v) for k, v in kwargs.items()}
        if not hasattr(type(self._original), name):
            getattr(self._original, name)  # raises AttributeError
        method = getattr(self._original, name)
        if is_symbolic([*args, *kwargs.values()]):
            if name in OF_SPLINES:
                refuse(f"{name} of a spline, with arguments that depend on the state")
            return apart(method, args, kwargs, name, (self._original, name))
        named = {k: lowered(v) for k, v in kwargs.items()}
        found = method(*map(lowered, args), **named)
        return Object(found, self._watched) if name in OF_SPLINES else raised(found)
