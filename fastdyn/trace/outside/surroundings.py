"""The surroundings of a traced function, in copies that the function may change.

Objects are copied on first use.  Each object that is read has a row in `Reads`.  After each run,
the copies are compared with their contents before the run.
"""

import contextlib
import enum
import logging
import operator
import types
from fractions import Fraction
from typing import Any

import numpy as np

from ..graph.expressions import LARGEST_WHOLE
from ..graph.kinds import FLOAT, INT, NUMPY
from ..numpy.builtins import impure
from ..numpy.stand_ins import IMPURE, PURE, STAND_INS, Forbidden, Quiet, root_of
from ..reads.reads import STABLE
from ..reads.steps import STEPS, real_numbers, real_parts
from ..scipy import objects as scipy_objects
from ..symbols.complex_pair import Pair
from ..symbols.real import Symbol
from ..symbols.symbolic import refuse
from . import containers, frames
from .arrays import array_copy
from .changes import changed
from .copies import instance_of, module_of, shadow_of
from .functions import Functions
from .kinds import has_functions, is_instance
from .library_objects import Attributes, class_of_data, library_object

ATOMS = (
    type(None), bool, str, bytes, complex, slice, range, frozenset, type(Ellipsis), Fraction,
    np.bool_, np.dtype, np.complexfloating, np.integer, np.floating, operator.itemgetter,
    operator.attrgetter,
)  # fmt: skip
OF_C = types.WrapperDescriptorType | types.MethodDescriptorType | types.MethodWrapperType


