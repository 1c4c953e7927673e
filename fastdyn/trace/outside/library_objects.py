"""Classes without functions, used without a copy, and objects of libraries, copied whole."""

import types
from copy import deepcopy

import numpy as np

from ..numpy.stand_ins import IMPURE, PURE, root_of
from ..symbols.symbolic import refuse
from .copies import ATOMS
from .kinds import members_of


def library_object(outside, value):
    """A deep copy of a library's object, watched for changes of attributes and arrays."""
    if isinstance(value, types.FunctionType | types.BuiltinFunctionType | type):
        return value
    try:
        new = deepcopy(value)
    except Exception:
        refuse(f"it uses an object of type {type(value).__name__}", final=True)
    outside.watched.append(("an attribute", new, dict(vars(new))))
    for part in vars(new).values():
        if isinstance(part, np.ndarray):
            outside.watched.append(("an array", part, list(part.flat)))
    return outside.keep(value, new)


def class_of_data(outside, cls, row):
    """Use a class without functions directly; its attributes become constants of the code."""
    for i, base in enumerate(cls.__mro__):
        if root_of(base) in PURE | IMPURE:
            continue
        of_base = outside.reads.step(row, "base", i)
        for name, value in members_of(outside, base, of_base):
            if name.startswith("__"):
                continue
            if isinstance(value, types.GetSetDescriptorType | types.MemberDescriptorType):
                continue
            if not isinstance(value, (*ATOMS, int, float)):
                refuse(f"an attribute of the class {cls.__name__}", final=True)
            outside.reads.expect(outside.reads.step(of_base, "own", name), "equal", value)
        outside.watched.append(("an attribute of a class", base, Attributes(base)))
    return outside.keep(cls, cls)


class Attributes(dict):
    """The attributes of a user's class; `give_back` restores them after a run has changed them."""

    def __init__(self, cls):
        super().__init__(vars(cls))
        self._cls = cls

    def give_back(self):
        for name in vars(self._cls).keys() - self.keys():
            delattr(self._cls, name)
        for name, value in self.items():
            if vars(self._cls).get(name) is not value:
                setattr(self._cls, name, value)
