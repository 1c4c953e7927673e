"""Functions that write places (attributes, items, arrays, globals) before they read them.

The value of such a function does not depend on the former content of the places.  The function is
traced twice.  The first trace finds the places.  In the second trace, each place holds an
`Unwritten`, which refuses every use.
"""

from typing import Any

import numpy as np

from ..symbols.lazy import Unasked
from ..symbols.symbolic import refuse
from .changes import changed
from .copies import slots_of


class Unwritten(Unasked):
    """The content of a place before the function has written to it; it refuses every use."""

    __slots__ = ()

    def __init__(self):
        super().__init__(None)

    def _refused(self, *_, **__) -> Any:
        refuse("it uses what a call before has left", effect=True)

    shape = ndim = size = dtype = real = imag = property(_refused)
    number = item = squeeze = copy = flatten = ravel = _refused
    __copy__ = __deepcopy__ = __getitem__ = __setitem__ = __call__ = __iter__ = __len__ = _refused
    __contains__ = __array_ufunc__ = __array_function__ = __repr__ = __format__ = _refused
    __bool__ = __float__ = __int__ = __index__ = __enter__ = __next__ = _refused
    add = property(_refused)

    def __getattr__(self, name):
        self._refused()


for _name in (
    "add radd sub rsub mul rmul truediv rtruediv floordiv rfloordiv mod rmod pow rpow neg pos abs "
    "lt le gt ge eq ne round invert and rand or ror xor rxor complex hash matmul rmatmul"
).split():
    setattr(Unwritten, f"__{_name}__", Unwritten._refused)
UNWRITTEN = Unwritten()


class Stores:
    """The places that a function writes to, as (id of the owner, kind, name).

    With `places`, `note` checks that each path writes to exactly these places.
    """

    def __init__(self, places=()):
        self.known, self.places = bool(places), set(places)

    def note(self, outside):
        """Add the places that a run wrote to; return False if they differ from the given places."""
        found = _places(outside)
        if found is None or self.known:
            return found == self.places
        self.places |= found
        return True

    def of(self, thing, kind):
        """The names of an object's places that the function writes before it reads them."""
        if not self.known:
            return []
        return [name for owner, k, name in self.places if owner == id(thing) and k == kind]


def _places(outside):
    """The places that a run has written to; None if a write has no place with a name."""
    found, things = set(), {id(copy): thing for thing, copy in outside.pairs()}
    scopes = {id(names): outer for outer, (names, _) in outside.functions.scopes()}
    for what, copy, before in outside.watched:
        if not changed(copy, before):
            continue
        if what == "a global variable":
            names, owner = _names(copy, before), scopes[id(copy)]
        elif what in ("an attribute", "a dict", "a list", "an array") and id(copy) in things:
            names, owner = _names(copy, before), id(things[id(copy)])
        else:
            return None
        if names is None:
            return None
        found |= {(owner, what, name) for name in names}
    return found


def _names(copy, before):
    if isinstance(copy, np.ndarray):
        whole = copy.shape == np.shape(copy) and not any(v is UNWRITTEN for v in copy.flat)
        return ["all"] if whole else None
    if isinstance(copy, list):
        if len(copy) != len(before):
            return None
        return [i for i, (a, b) in enumerate(zip(list(copy), before, strict=True)) if a is not b]
    if not isinstance(copy, dict):
        if any(True for slot in slots_of(type(copy))):
            return None
        copy = object.__getattribute__(copy, "__dict__")
    if before.keys() - copy.keys():
        return None
    return [k for k, v in copy.items() if k not in before or before[k] is not v]
