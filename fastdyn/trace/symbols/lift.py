"""Numbers and arrays of any kind as symbols."""

import contextlib
import operator
from fractions import Fraction
from typing import Any

import numpy as np

from ..graph.rows import ID, PAIR
from .symbol import DTYPES, HANDLERS, Symbol, is_symbolic, refuse

WHOLE_TYPES = frozenset((*DTYPES.values(), np.dtype(object)))  # types that symbols can have


def symbol(g, value, py=None) -> Any:
    """Any number or array as a Symbol; refuse what is no number."""
    kind = type(value)
    if kind is Symbol:
        return value
    if kind is float:
        return Symbol(g, g.const(value).key, "f", True)
    if isinstance(value, bool | np.bool_):
        return Symbol(g, g.const(bool(value)).key, "b", kind is bool)
    if isinstance(value, int | np.integer):
        if abs(int(value)) > 2**53 and int(float(value)) != int(value):
            refuse("a whole number beyond 2**53")
        with contextlib.suppress(OverflowError):
            return Symbol(g, g.const(float(value)).key, "i", isinstance(value, int))
        refuse("a whole number beyond the range of floats")
    if isinstance(value, np.inexact) and kind not in (np.float64, np.complex128):
        refuse(f"a number of {value.dtype} beside what depends on the state")
    if isinstance(value, float | np.floating | Fraction):
        return Symbol(g, g.const(float(value)).key, "f", not isinstance(value, np.generic))
    if isinstance(value, complex | np.complexfloating):
        pair = g.const(float(value.real)).key, g.const(float(value.imag)).key
        return Symbol(g, pair, "c", kind is complex)
    if isinstance(value, np.ndarray):
        return _of_array(g, value)
    if isinstance(value, list | tuple | range):
        return _of_list(g, value)
    return refuse(f"a {kind.__name__} where a number is needed")


def _of_array(g, array):
    if array.dtype not in WHOLE_TYPES:
        refuse(f"an array of {array.dtype} beside what depends on the state")
    if array.dtype.kind == "c":
        ids = np.empty_like(array, PAIR, subok=False)
        ids["real"], ids["imag"] = g.constants(array.real), g.constants(array.imag)
        return Symbol(g, ids, "c")
    if array.dtype.kind == "O":
        found = _of_list(g, list(array.flat))
        return found.view_of(found.ids.reshape(array.shape))
    kind = array.dtype.kind
    return Symbol(g, g.constants(array), "i" if kind in "iu" else kind)


def _of_list(g, values):
    if not is_symbolic(list(values)):
        array = np.array(values)
        if array.dtype.kind not in "iufbc":
            refuse("an array of other things than numbers")
        return _of_array(g, array)
    each = [symbol(g, v) for v in values]
    shapes = {np.shape(s.ids) if s.many else () for s in each}
    if len(shapes) > 1:
        raise ValueError(
            "setting an array element with a sequence. The requested array has an inhomogeneous "
            "shape after 1 dimensions."
        )
    kind = common_kind({s.kind for s in each})
    ids = [HANDLERS["cast"](g, s, kind, "unsafe") for s in each]
    return Symbol(g, np.array(ids, PAIR if kind == "c" else ID), kind)


def common_kind(kinds):
    """The kind of an array that is made of numbers of several kinds."""
    return next((kind for kind in "cfib" if kind in kinds), "f")


def joint(real, imag) -> Any:
    """A complex symbol from its real and imaginary part."""
    g = real.g
    if not real.many and not imag.many:
        return Symbol(g, (real.ids, imag.ids), "c", real.py and imag.py)
    like = max(real.ids, imag.ids, key=np.size)
    ids = np.empty_like(like, PAIR, shape=np.broadcast_shapes(*map(np.shape, (real.ids, imag.ids))))
    ids["real"], ids["imag"] = real.ids, imag.ids
    return Symbol(g, ids, "c")


def number(value) -> Any:
    """The element of an array of one element; any other value unchanged."""
    if type(value) is Symbol:
        return value.single() if value.many and value.ids.size == 1 else value
    return value.item() if isinstance(value, np.ndarray) and value.size == 1 else value


def index(value):
    """A plain whole number, of a symbol by `__index__`."""
    return operator.index(value)
