"""Records what a traced function reads from outside, so that a later call can check it.

Each object that was read has a row.  The row holds the row of the parent object, the step from the
parent to the object, and the check that the object must pass.  For a number, the check compares
only the type, because the value is a parameter of the code.
"""

import bisect
import math
from typing import Any, NamedTuple

import numpy as np

from ..graph.evaluate import evaluate
from .checks import CHECKS, laid
from .steps import STEPS

STABLE = -1  # the row of objects inside libraries, which do not change
MAX_ARRAY = 4096  # the largest array whose elements become symbols


# Exceptions of a step or a check that cannot be done: the trace does not hold.
ERRORS = (AttributeError, KeyError, IndexError, TypeError, ValueError)
NO_ATTRIBUTES = ("inside", "__dict__", "keys", (dict, []))  # a row, without its parent


class Row(NamedTuple):
    """One read: ``CHECKS[check]`` compares the object with `expected`."""

    parent: int
    step: str
    key: Any
    check: Any
    expected: Any


class Group(NamedTuple):
    """The parameters of one row: a number (`whole`: an integer), or the elements of an array."""

    row: int
    first: int
    shape: tuple | None
    whole: bool
    dtype: str = "f8"  # of an array


class Reads:
    """The rows and parameters of a trace; `roots` are the function and its arguments."""

    def __init__(self, graph, roots, varying=()):
        self.graph, self.roots, self.varying = graph, roots, varying
        self.rows: list[Row] = []
        self.groups: list[Group] = []
        self._known, self._of_row, self._firsts, self.fixed = {}, {}, [], set()
        self.assumed: dict = {}
        self.aliases: set = set()  # pairs of rows that hold one object
        self.lasting, self.identities, self.truths = True, False, False
        self._pattern: tuple | None = None

    def root(self, i):
        """The row of the function (0), or of argument i."""
        return self._add(STABLE, "root", i)

    def step(self, parent, step, key=None):
        """The row that `step` reaches from the row `parent`; None if `parent` is None."""
        return parent if parent is None or parent == STABLE else self._add(parent, step, key)

    def _add(self, parent, step, key):
        place = parent, step, key
        row = self._known.get(place)
        if row is None:
            row = self._known[place] = len(self.rows)
            self.rows.append(Row(parent, step, key, None, None))
        return row

    def expect(self, row, check, expected=None):
        """Record the check that the object of a row must pass."""
        if row is None:
            self.lasting = False  # without a row, no later call can find the object
        elif row != STABLE and self.rows[row].check is None:
            self.rows[row] = self.rows[row]._replace(check=check, expected=expected)

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
            self._of_row[row] = known
            if self.root_of(row) in self.varying:
                self.graph.varying.update(range(first, len(self.graph.values)))
            if array and value.dtype == float:
                self.expect(row, "array", laid(value))
            elif array:
                self.expect(row, "numbers", (value.dtype, value.shape))
            else:
                self.expect(row, "number", type(value))
        group = self.groups[known]
        return range(group.first, group.first + _count(group))

    def root_of(self, row):
        """The index of the root from which the steps to a row begin."""
        place = self.rows[row]
        return place.key if place.parent < 0 else self.root_of(place.parent)

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

    # -- a later call

    def found(self, roots):
        """The objects of all rows, reached from the given roots; empty if a step fails."""
        found = []
        try:
            for parent, step, key, *_ in self.rows:
                found.append(roots[key] if parent < 0 else STEPS[step](found[parent], key))
        except ERRORS:
            return []
        return found

    def same_things(self):
        """The `pattern` of the objects of all rows at the trace, if identities are compared.

        The roots may change later.  Therefore the first call, just after the trace, computes the
        pattern, and later calls return it.
        """
        if self._pattern is None:
            self._pattern = pattern(self.found(self.roots)) if self.identities else ()
        return self._pattern

    def values(self):
        """The values of all groups, read again from the roots of the trace."""
        found = self.found(self.roots)
        if len(found) < len(self.rows):  # a full cache of a function drops values while it is read
            return [self._traced_value(group) for group in self.groups]
        return [found[group.row] for group in self.groups]

    def _traced_value(self, group):
        """The value of a group at the trace."""
        numbers = np.array(self.graph.values)[group.first : group.first + _count(group)]
        if group.shape is not None:
            return numbers.astype(group.dtype).reshape(group.shape)
        return int(numbers[0]) if group.whole else float(numbers[0])

    def follow(self, *roots):
        """The values of all groups, read from other roots; None if the trace is not valid there."""
        if not self.lasting or len(roots) != len(self.roots):
            return None
        found = []
        try:
            for parent, step, key, check, expected in self.rows:
                value = roots[key] if parent < 0 else STEPS[step](found[parent], key)
                if check is not None and not CHECKS[check](value, expected):
                    return None
                found.append(value)
        except ERRORS:
            return None
        if any(found[a] is not found[b] for a, b in self.aliases):
            return None
        if self.identities and pattern(found) != self.same_things():
            return None
        given = [found[group.row] for group in self.groups]
        return given if self.holds(given) else None

    def holds(self, given):
        """Whether the values on which the code relies are those of the trace."""
        if not self.fixed and not self.assumed:
            return True
        values = flat(given)
        known = self.graph.values
        if any(not _same(values[slot], known[slot]) for slot in self.fixed):
            return False
        nodes = list(self.assumed.values())
        if not nodes:
            return True
        at = np.zeros(1)
        (now,) = evaluate(self.graph, nodes, at, np.zeros((1, 1)), values)[0].reshape(1, -1)
        return all(_same(a, float(node.value)) for a, node in zip(now, nodes, strict=True))


def pattern(things):
    """Number the objects by identity: identical objects get equal numbers."""
    first: dict = {}
    return tuple([first.setdefault(id(thing), len(first)) for thing in things])


def flat(given):
    """The values of all parameters, by slot."""
    return np.concatenate([np.ravel(v) for v in given], dtype=float) if given else np.empty(0)


def _count(group):
    return 1 if group.shape is None else int(np.prod(group.shape))


def _same(a, b):
    """Whether two numbers are equal, also in the sign of zero, or both nan."""
    return (a == b and math.copysign(1.0, a) == math.copysign(1.0, b)) or (a != a and b != b)