class Outside:
    """The copies of outside objects in one run."""

    def __init__(self, graph, reads, lifted="all"):
        self.graph, self.reads, self.lifted, self.functions = graph, reads, lifted, Functions(self)
        self._made, self._held, self._first, self.enumerations = {}, [], {}, {}
        self.watched: list = []

    @contextlib.contextmanager
    def numbers_fixed(self, fixed=True):
        """Within the context, copied numbers become constants of the code, if `fixed`."""
        before, self.lifted = self.lifted, "none" if fixed else self.lifted
        try:
            yield
        finally:
            self.lifted = before

    def keep(self, value, copy, what="", before=None):
        """Store the copy of a value; keep the value alive, so that its id stays unique.

        `what` names the kind of object; with `what`, the copy must equal `before` after the run.
        """
        self._made[id(value)] = copy
        self._held.append(value)
        if what:
            self.watched.append((what, copy, before))
        return copy

    def known(self, value):
        return self._made.get(id(value))

    def copy(self, value: Any, row=None) -> Any:
        """A copy of a value for the traced function; numbers become parameters.

        Parameters
        ----------
        value : object
        row : int or None
            The value's row in `Reads`; None if the value's origin is unknown.
        """
        kind = type(value)
        builtin = kind.__module__ in ("builtins", "numpy", "numpy.dtypes", "operator", "fractions")
        if kind is int or kind is float or kind is np.float64:
            return self._number(value, row)
        if builtin and isinstance(value, complex | np.complexfloating):
            return self._complex_number(value, row)
        if (builtin and isinstance(value, ATOMS)) or kind.__module__ == "dataclasses":
            self.reads.expect(row, "equal", value)
            return value
        made = self._made.get(id(value))
        if made is None:
            self._first.setdefault(id(value), row)
            return self._copy(value, kind, row)
        first = self._first.get(id(value))
        if first in (None, STABLE):
            self.reads.expect(row, "same", value)
        else:
            self.reads.alias(row, first)
        return made

    def _number(self, value, row):
        whole = not isinstance(value, float | np.floating)
        if row in (None, STABLE) or self.lifted == "none" or (whole and self.lifted == "floats"):
            self.reads.expect(row, "equal", value)
            return value
        if whole and abs(value) > LARGEST_WHOLE:  # as a constant, the number is exact
            self.reads.expect(row, "equal", value)
            return value
        (slot,) = self.reads.parameters(row, value)
        kind = INT if whole else FLOAT if type(value) is float else NUMPY
        return Symbol(self.graph, self.graph.make("par", (), slot), kind)

    def _complex_number(self, value, row):
        if self.fixed(row):
            self.reads.expect(row, "equal", value)
            return value
        self.reads.expect(row, "number", type(value))
        (found,) = self.pairs_of(np.array([value]), row)
        return found

    def fixed(self, row):
        """Whether the numbers of a row are constants of the code."""
        return row in (None, STABLE) or self.lifted == "none"

    def pairs_of(self, value, row, real=False):
        """The complex numbers of an array, as Pairs of parameters."""
        g, reads = self.graph, self.reads
        if real:  # imaginary parts are zero, and later solves check that they are
            slots = reads.parameters(reads.step(row, "real parts"), real_parts(value))
            return [Pair(Symbol(g, g.make("par", (), slot)), 0.0) for slot in slots]
        slots = reads.parameters(reads.step(row, "real numbers"), real_numbers(value))
        found = [Symbol(g, g.make("par", (), slot)) for slot in slots]
        return [Pair(*pair) for pair in zip(found[::2], found[1::2], strict=True)]

    def _copy(self, value, kind, row):
        reads = self.reads
        stand_in = STAND_INS.get(id(value)) or scipy_objects.stand_in_of(value)
        if stand_in is not None:
            reads.expect(row, "same", value)
            return stand_in
        if kind is np.ndarray:
            return array_copy(self, value, row)
        if kind is list or kind is tuple:
            return containers.sequence(self, value, kind, row)
        for copies in (containers, frames):
            copy = copies.copy_of(self, value, kind, row)
            if copy is not None:
                return copy
        if isinstance(value, types.FunctionType):
            return self.functions.copy(value, row)
        found = self.functions.wrapper(value, row)
        return self._thing(value, kind, row) if found is None else found

    def watch(self, value, copy):
        self.watched.append(copy.watch())
        return self.keep(value, copy)

    def part(self, value, row, step, key=None):
        """A copy of a part of a value: the part that a step of `Reads` reaches."""
        return self.copy(STEPS[step](value, key), self.reads.step(row, step, key))

    def parts(self, value, row, step, keys):
        """{key: copy of a part}: the parts that a step of `Reads` reaches with each of the keys."""
        return {key: self.part(value, row, step, key) for key in keys}

    def items(self, values, row):
        """Copies of the items of a sequence."""
        return [self.part(values, row, "item", i) for i in range(len(values))]

    def _thing(self, value, kind, row):
        """A copy of a module, a class or an object."""
        reads = self.reads
        reads.expect(row, *(("type", kind) if is_instance(value, kind) else ("same", value)))
        if isinstance(value, types.ModuleType):
            return self.keep(value, module_of(self, value, row))
        of_type = value if isinstance(value, type) else kind
        if issubclass(of_type, enum.Enum):
            return containers.enumeration(self, value, of_type)
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
        if scipy_objects.is_of_scipy(value, kind) and not isinstance(value, type):
            scipy_objects.expect_content(reads, value, row)
            return self.keep(value, scipy_objects.copy_of(value, self.watched))
        package = root_of(value if isinstance(value, type) else kind)
        if isinstance(value, type):
            made_by_user = any(map(has_functions, value.__mro__[:-1]))
            if package in PURE | IMPURE:
                return value
            if issubclass(value, BaseException | tuple | list | dict) and not made_by_user:
                return class_of_data(self, value, row)
            if issubclass(value, list | dict):
                refuse(f"the class {value.__name__} is a list or a dict with functions of its own")
            return shadow_of(self, value, row)
        if is_instance(value, kind):
            return instance_of(self, value, row)
        if isinstance(value, logging.Logger):
            reads.lasting = False  # a later call cannot check the level
            return Quiet(value)
        if package in IMPURE:
            return Forbidden(package)
        if callable(value) or isinstance(value, np.generic):
            if scipy_objects.content_of(value):  # a polynomial of NumPy
                scipy_objects.expect_content(reads, value, row)
            elif not isinstance(value, np.ufunc | OF_C):
                reads.lasting = False  # a later call cannot check what the callable holds
            return library_object(self, value) if hasattr(value, "__dict__") else value
        return refuse(f"it uses an object of type {kind.__name__}", final=True)

    def writes(self):
        """The kinds of objects that the run changed, such as "a dict"."""
        written = [each for each in self.watched if changed(*each[1:])]
        found = [what for what, *_ in written]
        for before in [before for *_, before in written if isinstance(before, Attributes)]:
            before.give_back()
        for member, before in [pair for pairs in self.enumerations.values() for pair in pairs]:
            if vars(member) != before:
                vars(member).clear()
                vars(member).update(before)
                found.append("an attribute of an enumeration")
        return found
