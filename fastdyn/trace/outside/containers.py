"""Copies of lists, tuples, sets, dicts, deques, chain maps, named tuples and enumerations."""

import collections
import types

from ..numpy.stand_ins import IMPURE, PURE, List, root_of
from ..reads.reads import MAX_ARRAY
from ..symbols.symbolic import refuse
from .copies import shadow_of
from .shared_copies import long_list

DICTS: dict = {  # types of dict: function that makes an empty dict of the type
    dict: lambda value: {},
    collections.OrderedDict: lambda value: collections.OrderedDict(),
    collections.defaultdict: lambda value: collections.defaultdict(value.default_factory),
    types.MappingProxyType: None,
}


def sequence(outside, value, kind, row):
    """A copy of a list or tuple; a long list of numbers is stored as one array."""
    whole = outside.lifted == "all"
    copy = None if outside.fixed(row) else long_list(outside.graph, value, row, whole)
    if copy is not None:
        return outside.watch(value, copy)
    outside.reads.expect(row, "length", (kind, len(value)))
    if len(value) > MAX_ARRAY:
        refuse("a long list among what it uses")
    items = outside.items(value, row)
    if kind is tuple:
        return outside.keep(value, tuple(items))
    return outside.keep(value, List(items), "a list", items)


def copy_of(outside, value, kind, row):
    """A copy of a container other than a list, with copies of the items; None for another value."""
    reads = outside.reads
    if kind is set:
        reads.expect(row, "equal", set(value))
        return outside.keep(value, set(value), "a set", set(value))
    if kind is collections.deque:
        reads.expect(row, "length", (kind, len(value)))
        items = outside.items(value, row)
        return outside.keep(value, collections.deque(items, value.maxlen), "a deque", items)
    if kind is collections.ChainMap:
        maps = reads.step(row, "member", "maps")
        reads.expect(row, "type", kind)
        reads.expect(maps, "length", (list, len(value.maps)))
        return outside.keep(value, collections.ChainMap(*outside.items(value.maps, maps)))
    if issubclass(kind, tuple) and hasattr(value, "_fields"):
        reads.expect(row, "type", kind)
        items = outside.items(value, row)
        cls = outside.part(value, row, "class")
        return outside.keep(value, tuple.__new__(cls, items))
    if kind not in DICTS:
        return _of_a_user(outside, value, kind, row) if is_of_a_user(value, kind) else None
    reads.expect(row, "keys", (kind, list(value)))
    empty = DICTS[kind]
    copy = outside.keep(value, {} if empty is None else empty(value))
    copy.update(outside.parts(value, row, "item", value))
    if empty is None:
        return outside.keep(value, kind(copy))
    outside.watched.append(("a dict", copy, dict(copy)))
    return copy


def is_of_a_user(value, kind):
    """Whether a value is a dict of a user's class."""
    return isinstance(value, dict) and root_of(kind) not in PURE | IMPURE


def _of_a_user(outside, value, kind, row):
    """A copy of a dict of a user's class, with copies of the class's functions and of the items."""
    reads, own = outside.reads, getattr(value, "__dict__", {})
    reads.expect(row, "keys", (kind, list(value)))
    of_class = reads.step(row, "class")
    reads.expect(of_class, "same", kind)
    copy = outside.keep(value, dict.__new__(shadow_of(outside, kind, of_class)))
    dict.update(copy, outside.parts(value, row, "dict item", dict.keys(value)))
    if own is value:  # `self.__dict__ = self`
        object.__setattr__(copy, "__dict__", copy)
    elif own:
        whole = reads.step(row, "member", "__dict__")
        reads.expect(whole, "keys", (dict, list(own)))
        vars(copy).update(outside.parts(value, row, "own", own))
        outside.watched.append(("an attribute of a dict", vars(copy), dict(vars(copy))))
    outside.watched.append(("a dict", copy, dict(copy)))
    return copy


def enumeration(outside, value, cls):
    """The enumeration or member itself; `Outside.writes` undoes writes to members."""
    own = [v for name, v in vars(cls).items() if name[:2] != "__" and name[:5] != "_gene"]
    if any(type(v) in (types.FunctionType, property, staticmethod, classmethod) for v in own):
        refuse("an enumeration with functions of its own")
    if any(name[0] != "_" for member in cls for name in vars(member)):
        outside.reads.lasting = False  # a later call cannot check attributes of members
    if cls not in outside.enumerations:
        outside.enumerations[cls] = [(member, dict(vars(member))) for member in cls]
    return value
