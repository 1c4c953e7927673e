"""Selections by a mask that depends on the state."""

from typing import Any

import numpy as np

from .symbol import Symbol, refuse

WHY = "a selection by a mask of the state"


class Masked(np.lib.mixins.NDArrayOperatorsMixin):
    """``a[mask]`` with a mask that has the shape of `a`: a copy, whose length no trace knows.

    Elementwise functions combine a selection with numbers and with selections by an equal mask; the
    statement ``b[mask] = selection`` stores the selection.  The selection refuses all else, also
    what Python and NumPy would answer with an exception for the user's handlers.

    Attributes
    ----------
    whole : Symbol
        The numbers at all places, selected or not.
    mask : Symbol
    """

    mask_of_state = True  # see `symbol.graph_of`
    __class__: Any = property(lambda self: np.ndarray)  # for isinstance(_, np.ndarray)
    __hash__: Any = None

    def __init__(self, array, mask):
        if mask.ids.shape != array.ids.shape:
            refuse("a mask of the state of another shape than the array")
        self.whole, self.mask = array.copy(), mask.copy()

    def __array_ufunc__(self, ufunc, method, *args, out=None, **kwargs):
        if method != "__call__" or kwargs or ufunc.signature is not None or ufunc.nout != 1:
            refuse(WHY)
        result = ufunc(*[chosen(self.mask, each) for each in args])
        if out is None:
            return Masked(result, self.mask)
        if out[0] is not self or result.dtype != self.whole.dtype:
            refuse(WHY)
        self.whole = result
        return self

    def _refused(self, *_, **__) -> Any:
        refuse(WHY)

    __array__ = __array_function__ = __len__ = __iter__ = __getitem__ = __setitem__ = _refused
    __contains__ = __bool__ = __float__ = __int__ = __index__ = __complex__ = __round__ = _refused
    __reduce__ = __reduce_ex__ = __copy__ = __deepcopy__ = __repr__ = __format__ = _refused

    def __getattr__(self, name):
        refuse(WHY)


def chosen(mask, value):
    """The operand that stands for `value` in an operation on the elements that a mask selects.

    The value is a number, or a selection by an equal mask: then its numbers at all places.
    """
    if type(value) is Masked:
        if value.mask.ids.shape != mask.ids.shape or (value.mask.ids != mask.ids).any():
            refuse("selections by two different masks of the state")
        return value.whole
    many = value.many if type(value) is Symbol else np.ndim(value) > 0
    if many:
        refuse("an array beside a selection by a mask of the state")
    return value
