"""The surroundings of a traced function, as the function sees them.

`Outside.wrap` is the only way in: it turns a value from outside, and the row of the value's place
in `Reads`, into what the traced function gets.  Numbers become symbols of parameters; functions are
rebuilt over wrapped values; an object gets a shadow, which wraps an attribute when it is first
read.  Nothing of the user's is changed, and a write to a copy is found after the run.
"""

import collections
import contextlib
import copy
import enum
import logging
import operator
import types
from fractions import Fraction
from typing import Any

import numpy as np

from ..functions.objects import object_of
from ..functions.python import List, Tuple, impure
from ..functions.stand_ins import IMPURE, PURE, Forbidden, Quiet, root_of, stand_in_of
from ..graph.expressions import LARGEST_WHOLE
from ..reads.program import OF_LIBRARIES
from ..reads.reads import MAX_ARRAY, STABLE
from ..symbols.symbol import AN_ARRAY, Symbol, refuse
from . import numbers, objects
from .changes import changed, content
from .functions import RebuiltFunctions

ATOMS = (
    type(None), bool, str, bytes, complex, slice, range, frozenset, type(Ellipsis), Fraction,
    np.bool_, np.dtype, np.integer, np.floating, np.complexfloating, operator.itemgetter,
    operator.attrgetter,
)  # fmt: skip
OF_C = types.WrapperDescriptorType | types.MethodDescriptorType | types.MethodWrapperType
DICTS = (dict, collections.OrderedDict, collections.defaultdict, collections.Counter)

OF_ENUMERATION = "an attribute of an enumeration"


