"""Modules, classes and objects as a traced function sees them.

A user's class gets a shadow: a class of the same members over the shadows of its bases, which does
not inherit from the class itself.  An object gets an instance of the shadow of its class.  Members
and attributes are wrapped when they are first read.
"""

import collections
import enum
import functools
import types
from typing import Any

from ..functions.stand_ins import IMPURE, PURE, Forbidden, root_of
from ..reads.program import as_base
from ..symbols.symbol import refuse

HEAP = 1 << 9  # the flag of types that were made in Python
OF_NAMED_TUPLES = vars(collections.namedtuple("Any", "a")).keys() - {"a", "__doc__", "__slots__"}
BASES = (object, list, tuple, dict, types.SimpleNamespace)  # of objects that have a shadow
REFUSED = ("__getattribute__", "__subclasshook__")  # hooks that read more than a member
LEFT_OUT = {
    "__init_subclass__", "__del__", "__slots__", "__dict__", "__weakref__", "_abc_impl",
    "__abstractmethods__", "__class__",
}  # fmt: skip
FUNCTIONS = (types.FunctionType, staticmethod, classmethod, property, functools.cached_property)
OF_C = (types.GetSetDescriptorType, types.MemberDescriptorType)


def is_instance(value, kind):
    """Whether a value is an object of a user's class, or a namespace."""
    if isinstance(value, types.SimpleNamespace):
        return True
    simple = not isinstance(value, type | types.ModuleType | enum.Enum)
    return bool(kind.__flags__ & HEAP and simple and root_of(kind) not in PURE | IMPURE)


def module_of(outside, module, row):
    """The stand-in of a module; a member is wrapped when it is first read."""
    package = module.__name__.partition(".")[0]
    if package in IMPURE or "random" in module.__name__:
        return Forbidden(module.__name__)
    found = {}
    reads = outside.reads

    class Module:
        __slots__ = ()
        __setattr__ = __delattr__ = lambda *_: refuse("it changes an object", effect=True)
        __class__: Any = property(lambda _: types.ModuleType)
        __dict__: Any = property(lambda _: refuse("it uses the variables of a module", effect=True))

        def __getattr__(self, name):
            if name not in found:
                inner = reads.step(row, "attribute", name)
                if not hasattr(module, name):
                    reads.expect(inner, "absent")
                value = getattr(module, name)
                if package in PURE:
                    inner = reads.part(inner, value)
                found[name] = outside.wrap(value, inner)
            return found[name]

    return Module()


class Member:
    """A member of a class, wrapped when it is first used."""

    def __init__(self, outside, value, row):
        self._of = (outside, value, row)
        self._made = None
        self.__isabstractmethod__ = getattr(value, "__isabstractmethod__", False)

    def made(self) -> Any:
        if self._made is None:
            outside, value, row = self._of
            self._made = [_wrapped_member(outside, value, row)]
        return self._made[0]

    def __get__(self, thing, kind=None):
        found = self.made()
        get = getattr(type(found), "__get__", None)
        return found if get is None else get(found, thing, kind)


class DataMember(Member):
    """A member with a `__set__`, which goes before the attributes of an object."""

    def __set__(self, thing, value):
        found = self.made()
        type(found).__set__(found, thing, value)

    def __delete__(self, thing):
        found = self.made()
        type(found).__delete__(found, thing)


def _wrapped_member(outside, value, row):
    kind: Any = type(value)
    if isinstance(value, property) and kind.__get__ is property.__get__:
        kind = property  # a subclass that knows more, such as a unit, and reads as properties do
    if kind not in FUNCTIONS or kind is types.FunctionType:
        return outside.wrap(value, row)
    at = outside.same(row, value)
    if kind is property:
        return property(
            *[outside.part(value, at, "attribute", k) for k in ("fget", "fset", "fdel")]
        )
    if kind is functools.cached_property:
        function = outside.part(value, at, "attribute", "func")
        return NotCached(function, outside.reads)
    return kind(outside.part(value, at, "attribute", "__func__"))


class NotCached:
    """A cached_property that has no cached value; a cached value is an attribute that hides it."""

    def __init__(self, function, reads):
        self.function = function
        self.reads = reads

    def __get__(self, thing, kind=None):
        if thing is None:
            refuse("it uses a cached_property of a class")
        self.reads.lasting = False  # a call in Python would cache the value in the object
        return self.function(thing)


class Metaclass(type):
    """The type of shadows of classes with a user's metaclass, whose functions are unknown."""

    def __getattribute__(cls, name):
        if name[:2] != "__":
            refuse("it uses a class that has a metaclass")
        return super().__getattribute__(name)

    def __call__(cls, *_, **__):
        refuse("it uses a class that has a metaclass")


