"""Functions in C and in JavaScript, written from Python functions that are traced.

A parameter of the written function is a number that the Python function takes as an argument, or
reads from an argument that is an object.  All other values from outside are constants of the code.
"""

import dataclasses
from typing import Any, NamedTuple

from ...graph.expressions import live
from ...graph.refusal import Untraceable
from ...operations import OPERATIONS
from ...paths.places import line_of_operation, line_of_refusal
from ...paths.runs import trace
from .language import LANGUAGES
from .writer import Unwritable, Writer


class Written(NamedTuple):
    """A function in a language: its statements, the texts of its results, when it raises.

    `raises` is the condition, as text, under which the Python function raises an exception; "" if
    there is none.  The results are not meaningful there.
    """

    lines: list
    results: list
    raises: str
    tables: dict


class NotExported(ValueError):
    """A function cannot be written in a language; the message says why, with the line."""


@dataclasses.dataclass
class Exported:
    """A Python function whose graph is known.

    Parameters
    ----------
    fun : callable
        ``fun(t, y, *args)``
    args : tuple
    n : int
        The number of components of y.
    shape : tuple or None
        The shape of the result; None for a number.
    places : dict
        The index in `p` of each parameter: by the position of an argument, from 1, or by the
        position and the name of an attribute of the argument.
    name : str
        In messages.
    """

    fun: Any
    args: tuple
    n: int
    shape: tuple | None
    places: dict
    name: str

    def __post_init__(self):
        varying = {place if isinstance(place, int) else place[0] for place in self.places}
        try:
            self.trace = trace(self.fun, self.args, self.n, self.shape, sorted(varying))
        except Untraceable as reason:
            line = line_of_refusal(reason.__context__ or reason)
            raise NotExported(self._said("it cannot be exported", reason, line)) from None
        self.outputs = list(self.trace.outputs)
        self._p = self._parameters()

    def _said(self, what, why, line):
        at = f" ({line[0]}, line {line[1]})" if line else ""
        return f"`{self.name}`: {what}, because {why}{at}."

    def _parameters(self):
        """The index in `p` of each slot; a slot that is part of the code has none."""
        reads = self.trace.reads
        found = {}
        for group in reads.groups:
            index = self.places.get(place_of(reads.rows, group.row))
            if index is not None:
                for k in range(group.size):
                    found[group.first + k] = index + k
            for slot in range(group.first, group.first + group.size):
                if group.whole and slot in reads.fixed:
                    found.pop(slot, None)  # a whole number that decides is a constant of the code
        fixed = sorted(reads.fixed & found.keys())
        for node in reads.assumed.values():
            fixed += [slot for slot in _slots(node) if slot in found]
        if fixed:
            why = f"a decision of the code depends on parameter p[{found[fixed[0]]}]"
            raise NotExported(self._said("it cannot be exported", why, None))
        return found

    def parameter(self, slot):
        """The text of a parameter, or the number of a value from outside."""
        index = self._p.get(slot)
        return self.trace.graph.values[slot] if index is None else f"p[{index}]"

    def reads(self):
        """The indices in `p` of the parameters that the results depend on."""
        slots = {slot for node in [*self.outputs, self.trace.raising] for slot in _slots(node)}
        return {self._p[slot] for slot in slots if slot in self._p}

    def written(self, language, outputs=None):
        """The function in a language ("c", "js"), or other nodes of its graph.

        Raises
        ------
        NotExported
            If an operation has no form in the language; the message names its line.
        """
        writer = Writer(LANGUAGES[language], self.trace.graph, self.parameter)
        outputs = self.outputs if outputs is None else outputs
        try:
            *results, raises = writer.nodes([*outputs, self.trace.raising])
        except Unwritable as reason:
            line = line_of_operation(reason.node.op, self.fun, self.args, self.n, self.shape)
            what = f"it has no form in {LANGUAGES[language].name}"
            words = OPERATIONS[reason.node.op].words or reason.node.op
            name = reason.node.op.removeprefix("scipy_special_")
            called = "" if name in words else f", {name}"
            raise NotExported(self._said(what, f"it uses {words}{called}", line)) from None
        if raises == LANGUAGES[language].false:
            raises = ""
        return Written(writer.lines, results, raises, writer.tables)


def place_of(rows, row):
    """The place of a read: an argument's position, or (position, attribute); else None."""
    steps = []
    while row >= 0:
        steps.append(rows[row])
        row = rows[row].parent
    root, *rest = steps[::-1]
    if root.step != "root" or root.key == 0:
        return None
    if not rest:
        return root.key
    held = len(rest) == 2 and (rest[0].step, rest[0].key) == ("attribute", "__dict__")
    return (root.key, rest[1].key) if held and rest[1].step == "item" else None


def _slots(node):
    """The slots of the parameters that a node depends on."""
    return {one.data for one in live([node]) if one.op == "par"}
