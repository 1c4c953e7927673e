"""The graph of a trace together with the decisions of the current run."""

from typing import Any

import numpy as np

from ..graph.domains import WHOLE, bound
from ..graph.expressions import Graph
from ..graph.refusal import Abandoned, Refusal
from ..symbols.complex_pair import Pair
from ..symbols.conditions import Condition
from .handlers import is_handled

MAX_DECISIONS = 200


class Paths(Graph):
    """The graph of a trace together with the decisions of the current run.

    `script` prescribes the first decisions; `taken` lists all decisions as (node, truth).
    """

    reads: Any
    until: Any = None  # the code object of the function that calls the traced function
    start: Any = None  # time and state of the first call, if known

    def __init__(self):
        super().__init__()
        self.sizes = self.false
        self.begin(())

    def begin(self, script):
        self.script, self.known, self.taken, self.raising = script, {}, [], self.false
        self.texts, self.abandoned, self.conditions = False, None, False
        self.bounds = {}  # the bounds were checked on another path only

    def condition(self, node, python=False):
        """A Condition, or a plain truth value if parameters alone determine the node.

        `python` tells whether the Condition acts as a bool of Python or of NumPy.
        """
        if node.varies:
            return Condition(self, node, python)
        self.assume(node)
        return bool(node.value) if python else np.bool_(node.value)

    def pair(self, real, imag):
        """A complex number."""
        return Pair(real, imag)

    def assume(self, node):
        self.reads.assume(node)

    def is_array(self, slots):
        group = self.reads.groups[self.reads.group(slots[0])]
        return group.first == slots[0] and group.shape == (len(slots),)

    def as_text(self):
        """A placeholder for the text of a number; only a path that then raises may use the text."""
        self.texts = True
        return "..."

    def raises_if(self, node, raising):
        """Record that the function raises where a condition holds.

        ``raising()`` raises the exception.
        If the user's code may catch the exception, the condition becomes a decision with two paths.
        """
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

    def leaves_to_python_if(self, node):
        """Leave the call to Python where a condition holds, even if the user catches exceptions."""
        if node is self.true:
            self.abandon("it leaves the range of its compiled form")
        if node is self.false:
            return
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

    def keep_exact(self, node):
        """Leave the call to Python where a whole number is too large to be exact as a float."""
        if bound(self, node) <= WHOLE:
            return
        size = self.make("abs", (node,))
        if node.varies:
            self.leaves_to_python_if(self.compare(size, self.const(float(WHOLE)), "gt"))
        elif float(size.value or 0.0) > WHOLE:
            raise Refusal("a whole number beyond 2**53")
        else:
            self.reads.assume(self.compare(size, self.const(float(WHOLE)), "le"))
        self.bounds[node.key] = WHOLE

    def decide(self, node):
        """The truth of a condition on this path."""
        flip = node.op == "not"
        node = node.args[0] if flip else node
        if node.key not in self.known:
            i = len(self.taken)
            if i >= MAX_DECISIONS:
                raise Refusal("it decides too often", final=True, said=False)
            self.known[node.key] = self.script[i] if i < len(self.script) else True
            self.taken.append((node, self.known[node.key]))
        return self.known[node.key] != flip