class Outside:
    """The outside of one run: what was wrapped, and what the run may have changed."""

    def __init__(self, graph, reads, lifted="all"):
        self.graph = graph
        self.reads = reads
        self.lifted = lifted
        self.functions = RebuiltFunctions(self)
        self.things = {}
        self._made = {}
        self.watched: list = []
        self.stored: list = []  # the kinds of arrays of ids that the run changed

    @contextlib.contextmanager
    def numbers_fixed(self, fixed=True):
        """Within the context, numbers become constants of the code, if `fixed`."""
        before = self.lifted
        self.lifted = "none" if fixed else self.lifted
        try:
            yield
        finally:
            self.lifted = before

    def fixed(self, row):
        """Whether the numbers of a row are constants of the code."""
        return row in (None, STABLE) or self.lifted == "none"

    # -- what was wrapped

    def keep(self, value, new, row=None, what=""):
        """Store what a value became; with `what`, the kind of object, a change is found later."""
        self._made[id(value)] = new, row, value  # alive, so that its id stays unique
        if what:
            self.watch(what, new)
        return new

    def watch(self, what, thing):
        self.watched.append((what, thing, content(thing)))

    def known(self, value):
        found = self._made.get(id(value))
        return None if found is None else found[0]

    def part(self, value: Any, row, step, key: Any):
        """The wrapped item, or attribute, of a value."""
        found = value[key] if step == "item" else getattr(value, key)
        return self.wrap(found, self.reads.step(row, step, key))

    def same(self, row, value):
        """Let later calls check that this very object is there; its row as a root of its own."""
        self.reads.expect(row, "same", value)
        return self.reads.known(value) if row != STABLE else STABLE

    # -- wrapping

    def wrap(self, value: Any, row=None) -> Any:
        """The stand-in that a traced function gets for a value from outside.

        Parameters
        ----------
        value : object
        row : int or None
            The value's row in `Reads`; STABLE within libraries, None if the place is unknown.
        """
        kind = type(value)
        reads = self.reads
        if row not in (None, STABLE):
            reads.objects.setdefault(row, value)
        builtin = kind.__module__ in OF_LIBRARIES
        if kind is int or kind is float or kind is np.float64 or (kind is bool and self._vary(row)):
            return self._number(value, row)
        if (kind is complex or kind is np.complex128) and not self.fixed(row):
            reads.expect(row, "number", kind)
            return numbers.complex_number(self, value, row)
        if (builtin and isinstance(value, ATOMS)) or kind.__module__ == "dataclasses":
            reads.expect(row, "equal", value)
            return value
        if isinstance(value, type):
            return self._class(value, row)
        made = self._made.get(id(value))
        if made is None:
            return self._new(value, kind, row)
        new, first, _ = made
        if first in (None, STABLE):
            reads.expect(row, "same", value)
        else:
            reads.alias(row, first)
        return new

    def _vary(self, row):
        """Whether a truth value differs between trajectories; else it is part of the code."""
        return row not in (None, STABLE) and self.reads.varies(row) and not self.fixed(row)

    def _number(self, value, row):
        whole = type(value) is int
        # beyond the largest whole number, a constant is exact
        if self.fixed(row) or (whole and abs(value) > LARGEST_WHOLE):
            self.reads.expect(row, "equal", value)
            return value
        return numbers.number(self.graph, self.reads.parameters(row, value)[0], value)

    def _class(self, cls, row):
        stand_in = stand_in_of(cls)
        if stand_in is not None or root_of(cls) in PURE | IMPURE:
            self.reads.expect(row, "same", cls)
            return cls if stand_in is None else stand_in
        self.reads.expect(row, "class", (cls, cls.__mro__))
        if issubclass(cls, enum.Enum):
            return self._enumeration(cls, cls)
        if self.known(cls) is None and root_of(type(cls)) not in PURE:
            refuse(f"it uses the class {cls.__name__}, which has a metaclass")
        return objects.shadow_of(self, cls)

    def _new(self, value, kind, row):
        reads = self.reads
        stand_in = stand_in_of(value)
        if stand_in is not None:
            reads.expect(row, "same", value)
            return stand_in
        if kind is np.ndarray:
            new = numbers.array(self, value, row)
            return self.keep(value, new, row, "" if type(new) is Symbol else AN_ARRAY)
        thing = object_of(self, value, row)
        if thing is not None:
            return thing
        if kind is list or kind is tuple:
            return self._sequence(value, kind, row)
        if kind is set:
            if any(type(v).__module__ not in OF_LIBRARIES for v in value):
                refuse("it uses a set of objects")
            reads.expect(row, "equal", set(value))
            return self.keep(value, set(value), row, "a set")
        if kind is collections.deque:
            reads.expect(row, "length", (kind, len(value)))
            items = [self.part(value, row, "item", i) for i in range(len(value))]
            return self.keep(value, kind(items, value.maxlen), row, "a deque")
        if kind in DICTS:
            reads.expect(row, "keys", (kind, list(value)))
            new = self.keep(value, copy.copy(value), row)
            for key, item in value.items():
                new[key] = self.wrap(item, reads.step(row, "item", key))
            self.watch("a dict", new)
            return new
        if isinstance(value, types.FunctionType):
            return self.functions.copy(value, row)
        found = self.functions.wrapper(value, row)
        return self._thing(value, kind, row) if found is None else found

    def _sequence(self, value, kind, row):
        """A list or tuple; many floats are one array, many other numbers a part of the code."""
        reads = self.reads
        n = len(value)
        kinds = {*map(type, value)}
        if n > MAX_ARRAY:
            refuse(f"it uses a list of {n} items: make it an array", final=True)
        if n > numbers.SMALL and kinds in ({float}, {np.float64}) and not self.fixed(row):
            reads.expect(row, "type", kind)
            slots = reads.parameters(reads.step(row, "numbers", *kinds), np.array(value))
            items = numbers.items(self.graph, slots, value[0])
        elif n > numbers.SMALL and kinds <= {bool, int, float, np.float64}:
            reads.expect(row, "equal", copy.copy(value))
            items = value
        else:
            reads.expect(row, "length", (kind, n))
            items = [self.part(value, row, "item", i) for i in range(n)]
        if kind is list:
            return self.keep(value, List(items), row, "a list")
        return self.keep(value, (Tuple if n > numbers.SMALL else tuple)(items), row)

    def _enumeration(self, value, cls):
        """The enumeration or member itself; `writes` undoes writes to members."""
        own = [v for name, v in vars(cls).items() if name[:2] != "__" and name[:5] != "_gene"]
        if any(type(v) in (types.FunctionType, property, staticmethod, classmethod) for v in own):
            refuse("an enumeration with functions of its own")
        if any(name[0] != "_" for member in cls for name in vars(member)):
            self.reads.lasting = False  # a later call cannot check attributes of members
        if self.known(cls) is None:
            self.keep(cls, cls)
            for member in cls:
                self.watch(OF_ENUMERATION, vars(member))
        return value

    def _thing(self, value, kind, row):
        """A module or an object."""
        reads = self.reads
        package = root_of(kind)
        if (
            objects.is_instance(value, kind)
            or np.poly1d in kind.__mro__
            or (kind.__module__.startswith("numpy.polynomial"))
        ):
            return objects.instance_of(self, value, row)
        at = self.same(row, value)
        if isinstance(value, types.ModuleType):
            return self.keep(value, objects.module_of(self, value, at), row)
        if isinstance(value, enum.Enum):
            return self._enumeration(value, kind)
        if isinstance(value, types.BuiltinFunctionType):
            owner = value.__self__
            if not isinstance(owner, types.ModuleType | type | None):
                return Forbidden(f"the method {value.__name__} of an object")
            name = owner.__name__ if isinstance(owner, types.ModuleType) else root_of(type(owner))
            if name.partition(".")[0] in IMPURE or "random" in name:
                return impure(f"{name}.{value.__name__}")
            return value
        if "random" in (kind.__module__ or ""):
            return Forbidden("random numbers")
        if hasattr(kind, "__next__"):
            return Forbidden("an iterator")
        if isinstance(value, logging.Logger):
            reads.lasting = False  # a later call cannot check the level
            return Quiet(value)
        if package in IMPURE:
            return Forbidden(package)
        if callable(value) or isinstance(value, np.generic):
            if isinstance(value, np.ufunc | OF_C):
                return value  # a ufunc of NumPy 2.4 has a `__dict__`
            reads.lasting = False  # a later call cannot check what the callable holds
            if not hasattr(value, "__dict__"):
                return value
        return refuse(f"it uses an object of type {kind.__name__}", final=True)

    # -- after the run

    def writes(self):
        """The kinds of objects that the run changed, such as "a dict"."""
        written = [each for each in self.watched if changed(*each[1:])]
        for what, thing, before in written:
            if what == OF_ENUMERATION:  # the user's own
                thing.clear()
                thing.update(before)
        return self.stored + [what for what, *_ in written]
