"""Records what a traced function reads from outside: places, checks and parameters.

Each object that was read has a row: the row of the parent object, the step from the parent to the
object, and the check that the object must pass in a later call.  For a number, the check compares
only the type, because the value is a parameter of the code.  `program` writes the rows out.
"""

import bisect
import hashlib
import math
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np

STABLE = -1  # the row of objects inside libraries, which do not change
MAX_ARRAY = 4096  # the largest array whose elements become symbols
DEFAULTS = "__defaults__", "__kwdefaults__"  # attributes of functions
# Checks that fail only if the user replaces a part of the program.
OF_CODE = {
    None, "number", "array", "complex array", "absent", "code", "nothing", "class", "size", "part",
}  # fmt: skip


class ReadRow(NamedTuple):
    """One read: a later object of this place must pass `check`, with what was `expected`.

    The step of a root is "root", of a function or an argument, or "known", of an object that
    another row has found to be this very object.
    """

    parent: int
    step: str
    key: Any
    check: Any = None
    expected: Any = None


class Group(NamedTuple):
    """The parameters of one row: a number (`whole`: an integer), or the elements of an array."""

    row: int
    first: int
    shape: tuple | None
    whole: bool
    dtype: str = "f8"  # of an array

    @property
    def size(self):
        return 1 if self.shape is None else math.prod(self.shape)


class Reads:
    """The rows and parameters of a trace; `roots` are the function and its arguments."""

    def __init__(self, graph, roots, varying=()):
        self.graph = graph
        self.roots = roots
        self.varying = varying
        self.rows: list[ReadRow] = []
        self.groups: list[Group] = []
        self._known = {}
        self._of_row = {}
        self._firsts = []
        self._held = {}
        self.fixed: set = set()  # slots whose numbers are part of the code
        self.assumed: dict = {}
        self.aliases: set = set()  # pairs of rows that hold one object
        self.lasting = True
        self.names: frozenset = frozenset()  # of attributes of functions and classes
        self.identities = False
        self.truths = False
        self._given, self.objects = [], {}  # values of the groups; objects by row, until `close`
        self.pattern: dict = {}  # row: first row with the same object, if identities are compared

    # -- places

    def root(self, i):
        """The row of the function (0), or of argument i."""
        return self._add((STABLE, "root", i), i)

    def known(self, thing):
        """The row of an object that the check of another row identifies."""
        return self._add((STABLE, "known", id(thing)), thing)

    def step(self, parent, step, key=None):
        """The row that `step` reaches from the row `parent`; None if `parent` is None."""
        if parent is None or parent == STABLE:
            return parent
        return self._add((parent, step, key), key)

    def _add(self, place, key):
        row = self._known.get(place)
        if row is None:
            row = self._known[place] = len(self.rows)
            self.rows.append(ReadRow(place[0], place[1], key))
        return row

    def expect(self, row, check, expected=None):
        """Record the check that the object of a row must pass."""
        if row is None:
            self.lasting = False  # without a row, no later call can find the object
        elif row != STABLE and self.rows[row].check is None:
            self.rows[row] = self.rows[row]._replace(check=check, expected=expected)

    def part(self, row, value):
        """Record that a part of a library is this very object; the row of what is within."""
        self.expect(row, "part", value)
        return STABLE

    def expect_elements(self, row, array):
        """Record that an array must have the present elements, in the present order in memory."""
        self.expect(row, "content", (array.copy(), array.flags.c_contiguous))

    def alias(self, row, first):
        """Record that two rows hold one object whose content the function uses."""
        if row not in (None, STABLE) and row != first:
            self.aliases.add((row, first))

    # -- parameters

    def parameters(self, row, value):
        """The range of slots for a number, or for the elements of an array."""
        known = self._of_row.get(row)
        if known is None:
            array = isinstance(value, np.ndarray)
            known = len(self.groups)
            first = len(self.graph.values)
            whole = not array and not isinstance(value, float | np.floating)
            shape, code = (value.shape, value.dtype.str[1:]) if array else (None, "f8")
            self.groups.append(Group(row, first, shape, whole, code))
            self.graph.values.extend(value)
            self._firsts.append(first)
            self._given.append(value)
            self._of_row[row] = known
            if self.varies(row):
                self.graph.varying.update(range(first, len(self.graph.values)))
            if array:
                strides = value.strides if value.ndim > 1 and value.dtype == float else None
                self.expect(row, "array", (value.dtype, value.shape, strides))
            else:
                self.expect(row, "number", type(value))
        group = self.groups[known]
        return range(group.first, group.first + group.size)

    def held(self, content):
        """The slots of a constant array, stored beside the code; equal ones share slots."""
        array = np.array(content, dtype=float, order="C")
        name = array.shape, hashlib.sha256(array.data).digest()
        array = self._held.setdefault(name, array)
        return self.parameters(self.known(array), array)

    def varies(self, row):
        """Whether a row belongs to an argument that varies between trajectories."""
        while self.rows[row].parent >= 0:
            row = self.rows[row].parent
        return self.rows[row].step == "root" and self.rows[row].key in self.varying

    def group(self, slot):
        """The index of the group that a slot belongs to."""
        return bisect.bisect_right(self._firsts, slot) - 1

    def of_arguments(self):
        """For each argument, the index of its group; None for an argument without a group."""
        rows = [self._known.get((STABLE, "root", i)) for i in range(1, len(self.roots))]
        return tuple([self._of_row.get(row) for row in rows])

    def assume(self, node):
        """Restrict the code to the current value of a node that parameters determine."""
        if node.op == "const":
            return
        if node.op == "par":
            self.fixed.add(node.data)
        else:
            self.assumed[node.key] = node

    # -- after the trace

    def close(self):
        """The values of all groups; from then on, the record holds no object but for its checks."""
        given = self._given
        self._given = []
        for row, thing in [*self.objects.items()] if self.names else ():
            if isinstance(thing, FunctionType | type):
                for name in sorted(self.names):
                    self.expect(self.step(row, "attribute", name), "equal", getattr(thing, name))
        if self.identities:
            first: dict = {}
            for row, thing in self.objects.items():
                self.pattern[row] = first.setdefault(id(thing), row)
        self.objects = {}
        return given

    def may_need_other_code(self):
        """Whether other values of the kind that users change may need other code."""
        return any(
            row.check not in OF_CODE and not (row.check == "same" and _is_lasting(row.expected))
            for row in self.rows
            if row.step != "root" and not (row.step == "attribute" and row.key in DEFAULTS)
        )


def _is_lasting(thing):
    return isinstance(thing, type(math) | type(len) | np.ufunc)


def flat(given):
    """The values of all parameters, by slot."""
    return np.concatenate([np.ravel(v) for v in given], dtype=float) if given else np.empty(0)
