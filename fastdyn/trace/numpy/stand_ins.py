"""The objects that replace library functions during a trace, and objects that a trace refuses."""

import bisect
import builtins
import cmath
import logging
import math
import sys
from typing import Any

import numpy as np

from ..symbols.arrays import look_up
from ..symbols.complex_functions import CMATH
from ..symbols.symbolic import Symbolic, refuse
from .builtins import BUILTINS, MATH, bool_of, impure, vectorized
from .calls import call_function
from .functions import INDEXED
from .interpolation import bisected

PURE = set(
    "numpy scipy builtins math cmath numba operator _operator functools itertools collections "
    "numbers abc types typing copy enum dataclasses fractions statistics string re "
    "bisect".split()
)
IMPURE = (set(sys.stdlib_module_names) - PURE) | {"matplotlib", "pandas", "tqdm", "IPython"}


class NumPyFunction:
    """A NumPy function that accepts lists of symbols and returns arrays that can hold symbols."""

    def __init__(self, function):
        self._function = function

    def __call__(self, *args, **kwargs):
        if "dtype" in kwargs:
            kwargs["dtype"] = _plain_type(kwargs["dtype"])
        return call_function(self._function, tuple(map(_plain_type, args)), kwargs)

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._function, name)


def _plain_type(value) -> Any:
    """The original of a type that has a stand-in; any other value unchanged."""
    known = value is bool_of or isinstance(value, type)
    return getattr(value, "plain", value) if known else value


class Forbidden:
    """An object that refuses every use, because a use has side effects or gives other results."""

    def __init__(self, name, effect=True):
        object.__setattr__(self, "_why", (f"it uses {name}", effect))

    def _refused(self, *_, **__) -> Any:
        why, effect = self._why
        refuse(why, final=True, effect=effect, alive="weakref" in why)

    __getattr__ = __iter__ = __next__ = __call__ = __getitem__ = __enter__ = _refused
    __setattr__ = __setitem__ = __bool__ = __len__ = __eq__ = __contains__ = __iter__
    __hash__ = object.__hash__


class Quiet:
    """A user's logger; it refuses a call that writes to the log."""

    def __init__(self, logger):
        self._logger = logger

    def __getattr__(self, name):
        level = logging.getLevelNamesMapping().get(name.upper())
        if level is None or self._logger.isEnabledFor(level):
            refuse("it writes to a log", effect=True)
        return lambda *_, **__: None


class _Indexed:
    def __getitem__(self: Any, i) -> Any:
        if isinstance(i, Symbolic):
            return look_up(list(self), i)
        found = super().__getitem__(i)  # pyright: ignore
        return type(self)(found) if isinstance(i, slice) else found


class List(_Indexed, list):
    """A list that accepts a symbol as an index."""


class Tuple(_Indexed, tuple):
    """A tuple that accepts a symbol as an index."""


STAND_INS: dict[int, Any] = {
    id(getattr(module, name)): NumPyFunction(function)
    for module in (np, np.linalg, np.fft)
    for name, function in vars(module).items()
    if callable(function) and not isinstance(function, type) and name[0] != "_"
}


def _error_state(**how):
    """np.errstate."""
    if not {"ignore", "warn", None}.issuperset(how.values()):
        refuse("NumPy's errors as exceptions", final=True)
    return np.errstate(**how)


def _seterr(*_, **__):
    refuse("it changes how NumPy treats errors", effect=True)


def _geterr(*_, **__):
    refuse("it asks how NumPy treats errors", final=True)


STAND_INS |= INDEXED
STAND_INS |= {id(np.errstate): _error_state, id(np.seterr): _seterr, id(np.geterr): _geterr}
STAND_INS[id(np.vectorize)] = vectorized
OF_FILES = (
    np.save, np.savez, np.savez_compressed, np.savetxt,
    np.load, np.loadtxt, np.genfromtxt, np.fromfile,
)  # fmt: skip
STAND_INS |= {id(each): impure(f"numpy.{each.__name__}") for each in OF_FILES}
STAND_INS |= {id(getattr(math, name)): function for name, function in MATH.items()}
STAND_INS |= {id(getattr(cmath, name)): function for name, function in CMATH.items()}
STAND_INS[id(bisect.bisect_left)] = bisected(bisect.bisect_left, "left")
STAND_INS[id(bisect.bisect_right)] = bisected(bisect.bisect_right, "right")
STAND_INS |= {id(getattr(builtins, name)): function for name, function in BUILTINS.items()}


def root_of(thing):
    """The top-level package named by ``__module__``."""
    return (getattr(thing, "__module__", None) or "").partition(".")[0]
