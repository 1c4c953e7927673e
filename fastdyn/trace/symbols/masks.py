"""Selections by a mask that depends on the state."""

from .symbolic import refuse


class Masked:
    """``a[mask]`` with a mask of Conditions, only for statements ``out[mask] = f(a[mask])``."""

    def __init__(self, whole, mask):
        self.whole, self.mask = whole, mask

    def __array_ufunc__(self, ufunc, method, *args, **kwargs):
        if method != "__call__" or kwargs:
            refuse("a selection by a mask of the state")
        return Masked(ufunc(*[_whole(a) for a in args]), self.mask)

    def __getattr__(self, name):
        refuse("a selection by a mask of the state")


def _operation(name):
    def method(self, *others):
        return Masked(getattr(self.whole, name)(*map(_whole, others)), self.mask)

    return method


for _name in "add radd sub rsub mul rmul truediv rtruediv pow rpow neg abs".split():
    setattr(Masked, f"__{_name}__", _operation(f"__{_name}__"))


def _whole(value):
    return value.whole if isinstance(value, Masked) else value