def shadow_of(outside, cls):
    """The shadow of a user's class; later calls check the class's number of members."""
    made = outside.known(cls)
    if made is not None:
        return made
    reads = outside.reads
    own = vars(cls) if root_of(cls) not in PURE else {}
    for hook in REFUSED:
        if hook in own:
            refuse(f"the class {cls.__name__} has a `{hook}` of its own")
    at = reads.known(cls)
    members = reads.step(at, "attribute", "__dict__")
    if own:
        reads.objects[at] = cls
        reads.expect(members, "size", len(own))
    foreign = root_of(type(cls)) not in PURE
    bases = []
    for base in cls.__bases__ if own else (cls,):
        if root_of(base) in PURE | IMPURE:
            bases.append(base)
        elif not foreign or root_of(base) == root_of(cls):
            bases.append(shadow_of(outside, base))
    body: dict = {"__getattribute__": _reading(outside.things)}
    for name, value in own.items():
        of_tuple = issubclass(cls, tuple) and name in OF_NAMED_TUPLES.union(
            getattr(cls, "_fields", ())
        )
        plain = name[:2] == "__" and not (callable(value) or isinstance(value, FUNCTIONS))
        if name in LEFT_OUT:
            continue
        if of_tuple or plain:
            body[name] = value
        elif not isinstance(value, OF_C):
            kind = DataMember if hasattr(type(value), "__set__") else Member
            body[name] = kind(outside, value, reads.step(members, "item", name))
    if "__init_subclass__" in own:
        body["__init_subclass__"] = _subclass_refused
    for name in ("__new__", "__del__"):
        if name in own and name not in (body if issubclass(cls, tuple) else ()):
            body["__new__"] = staticmethod(functools.partial(_refused_new, name == "__del__"))
    try:
        meta: Any = Metaclass if foreign else type(cls)
        new = meta(cls.__name__, tuple(bases), body | {"__shadow__": True})
    except TypeError:
        refuse(f"it uses the class {cls.__name__}", final=True)
    return outside.keep(cls, new, None, "an attribute of a class")


@classmethod
def _subclass_refused(cls, **_):
    if "__shadow__" not in vars(cls):
        refuse(f"the class {cls.__name__} inherits from one that sees who inherits from it")


def _refused_new(effect, *_, **__):
    refuse("a class with a `__new__` or a `__del__` of its own", effect=effect)


def _reading(things):
    """The `__getattribute__` of shadows."""

    def __getattribute__(self, name):
        thing = things.get(id(self))
        if thing is not None:
            thing.look(name)
        return object.__getattribute__(self, name)

    return __getattribute__


class Thing:
    """An object from outside; its shadow gets an attribute when the attribute is first read."""

    def __init__(self, outside, thing, row, mine):
        reads = outside.reads
        self._outside = outside
        self._thing = thing
        self._row = row
        self._mine = mine
        self._own = getattr(thing, "__dict__", None)
        self._at = reads.step(row, "attribute", "__dict__")
        self._slots = {
            name
            for base in type(thing).__mro__
            for name, value in vars(base).items()
            if type(value) is types.MemberDescriptorType
        }
        self.seen: dict = {}

    def look(self, name):
        """Wrap an attribute, if the object has the attribute."""
        reads = self._outside.reads
        own = self._own or {}
        if name == "__dict__":
            reads.expect(self._at, "keys", (dict, list(own)))
            for each in own:
                self.look(each)
        elif name in self.seen or name in self._mine:  # read before, or written by the run
            pass
        elif name in own:
            self._take(name, own[name], reads.step(self._at, "item", name))
        elif name in self._slots:
            place = reads.step(self._row, "attribute", name)
            if hasattr(self._thing, name):
                self._take(name, getattr(self._thing, name), place)
            else:
                reads.expect(place, "absent")
        elif name[:2] != "__" and self._own is not None:
            # a later attribute of the object would hide the class's
            reads.expect(reads.step(self._at, "item", name), "absent")

    def _take(self, name, value, row):
        self._mine[name] = self.seen[name] = self._outside.wrap(value, row)


def instance_of(outside, thing, row):
    """The shadow of an object: an instance of the shadow of its class."""
    kind = type(thing)
    reads = outside.reads
    base = next(c for c in kind.__mro__ if not c.__flags__ & HEAP)
    if base not in BASES:
        refuse(f"it uses an object of type {kind.__name__}", final=True)
    reads.expect(row, "instance", (kind, kind.__mro__))
    cls = shadow_of(outside, kind)
    held = base in (list, tuple, dict)
    content = outside.wrap(as_base(thing), reads.step(row, "as base")) if held else ()
    new = base.__new__(cls, *((content,) if base is tuple else ()))
    outside.keep(thing, new, row)
    if base in (list, dict):
        (list.extend if base is list else dict.update)(new, content)
        outside.watch(f"a {base.__name__}", new)
    at = reads.step(row, "attribute", "__dict__")
    if getattr(thing, "__dict__", None) is thing:  # `self.__dict__ = self`
        object.__setattr__(new, "__dict__", new)
        reads.alias(at, row)
        return new
    mine = object.__getattribute__(new, "__dict__")
    outside.things[id(new)] = found = Thing(outside, thing, row, mine)
    outside.watched.append(("an attribute", mine, found.seen))
    return new
