"""Copies of modules, classes and objects; the functions in them see copies, too."""

import abc
import enum
import functools
import types
from typing import Any

import numpy as np

from ..graph.refusal import Refusal
from ..numpy.stand_ins import IMPURE, PURE, Forbidden, root_of
from ..numpy.super_of_copies import SHADOW_OF
from ..reads.reads import STABLE
from ..symbols.symbolic import Unwritten, refuse
from .kinds import members_of

ATOMS = (type(None), bool, str, bytes, complex, slice, range, frozenset, np.generic, np.dtype)
HOOKS = "__getattribute__", "__subclasshook__"  # hooks that Python would also call on a subclass
LEFT_OUT = (
    "__new__",
    "__init_subclass__",
    "__class_getitem__",
    "__getattribute__",
    "_abc_impl",
)


def module_of(outside, module, row):
    """The stand-in of a module; it copies a member of the module on first use."""
    package = module.__name__.partition(".")[0]
    if package in IMPURE or "random" in module.__name__:
        return Forbidden(module.__name__)
    found = {}

    class Module(Unwritten):
        __slots__ = ()
        __class__: Any = property(lambda _: types.ModuleType)
        __dict__: Any = property(lambda _: refuse("it uses the variables of a module", effect=True))

        def __getattr__(self, name):
            if name not in found:
                inner = outside.reads.step(row, "member", name)
                inner = STABLE if package in PURE else inner
                found[name] = outside.copy(getattr(module, name), inner)
            return found[name]

    return Module()


def _subclass(cls, body):
    return type(cls)(cls.__name__, (cls,), body)


def _of_users(cls):
    return [base for base in cls.__mro__ if root_of(base) not in PURE]


def registers(cls):
    """Whether a class may notice subclasses, by a user's metaclass or by `__init_subclass__`."""
    of_users = _of_users(cls)
    return root_of(type(cls)) not in PURE or any("__init_subclass__" in vars(b) for b in of_users)


def apart_from(outside, cls, row):
    """A class that has copies of another class's functions, without inheriting from the class."""
    made = outside.known(cls)
    if made is not None:
        return made
    home = cls.__module__.partition(".")[0]
    body: dict = {"__class__": property(lambda self: cls)}
    if any("__getattribute__" in vars(base) for base in cls.__mro__[:-1]):
        refuse(f"the class {cls.__name__} has a `__getattribute__` of its own")
    step = outside.reads.step
    for i, base in reversed(list(enumerate(cls.__mro__))):
        if root_of(base).partition(".")[0] != home:
            continue
        of_base = step(row, "base", i)
        for name, value in members_of(outside, base, of_base):
            if name[:2] != "__" and type(value) in (types.FunctionType, property, staticmethod):
                body[name] = _member(outside, name, value, step(of_base, "own", name))

    def missing(self, name):
        if name[:2] == "__":
            raise AttributeError(name)
        refuse(f"it uses `{name}` of the class {cls.__name__}")

    def unchanging(self, name, value):
        refuse(f"it changes an attribute of the class {cls.__name__}", effect=True)

    body |= {"__getattr__": missing, "__setattr__": unchanging}
    return outside.keep(cls, type(cls.__name__, (), body))


def shadow_of(outside, cls, row=None):
    """The shadow of a class: a subclass with copies of the class's members.

    The shadow also inherits from the shadows of the class's bases.  For `super()`, see
    `numpy/super_of_copies.py`.
    """
    made, reads = outside.known(cls), outside.reads
    if made is not None:
        reads.expect(row, "same", cls)
        return made
    for hook in HOOKS:
        if any(hook in vars(base) for base in _of_users(cls)):
            refuse(f"the class {cls.__name__} has a `{hook}` of its own")
    if registers(cls):
        refuse(f"the class {cls.__name__} sees who inherits from it")
    bases = [
        shadow_of(outside, base, reads.step(row, "base", cls.__mro__.index(base)))
        for base in cls.__bases__
        if root_of(base) not in PURE | IMPURE
    ]
    own: dict = {SHADOW_OF: cls} | ({} if hasattr(cls, "__dict__") else {"__slots__": ()})
    try:
        new = type(cls)(cls.__name__, (*bases, cls), own)
    except TypeError:
        refuse(f"it uses the class {cls.__name__}", final=True)
    outside.keep(cls, new)
    if type(cls) not in (type, abc.ABCMeta):
        reads.lasting = False
    itself = reads.step(row, "base", 0)
    above = [name for shadow in new.__mro__[1 : new.__mro__.index(cls)] for name in vars(shadow)]
    for name, value in members_of(outside, cls, itself):
        if name in ("__new__", "__del__"):  # an object made in the call would run the original
            new.__new__ = lambda *_, name=name, **__: refuse(
                f"a class with a `{name}` of its own", effect=name == "__del__"
            )
        elif name not in LEFT_OUT:
            copy = _member(outside, name, value, reads.step(itself, "own", name))
            if copy is not None:
                setattr(new, name, copy)
            elif name in above:  # hides the copy of a base's member
                setattr(new, name, value)
    outside.watched.append(("an attribute of a class", new, dict(vars(new))))
    return new


