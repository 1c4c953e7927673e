"""Elements that become symbols on first use."""

from typing import Any

from .symbolic import Lazy, Symbolic, refuse


class Unasked(Symbolic):
    """The placeholder of an element that no run has used; the placeholder refuses every use."""

    __slots__ = ("g",)

    def __init__(self, g):
        self.g = g

    def _refused(self, *_, **__) -> Any:
        refuse("an element of a long array, in a way that is not known")

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        self._refused()

    number = item = __bool__ = __float__ = __int__ = __index__ = _refused


for _name in (
    "add radd sub rsub mul rmul truediv rtruediv floordiv rfloordiv mod rmod pow rpow neg pos abs "
    "lt le gt ge eq ne round invert and rand or ror xor rxor complex hash"
).split():
    setattr(Unasked, f"__{_name}__", Unasked._refused)


def complete(value) -> Any:
    """Fill in all elements of a lazy value, also inside lists and tuples."""
    if isinstance(value, Lazy):
        return value.filled()
    if type(value) in (list, tuple) and any(isinstance(v, Lazy | list | tuple) for v in value):
        return type(value)(map(complete, value))
    return value
