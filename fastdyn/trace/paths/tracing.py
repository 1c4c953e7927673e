"""The graph of a trace with ids, together with the decisions of the current run."""

from typing import Any

import numpy as np

from ..graph.refusal import Abandoned, Refusal
from ..graph.rows import SHARED, Rows
from ..graph.values import entries
from ..symbols.symbol import AN_ARRAY, STATE
from .handlers import is_handled

MAX_DECISIONS = 200
# On the path that no call takes, `while True: if y[0] > -1e9: break` decides without end; 0.5 s.
MOST_ASKED = 10**4


class Tracing(Rows):
    """The graph of a trace, together with the decisions of the current run.

    `script` prescribes the first decisions; `taken` lists all decisions as (node, truth).
    """

    reads: Any
    outside: Any = None  # of the current run
    given: Any = None  # the ids of the state
    until: Any = None  # the code object of the function that calls the traced function
    start: Any = None  # time and state of the first call, if known

    def __init__(self, n, few):
        super().__init__(n, few)
        self.sizes = self.false
        self.begin(())

    def begin(self, script):
        self.script, self.decided, self.taken, self.raising = script, {}, [], self.false
        self.texts = False
        self.abandoned = None
        self.conditions = False
        self._asked = 0  # decisions in a row without a new node
        self._size = 0  # of the graph at the last decision

    def assume(self, node):
        """Restrict the code to the current value of a node that parameters determine."""
        self.reads.assume(node)

    def unlock(self, ids):
        """Note a store to ids from outside, and allow it: the run may change more before it ends.

        The ids belong to all paths, but the trace is refused.
        """
        self.outside.stored.append(STATE if np.may_share_memory(ids, self.given) else AN_ARRAY)
        for array in [each for each in (ids.base, ids) if each is not None]:
            array.flags.writeable = True

    def table_name(self, ids):
        """The name of a table of numbers; None if they are no constants, nor parts of one array."""
        known = self.known(ids)
        if known is not None:
            return self.constant_table(np.asarray(known, float))
        row = self.row_at(int(ids[0])) if ids.size else None
        if row is None or row.op != "par":
            return None
        step = int(ids[1]) - int(ids[0]) if ids.size > 1 else 1
        last = int(ids[0]) + step * (ids.size - 1)
        if step <= 0 or last >= row.first + row.size:
            return None
        owner = ids if ids.base is None else ids.base
        from_outside = owner.flags.c_contiguous and not owner.flags.writeable  # equal steps
        if not from_outside and (ids != np.arange(ids[0], last + 1, step)).any():
            return None
        first = row.data.start + int(ids[0]) - row.first
        return self.table_of_slots(range(first, first + step * ids.size, step))

    def constant_table(self, numbers):
        """The name of a table of constants; a long table is stored beside the code."""
        if numbers.size <= SHARED:
            return self.table(numbers)
        return self.table_of_slots(self.reads.held(numbers))

    def table_of_slots(self, slots):
        self.tables[f"{slots}"] = slots
        return f"{slots}"

    def ascending(self, name):
        """Whether the numbers of a table never decrease; later solves check parameters again."""
        slots = self.tables[name]
        known = np.asarray(entries(self.values, slots) if isinstance(slots, range) else slots)
        found = bool(np.all(known[1:] >= known[:-1]))
        if found and isinstance(slots, range):
            group = self.reads.groups[self.reads.group(slots.start)]
            if self.reads.rows[group.row].step != "known":
                part = slots.start - group.first, slots.stop - group.first, slots.step
                self.reads.expect(self.reads.step(group.row, "entries", part), "ascending")
        return found

    def as_text(self):
        """A placeholder for the text of a number; only a path that then raises may use the text."""
        self.texts = True
        return "..."

    # -- conditions, which are ids or nodes

    def raises_if(self, condition, raising):
        """Record that the function raises where a condition holds.

        ``raising()`` raises the exception.
        If the user's code may catch the exception, the condition becomes a decision with two paths.
        """
        node = self.node(condition) if type(condition) is int else condition
        if node is self.false:
            return
        if node.op == "const":
            raising()
        if self.in_handler():
            if not node.varies:
                self.assume(node)
            if self.decide(node) if node.varies else node.value:
                raising()
            return
        self.raising = self.both(self.raising, node, "or")

    def in_handler(self):
        """Whether the user's code may catch an exception that is raised now."""
        return is_handled(self.until)

    def leaves_to_python_if(self, condition):
        """Leave the call to Python where a condition holds, even if the user catches exceptions."""
        node = self.node(condition) if type(condition) is int else condition
        if node is self.true:
            self.abandon("it leaves the range of its compiled form")
        if node is not self.false:
            self.raising = self.both(self.raising, node, "or")

    def stays_below(self, node):
        """Leave the call to Python where a condition holds; Taylor series ignore the condition.

        Such a condition tells that a number is beyond a limit of accuracy.
        """
        self.sizes = self.both(self.sizes, node, "or")

    def abandon(self, why):
        """Leave the rest of this path to Python."""
        self.abandoned = why
        raise Abandoned(why)

    def decide(self, node):
        """The truth of a condition on this path."""
        flip = node.op == "not"
        node = node.args[0] if flip else node
        if node.key not in self.decided:
            i = len(self.taken)
            if i >= MAX_DECISIONS:
                raise Refusal("it decides too often", final=True, said=False)
            value = self.script[i] if i < len(self.script) else True
            self.taken.append((node, value))
            self.decided[node.key] = value
        self._asked = self._asked + 1 if self.next == self._size else 0
        self._size = self.next
        if self._asked > MOST_ASKED:
            self.abandon("it decides the same without end")
        return self.decided[node.key] != flip