def _member(outside, name, value, row):
    """The copy of a class's member; None if the member needs no copy."""
    kind, reads = type(value), outside.reads

    def inside(attribute):
        return outside.part(value, row, "inside", attribute)

    if isinstance(value, types.FunctionType):
        return outside.copy(value, row)
    if kind in (staticmethod, classmethod):
        return kind(inside("__func__"))
    if kind is property and value.fget is not None:
        return property(inside("fget"), value.fset and inside("fset"))
    if kind is functools.cached_property:
        return NotCached(inside("func"), reads)
    if name.startswith("__") or kind.__name__ in ("member_descriptor", "getset_descriptor"):
        return None
    if kind in (float, int) or isinstance(value, np.ndarray | list | dict | np.ufunc):
        return outside.copy(value, row)
    if hasattr(kind, "py_func") or callable(value):
        return outside.copy(value, row)
    if not isinstance(value, ATOMS) and not isinstance(value, enum.Enum):
        try:
            return outside.copy(value, row)
        except Refusal:
            return Forbidden(f"an object of type {kind.__name__}", effect=False)
    reads.expect(row, "same", value)
    return None


class NotCached:
    """A cached_property that has no cached value; a cached value is an attribute that hides it."""

    def __init__(self, function, reads):
        self.function, self.reads = function, reads

    def __get__(self, thing, kind=None):
        if thing is None:
            refuse("it uses a cached_property of a class")
        self.reads.lasting = False  # a call in Python would cache the value in the object
        return self.function(thing)


def slots_of(cls):
    return [
        value
        for base in cls.__mro__
        for name, value in vars(base).items()
        if type(value) is types.MemberDescriptorType and name != "__dict__"
    ]


def instance_of(outside, thing, row):
    """A copy of an object: an instance of a shadow class that copies attributes on first use."""
    kind = type(thing)
    plain = kind is types.SimpleNamespace
    of_class = outside.reads.step(row, "class")
    outside.reads.expect(of_class, "same", kind)
    base: Any = kind
    if not plain:
        base = (apart_from if registers(kind) else shadow_of)(outside, kind, of_class)
    own, loaded = getattr(thing, "__dict__", {}), {}
    slots = {slot.__name__ for slot in slots_of(kind)}

    def load(mine, name):
        mine[name] = loaded[name] = outside.part(thing, row, "own", name)

    def __getattribute__(self, name):
        mine = object.__getattribute__(self, "__dict__")
        if name == "__dict__":
            whole = outside.reads.step(row, "member", "__dict__")
            outside.reads.expect(whole, "keys", (dict, list(own)))
            for each in own:
                if each not in loaded:
                    load(mine, each)
            return mine
        if name not in mine and not name.startswith("__"):
            if name in own:
                load(mine, name)
            else:  # a later attribute of the object would hide the class's
                outside.reads.expect(outside.reads.step(row, "own", name), "absent")
        return base.__getattribute__(self, name)

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        if name not in slots and hasattr(base, "__getattr__"):
            return base.__getattr__(self, name)
        if name not in slots or not hasattr(thing, name):
            outside.reads.expect(outside.reads.step(row, "member", name), "absent")
            raise AttributeError(f"'{kind.__name__}' object has no attribute '{name}'")
        return outside.part(thing, row, "member", name)

    def __delattr__(self, name):
        refuse("it deletes an attribute", effect=True)

    body = {"__getattribute__": __getattribute__, "__delattr__": __delattr__}
    if slots and not plain:
        body["__getattr__"] = __getattr__
    try:
        copied = _subclass(base, body)
        made: Any = copied
        new = made() if plain else object.__new__(copied)
    except TypeError:
        refuse(f"it uses an object of type {kind.__name__}", final=True)
    outside.keep(thing, new)
    object.__getattribute__(new, "__dict__").update(loaded)
    outside.watched.append(("an attribute", new, loaded))
    outside.watched.append(("an attribute of a class", copied, dict(vars(copied))))
    return new
